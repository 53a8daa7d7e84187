"""What the charts are told besides samples, and how it reads: spans, marks, symbols, values."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, Protocol

from gsapp.quantities import ChannelSpec, Values, from_si
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


class OriginInfo(Protocol):
    """What is known of a channel's origin."""

    @property
    def kind(self) -> str:
        """Return ``measured``, ``estimated`` or ``derived``."""

    @property
    def calibrated(self) -> bool:
        """Return whether a calibration was in force."""

    @property
    def calibrated_ranges(self) -> Mapping[str, tuple[float, float]]:
        """Return the values (SI) that the instruments behind it were calibrated for."""


class ChannelLimits(Protocol):
    """Limits of a channel, SI; `gsapp.session.limits.LimitBands` fits."""

    @property
    def warning_low(self) -> float | None:
        """Return the value below which it is a warning."""

    @property
    def caution_low(self) -> float | None:
        """Return the value below which it is a caution."""

    @property
    def caution_high(self) -> float | None:
        """Return the value above which it is a caution."""

    @property
    def warning_high(self) -> float | None:
        """Return the value above which it is a warning."""


def find_limit_state(value: float, limits: ChannelLimits | None) -> tuple[LimitState, str]:
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
