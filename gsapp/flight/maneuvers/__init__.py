"""Maneuvers of a flight: finding, grading, naming and editing them."""

from gsapp.flight.maneuvers.detection import ManeuverDetector, detect, find_maneuvers
from gsapp.flight.maneuvers.editing import Edit, ManeuverBook, ManeuverLog
from gsapp.flight.maneuvers.found import GRADES, FoundManeuver, Grade
from gsapp.flight.maneuvers.given import (
    Assessor,
    FlightManeuvers,
    maneuvers_of,
    parse_windows,
    survey,
)
from gsapp.flight.maneuvers.noise import NoiseFloor

__all__ = [
    "GRADES",
    "Assessor",
    "Edit",
    "FlightManeuvers",
    "FoundManeuver",
    "Grade",
    "ManeuverBook",
    "ManeuverDetector",
    "ManeuverLog",
    "NoiseFloor",
    "detect",
    "find_maneuvers",
    "maneuvers_of",
    "parse_windows",
    "survey",
]
