"""What the virtual aircraft's box tells the crew, in words."""

from __future__ import annotations

from typing import Final

from gsapp.virtual.handover_phases import RECOVERY_PHASE, TRAINEE_PHASE

_ANNOUNCEMENTS: Final = {
    "preflight": "Telemetry on, recording",
    "engines running": "Engines running",
    "range check": "Range check",
    "take-off": "Take-off run",
    "climb": "Airborne",
    "pattern": "In the pattern",
    "approach": "Approach",
    "landed": "Landed",
    "engines off": "Engines off",
    "crashed": "Crashed",
    TRAINEE_PHASE: "You have control",
    RECOVERY_PHASE: "I have control",
}
REPEATED_PHASES: Final = (TRAINEE_PHASE, RECOVERY_PHASE)
"""Phases that are told whenever they begin, not the first time alone."""


def phase_announcement(phase: str) -> str:
    """Return what the box tells the crew when a phase begins; empty for none.

    The box does not know of maneuvers: finding those is the ground's affair.
    """
    return _ANNOUNCEMENTS.get(phase, "")
