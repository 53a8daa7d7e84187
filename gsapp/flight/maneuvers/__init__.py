"""Maneuvers of a flight: finding, grading, naming and editing them."""

from gsapp.flight.maneuvers.detection import ManeuverDetector, detect, find_maneuvers
from gsapp.flight.maneuvers.found import GRADES, FoundManeuver, Grade
from gsapp.flight.maneuvers.noise import NoiseFloor

__all__ = [
    "GRADES",
    "FoundManeuver",
    "Grade",
    "ManeuverDetector",
    "NoiseFloor",
    "detect",
    "find_maneuvers",
]
