"""Phases of a training flight in which the sticks change hands."""

from __future__ import annotations

from typing import Final

TRAINEE_PHASE: Final = "you have control"
RECOVERY_PHASE: Final = "I have control"
