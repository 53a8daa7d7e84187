"""What the virtual aircraft's box tells the crew, in words."""

from __future__ import annotations

from typing import Final

from gsapp.dynamics.pilot.handover import RECOVERING, TRAINEE

_ANNOUNCEMENTS: Final = {
    "preflight": "Box on, recording",
    "engines running": "Engines running",
    "range check": "Range check",
    "take-off": "Take-off run",
    "climb": "Airborne",
    "pattern": "In the pattern",
    "approach": "Approach",
    "landed": "Landed",
    "engines off": "Engines off",
    "crashed": "Crashed",
    TRAINEE: "You have it",
    RECOVERING: "I have it",
}
EVERY_TIME: Final = (TRAINEE, RECOVERING)
"""Phases that are told whenever they begin, not the first time alone."""


def announcement(phase: str) -> str:
    """Return what the box tells the crew when a phase begins; empty for none.

    The box does not know of maneuvers: finding those is the ground's affair.
    """
    return _ANNOUNCEMENTS.get(phase, "")
