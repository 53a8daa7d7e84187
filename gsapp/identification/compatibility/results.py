"""What the compatibility check returns, and numbers and names as a crew says them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from gsapp.identification.compatibility.settings import ACCELERATION_CHANNELS, RATE_CHANNELS
from gsapp.identification.results import ResponseFit, ResponseHistory
from gsapp.quantities import channel
from gsapp.quantities.constants import DEGREE, GRAVITY

InstrumentParameterStatus = Literal["estimated", "not-observable", "not-needed"]
InstrumentVerdictKind = Literal[
    "reversed",
    "exchanged",
    "bias",
    "scale",
    "delay",
    "position",
    "stuck",
    "disagreement",
    "unexplained",
]
SignStatus = Literal["right", "reversed", "not-observable"]


@dataclass(frozen=True, slots=True, kw_only=True)
class InstrumentParameter:
    """One error of one instrument.

    The instrument shows ``scale * truth(t - delay) + bias``; a position (m) is how far its vane is
    ahead of where the aircraft file puts it.
    """

    value: float | None
    std: float | None = None
    """SI; a scale is a factor (1 is right), a delay is in s, relative to the gyros. None where the
    data cannot see it."""
    nominal: float = 0.0  # Of a faultless instrument: 1 for a scale, else 0.
    status: InstrumentParameterStatus = "estimated"
    why: str = ""  # In words, where it was not estimated.


@dataclass(frozen=True, slots=True, kw_only=True)
class InstrumentVerdict:
    """What is wrong with an instrument."""

    kind: InstrumentVerdictKind
    channels: tuple[str, ...]  # The instrument, or those that contradict one another.
    sentence: str  # For the crew.
    value: float | None = None
    std: float | None = None
    """The estimated error, where the kind has one; as in `InstrumentParameter`."""
    before: float | None = None
    after: float | None = None
    """Residual (rms, SI) of the channel named in `seen_in` without and with the remedy."""
    seen_in: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class SensorComparison:
    """Two instruments for one quantity."""

    reference: str
    other: str
    """Channels, or what the quantity was made from."""
    bias: float  # Of the other against the reference where the reference shows its mean, SI.
    scale: float | None
    """Slope of the other over the reference; None where the quantity hardly moved."""
    delay: float | None  # How late the other is, s; None where the quantity hardly moved.
    noise: tuple[float, float] | None
    """Of the reference and the other each (rms, SI); None where a third instrument is needed to
    part them."""
    difference: float  # rms of the difference, SI.
    agree: bool
    sentence: str = ""  # What they disagree in; empty where they agree.


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CompatibilityResult:
    """Whether the instruments are consistent with one another."""

    maneuvers: tuple[str, ...]  # Ids of those that were used.
    parameters: Mapping[str, InstrumentParameter] = field(default_factory=dict)
    """By ``<channel>.<kind>``, of the motion with all `remedies` applied."""
    signs: Mapping[str, SignStatus] = field(default_factory=dict)
    """By channel, of those that were measured."""
    fit: Mapping[str, ResponseFit] = field(default_factory=dict)
    """By channel, over all maneuvers: measured against reconstructed, errors corrected."""
    histories: tuple[ResponseHistory, ...] = ()
    """Measured and reconstructed V, alpha, beta, phi, theta (those measured, as their instruments
    should show them), one for each unbroken stretch."""
    reconstructed: tuple[ResponseHistory, ...] = ()
    """The same stretches: V, alpha, beta at the center of gravity, p, q, r, phi, theta freed of
    instrument errors (`computed`), beside the readings (`measured`)."""
    noise: Mapping[str, float] = field(default_factory=dict)
    """White noise of each channel, rms of a sample, SI."""
    gust: Mapping[str, float] = field(default_factory=dict)
    """Motion of the air along u, v, w that explains what is left, as the rms change of the air's
    speed over one second, m/s."""
    verdicts: tuple[InstrumentVerdict, ...] = ()
    """Empty where the instruments agree: what is wrong then is the model."""
    comparisons: tuple[SensorComparison, ...] = ()  # Redundant instruments.
    remedies: tuple[str, ...] = ()
    """Signs turned and channels exchanged, in words of `verdicts`: ``-ay``, ``p<>r``."""
    iterations: int = 0
    converged: bool = True  # False where the instruments could not be compared.
    warnings: tuple[str, ...] = ()  # Sentences for the crew.
    summary: str = ""  # One sentence.

    @property
    def consistent(self) -> bool:
        return self.converged and not self.verdicts


_SHORT = {"ax": "a_x", "ay": "a_y", "an": "a_n"}


def channel_title(name: str) -> str:
    """Return a channel as spoken of: ``a_y``, ``beta``."""
    return _SHORT.get(name, name)


def _display_unit(name: str) -> tuple[float, str]:
    """Return what a value of a channel is divided by to be shown, and its unit."""
    base = name.partition(".")[0]
    if base in RATE_CHANNELS:
        return DEGREE, "deg/s"
    if base in ACCELERATION_CHANNELS:
        return GRAVITY, "g"
    unit = channel(base).unit
    return (DEGREE, "deg") if unit == "rad" else (1.0, unit)


def format_quantity(name: str, value: float) -> str:
    """Return a value of a channel with its unit: degrees, g, m/s."""
    divisor, unit = _display_unit(name)
    return f"{value / divisor:.2g} {unit}"


def format_error(parameter: str, value: float) -> str:
    """Return the value of an error, ``alpha.delay``, with its unit."""
    name, _, kind = parameter.partition(".")
    if kind == "scale":
        return f"{value:.3g}"
    if kind == "position":
        return f"{value:.2g} m"
    return f"{1e3 * value:z.0f} ms" if kind == "delay" else format_quantity(name, value)


def format_error_with_bound(parameter: str, value: float, std: float) -> tuple[str, str]:
    """Return the value of an error and its bound, both with two digits of the bound."""
    name, _, kind = parameter.partition(".")
    units = {"scale": (1.0, ""), "delay": (1e-3, "ms"), "position": (1.0, "m")}
    divisor, unit = units.get(kind) or _display_unit(name)
    std /= divisor
    digits = max(0, 1 - math.floor(math.log10(std))) if 0.0 < std < math.inf else 3
    value_text, std_text = f"{value / divisor:z.{digits}f}", f"{std:.{digits}f}"
    return f"{value_text} {unit}".rstrip(), f"{std_text} {unit}".rstrip()
