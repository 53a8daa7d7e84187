"""Maneuvers of a flight: finding, grading, naming and editing them."""

from gsapp.flight.maneuvers.detected_maneuver import (
    GRADED_BY_CREW,
    GRADED_BY_PROGRAM,
    GRADES,
    DetectedManeuver,
    Grade,
)
from gsapp.flight.maneuvers.detection import ManeuverDetector, detect_maneuvers, run_detector
from gsapp.flight.maneuvers.flight_maneuvers import (
    FlightManeuvers,
    ManeuverAssessor,
    RecordedVerdict,
    apply_verdicts,
    collect_maneuvers,
    explain_no_maneuvers,
    parse_maneuver_windows,
    read_recorded_verdicts,
    surface_remarks,
    uncalibrated_text,
)
from gsapp.flight.maneuvers.maneuver_list import (
    EditableManeuverList,
    ManeuverEditLog,
    apply_edits,
)
from gsapp.flight.maneuvers.noise_floor import NoiseFloor

__all__ = [
    "GRADED_BY_CREW",
    "GRADED_BY_PROGRAM",
    "GRADES",
    "DetectedManeuver",
    "EditableManeuverList",
    "FlightManeuvers",
    "Grade",
    "ManeuverAssessor",
    "ManeuverDetector",
    "ManeuverEditLog",
    "NoiseFloor",
    "RecordedVerdict",
    "apply_edits",
    "apply_verdicts",
    "collect_maneuvers",
    "detect_maneuvers",
    "explain_no_maneuvers",
    "parse_maneuver_windows",
    "read_recorded_verdicts",
    "run_detector",
    "surface_remarks",
    "uncalibrated_text",
]
