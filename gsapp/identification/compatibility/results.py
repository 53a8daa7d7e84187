"""What the compatibility check returns."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from gsapp.identification.results import ResponseFit, ResponseHistory

InstrumentParameterStatus = Literal["estimated", "not-observable"]
InstrumentVerdictKind = Literal[
    "reversed", "exchanged", "bias", "scale", "delay", "stuck", "disagreement", "unexplained"
]
SignStatus = Literal["right", "reversed", "not-observable"]


@dataclass(frozen=True, slots=True, kw_only=True)
class InstrumentParameter:
    """One error of one instrument.

    The instrument shows ``scale * truth(t - delay) + bias``.
    """

    value: float | None
    std: float | None = None
    """SI; a scale is a factor (1 is right), a delay is in s, relative to the gyros. None where the
    data cannot see it."""
    nominal: float = 0.0  # Of a faultless instrument: 1 for a scale, else 0.
    status: InstrumentParameterStatus = "estimated"
    why: str = ""  # In words, where it was not earned.


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
