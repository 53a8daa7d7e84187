"""Derivatives while a flight happens: fits of its maneuvers, a moment after each."""

from gsapp.session.estimating.maneuver_fits import FitNews, ManeuverFits
from gsapp.session.estimating.workers import AtOnce, OtherProcess, Workers

__all__ = ["AtOnce", "FitNews", "ManeuverFits", "OtherProcess", "Workers"]
