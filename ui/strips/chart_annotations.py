"""What the charts are told besides samples, and how it reads: spans, marks, symbols, values."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from gsapp.quantities import ChannelSpec, Values, from_si
from gsapp.session.limits import LimitBands
from ui.translation import tr

SpanKind = Literal["maneuver", "event"]
LimitState = Literal["", "caution", "warning"]


@dataclass(frozen=True, slots=True, kw_only=True)
class ChartSpan:
    """A labeled stretch across all charts; without `stop` it still goes on."""

    label: str
    start: float
    stop: float | None = None
    kind: SpanKind = "maneuver"


@dataclass(frozen=True, slots=True, kw_only=True)
class ChartMark:
    """A labeled moment."""

    label: str
    time: float


@dataclass(frozen=True, slots=True, kw_only=True)
class AlarmSpan:
    """An alarm from its onset until its cause was gone; without `stop` it still is there."""

    # Flight times, s.
    start: float
    stop: float | None = None
    state: LimitState  # The worst.
    channel: str = ""  # Whose limit it is; empty for other alarms.


@dataclass(frozen=True, slots=True)
class ChannelOrigin:
    """Where a channel comes from, as charts show it.

    A value that the aircraft sends in engineering units wants no certificate of ours: only what
    should have one and has none is called uncalibrated.
    """

    kind: str  # ``measured``, ``estimated`` or ``derived``.
    calibrated: bool  # Whether what should have a certificate has one.
    # What the instruments behind it were calibrated for, SI; beyond it their curves go on straight.
    calibrated_ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)


def find_limit_state(value: float, limits: LimitBands | None) -> tuple[LimitState, str]:
    """Return the state of a value (SI) and the word for its side."""
    if limits is None or math.isnan(value):
        return "", ""
    states: tuple[tuple[LimitState, float | None, float | None], ...] = (
        ("warning", limits.warning_low, limits.warning_high),
        ("caution", limits.caution_low, limits.caution_high),
    )
    for state, low, high in states:
        if low is not None and value < low:
            return state, tr("LOW")
        if high is not None and value > high:
            return state, tr("HIGH")
    return "", ""


@dataclass(frozen=True, slots=True)
class DisplayFormat:
    """How a channel's values are shown: displayed = factor * SI + offset.

    `step` is the smallest difference that the sensor earns, displayed.
    """

    unit: str
    factor: float
    offset: float
    decimals: int
    step: float

    @classmethod
    def for_channel(cls, spec: ChannelSpec, system: str) -> DisplayFormat:
        unit = spec.display_unit(system)
        offset = float(from_si(0.0, unit, spec.quantity))
        # From far apart, so that a large offset does not eat the factor's digits.
        factor = (float(from_si(1e6, unit, spec.quantity)) - offset) / 1e6
        return cls(
            unit=unit,
            factor=factor,
            offset=offset,
            decimals=spec.decimals(unit),
            step=abs(factor) * spec.precision,
        )

    def to_display(self, values: Values) -> Values:
        return self.factor * values + self.offset

    def to_si(self, shown: float) -> float:
        return (shown - self.offset) / self.factor

    @property
    def min_span(self) -> float:
        """Return the smallest span of an automatic axis: 20 steps of the sensor."""
        return 20.0 * self.step
