"""Fourier transform regression: derivatives with bounds in flight, and from maneuvers after it."""

from gsapp.identification.ftr.estimates import EstimateHistory
from gsapp.identification.ftr.maneuver_estimator import estimate
from gsapp.identification.ftr.online_regression import FTR
from gsapp.identification.ftr.settings import FrequencyBand, FTRSettings

__all__ = ["FTR", "EstimateHistory", "FTRSettings", "FrequencyBand", "LiveEstimate", "estimate"]
