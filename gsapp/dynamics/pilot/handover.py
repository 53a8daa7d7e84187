"""Phases of a training flight in which the sticks change hands."""

from __future__ import annotations

from typing import Final

TRAINEE: Final = "you have it"
RECOVERING: Final = "I have it"
