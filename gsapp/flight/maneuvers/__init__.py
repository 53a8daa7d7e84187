"""Maneuvers of a flight: finding, grading, naming and editing them."""

from gsapp.flight.maneuvers.detection import ManeuverDetector, detect, find_maneuvers
from gsapp.flight.maneuvers.edit_log import ManeuverLog, standing
from gsapp.flight.maneuvers.editing import Edit, ManeuverBook
from gsapp.flight.maneuvers.found import CREW, GRADES, PROGRAM, FoundManeuver, Grade
from gsapp.flight.maneuvers.given import (
    Assessor,
    FlightManeuvers,
    RecordedVerdict,
    after_verdicts,
    maneuvers_of,
    parse_windows,
    recorded_verdicts,
    surface_remarks,
    survey,
    uncalibrated_words,
    why_none,
)
from gsapp.flight.maneuvers.noise import NoiseFloor

__all__ = [
    "CREW",
    "GRADES",
    "PROGRAM",
    "Assessor",
    "Edit",
    "FlightManeuvers",
    "FoundManeuver",
    "Grade",
    "ManeuverBook",
    "ManeuverDetector",
    "ManeuverLog",
    "NoiseFloor",
    "RecordedVerdict",
    "after_verdicts",
    "detect",
    "find_maneuvers",
    "maneuvers_of",
    "parse_windows",
    "recorded_verdicts",
    "standing",
    "surface_remarks",
    "survey",
    "uncalibrated_words",
    "why_none",
]
