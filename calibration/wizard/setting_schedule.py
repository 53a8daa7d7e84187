"""The settings that an instrument is brought to, in order: up, then down."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from calibration.plan import InstrumentPlan
from calibration.polynomial_fit import Direction

CalibrationMode = Literal["full", "check"]


@dataclass(frozen=True, slots=True, kw_only=True)
class ScheduledSetting:
    """One setting to be taken."""

    value: float
    """In the unit of the plan."""
    direction: Direction
    """From which side it is to be reached; ``single`` where that does not matter."""
    is_turning_point: bool = False
    """Whether the side changes here: the setting has to be passed first and come back to."""


def build_schedule(
    instrument: InstrumentPlan, mode: CalibrationMode, *, any_side: bool = False
) -> tuple[ScheduledSetting, ...]:
    """Return the settings of an instrument: all of them up and down, or the check's three.

    Parameters
    ----------
    mode : {"full", "check"}
        What for.
    any_side : bool
        Whether a check may come to a setting from either side: where the certificate tells how
        far the branches are apart, none has to be passed first.
    """
    if mode == "check" and any_side:
        return tuple(
            ScheduledSetting(value=value, direction="single") for value in instrument.check_settings
        )
    if mode == "check":
        return _leg(instrument.check_settings, "up")
    return _leg(instrument.settings, "up") + _leg(instrument.settings[::-1], "down")


def _leg(values: tuple[float, ...], direction: Direction) -> tuple[ScheduledSetting, ...]:
    return tuple(
        ScheduledSetting(value=value, direction=direction, is_turning_point=at == 0)
        for at, value in enumerate(values)
    )
