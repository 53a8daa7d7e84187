"""What goes wrong in an instrument: samples that drop out, stick, or are cut off.

A fault stands in the plan of a flight (``[[faults]]``) or is given beside it in one line,
``CHANNEL:KIND[:PARAM=VALUE,..]``. It acts on what the instrument hands to the converter, so that
the ground sees it as it would a loose wire or a jammed vane.
"""

from __future__ import annotations

import math
import sys
from typing import Any, Literal

import numpy as np
from pydantic import Field, ValidationInfo, field_validator, model_validator

from gsapp.foundation import FileProblemsError, FlightError, StrictModel
from gsapp.foundation.name_suggestions import did_you_mean
from gsapp.foundation.toml import validate_content
from gsapp.quantities import FloatArray, channel, parse_quantity
from gsapp.quantities.fields import Time
from gsapp.virtual.ad_converter import DAQ_CHANNELS

_NEVER = sys.maxsize


class SensorFault(StrictModel):
    """One thing that goes wrong with one instrument."""

    channel: str  # The input of the converter: one of `gsapp.virtual.ad_converter.DAQ_CHANNELS`.
    kind: Literal["dropout", "stuck", "clip"]
    """``dropout``: the input is open, which the converter reads as 0 V. ``stuck``: the sample at
    its beginning is repeated. ``clip``: nothing beyond `low` and `high` is shown."""
    start: Time = 0.0
    end: Time = math.inf
    """When it may act, s since the box was switched on."""
    every: Time | None = Field(default=None, gt=0.0)
    length: Time | None = Field(default=None, gt=0.0)
    """It comes and goes: mean time from one end to the next beginning, and mean duration, s, both
    spread exponentially. Without them it acts from `start` to `end`."""
    low: float | None = None
    high: float | None = None
    """What ``clip`` cuts off, in the SI unit of the channel."""

    @field_validator("channel")
    @classmethod
    def _is_measured(cls, value: str) -> str:
        if value not in DAQ_CHANNELS:
            hint = did_you_mean(value, DAQ_CHANNELS, f"choose one of {', '.join(DAQ_CHANNELS)}")
            raise ValueError(f"no instrument measures '{value}'; {hint}")
        return value

    @field_validator("low", "high", mode="before")
    @classmethod
    def _with_unit(cls, value: Any, info: ValidationInfo) -> Any:
        known = info.data.get("channel")
        if value is None or known is None:  # without a channel there is that to say already
            return None
        return parse_quantity(value, channel(known).quantity)

    @model_validator(mode="after")
    def _hangs_together(self) -> SensorFault:
        if not self.start < self.end:
            raise ValueError("it ends before it begins; swap 'start' and 'end'")
        if (self.every is None) != (self.length is None):
            raise ValueError("'every' and 'length' belong together; give both, or neither")
        cuts = self.low is not None or self.high is not None
        if cuts != (self.kind == "clip"):
            raise ValueError("'low' and 'high' belong to clip; give it one or both of them")
        if self.low is not None and self.high is not None and not self.low < self.high:
            raise ValueError("the lower end comes first; swap 'low' and 'high'")
        return self


def parse_sensor_fault(text: str) -> SensorFault:
    """Read a fault from one line, such as ``alpha:stuck:start=60 s,end=75 s``.

    Raise FlightError if it says something else.
    """
    channel_id, _, rest = text.partition(":")
    kind, _, rest = rest.partition(":")
    content = {"channel": channel_id.strip(), "kind": kind.strip()}
    for pair in rest.split(",") if rest else ():
        name, equals, value = pair.partition("=")
        if not equals:
            raise FlightError(
                f"'{pair}' in '{text}' is not PARAM=VALUE; write for example "
                "alpha:dropout:every=20 s,length=0.1 s"
            )
        content[name.strip()] = value.strip()
    try:
        return validate_content("fault", content, SensorFault)
    except FileProblemsError as error:
        said = ". ".join(str(problem) for problem in error.problems)
        raise FlightError(f"'{text}' is not a fault: {said}") from error


class SensorFaultInjector:
    """A fault at work, stretch after stretch, on samples `dt` s apart."""

    def __init__(self, fault: SensorFault, dt: float, random: np.random.Generator) -> None:
        self.fault = fault
        self._dt = dt
        self._random = random
        self._last = self._index(fault.end)
        self._begin, self._end = self._index(fault.start), self._last
        self._held = math.nan
        if fault.every is not None:
            self._end = self._begin
            self._await_next()

    def apply(self, shown: FloatArray, first: int) -> FloatArray:
        """Return what remains of successive samples, shape (n,); `first` counts from the start."""
        values = shown.copy()
        after = first + len(values)
        while self._begin < after:
            begin, end = max(self._begin, first), min(self._end, after)
            self._harm(values[begin - first : end - first], begins=begin == self._begin)
            if self._end > after:
                break
            self._await_next()
        return values

    def _harm(self, values: FloatArray, *, begins: bool) -> None:
        if self.fault.kind == "dropout":
            values[:] = math.nan
        elif self.fault.kind == "stuck":
            if begins:
                self._held = float(values[0])
            values[:] = self._held
        else:
            np.clip(values, self.fault.low, self.fault.high, out=values)

    def _await_next(self) -> None:
        every, length = self.fault.every, self.fault.length
        if every is None or length is None:
            self._begin = self._end = _NEVER
            return
        gap, duration = self._random.exponential((every, length))
        self._begin = self._end + max(round(gap / self._dt), 1)
        self._end = min(self._begin + max(round(duration / self._dt), 1), self._last)
        if self._begin >= self._last:
            self._begin = self._end = _NEVER

    def _index(self, time: float) -> int:
        return round(time / self._dt) if math.isfinite(time) else _NEVER
