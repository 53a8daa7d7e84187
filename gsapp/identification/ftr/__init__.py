"""Fourier transform regression: derivatives with bounds in flight, and from maneuvers after it."""

from gsapp.identification.ftr.estimates import EstimateHistory, LiveEstimate
from gsapp.identification.ftr.maneuvers import estimate
from gsapp.identification.ftr.online import FTR
from gsapp.identification.ftr.settings import Band, FTRSettings

__all__ = ["FTR", "Band", "EstimateHistory", "FTRSettings", "LiveEstimate", "estimate"]
