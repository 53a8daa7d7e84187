"""What the compatibility check returns."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from gsapp.identification.results import ResponseFit, ResponseHistory

InstrumentParameterStatus = Literal["estimated", "not-observable"]
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

    Attributes
    ----------
    value, std : float or None
        SI; a scale is a factor (1 is right), a delay is in s, relative to the gyros. None where
        the data cannot see it.
    nominal : float
        Of a faultless instrument: 1 for a scale, else 0.
    status : {"estimated", "not-observable"}
    why : str
        In words, where it was not earned.
    """

    value: float | None
    std: float | None = None
    nominal: float = 0.0
    status: InstrumentParameterStatus = "estimated"
    why: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class InstrumentVerdict:
    """What is wrong with an instrument.

    Attributes
    ----------
    kind : str
    channels : tuple of str
        The instrument, or those that contradict one another.
    sentence : str
        For the crew.
    value, std : float or None
        The estimated error, where the kind has one; as in `InstrumentParameter`.
    before, after : float or None
        Residual (rms, SI) of the channel named in `seen_in` without and with the remedy.
    seen_in : str
    """

    kind: InstrumentVerdictKind
    channels: tuple[str, ...]
    sentence: str
    value: float | None = None
    std: float | None = None
    before: float | None = None
    after: float | None = None
    seen_in: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class SensorComparison:
    """Two instruments for one quantity.

    Attributes
    ----------
    reference, other : str
        Channels, or what the quantity was made from.
    bias : float
        Of the other against the reference where the reference shows its mean, SI.
    scale : float or None
        Slope of the other over the reference; None where the quantity hardly moved.
    delay : float or None
        How late the other is, s; None where the quantity hardly moved.
    noise : tuple of float or None
        Of the reference and the other each (rms, SI); None where a third instrument is needed to
        part them.
    difference : float
        rms of the difference, SI.
    agree : bool
    sentence : str
        What they disagree in; empty where they agree.
    """

    reference: str
    other: str
    bias: float
    scale: float | None
    delay: float | None
    noise: tuple[float, float] | None
    difference: float
    agree: bool
    sentence: str = ""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CompatibilityResult:
    """Whether the instruments are consistent with one another.

    Attributes
    ----------
    maneuvers : tuple of str
        Ids of those that were used.
    parameters : mapping of str to InstrumentParameter
        By ``<channel>.<kind>``, of the motion with all `remedies` applied.
    signs : mapping of str to {"right", "reversed", "not-observable"}
        By channel, of those that were measured.
    fit : mapping of str to ResponseFit
        By channel, over all maneuvers: measured against reconstructed, errors corrected.
    histories : tuple of ResponseHistory
        Measured and reconstructed V, alpha, beta, phi, theta (those measured, as their
        instruments should show them), one for each unbroken stretch.
    reconstructed : tuple of ResponseHistory
        The same stretches: V, alpha, beta at the center of gravity, p, q, r, phi, theta freed of
        instrument errors (`computed`), beside the readings (`measured`).
    noise : mapping of str to float
        White noise of each channel, rms of a sample, SI.
    gust : mapping of str to float
        Motion of the air along u, v, w that explains what is left, as the rms change of the air's
        speed over one second, m/s.
    verdicts : tuple of InstrumentVerdict
        Empty where the instruments agree: what is wrong then is the model.
    comparisons : tuple of SensorComparison
        Redundant instruments.
    remedies : tuple of str
        Signs turned and channels exchanged, in words of `verdicts`: ``-ay``, ``p<>r``.
    iterations : int
    converged : bool
        False where the instruments could not be compared.
    warnings : tuple of str
        Sentences for the crew.
    summary : str
        One sentence.
    """

    maneuvers: tuple[str, ...]
    parameters: Mapping[str, InstrumentParameter] = field(default_factory=dict)
    signs: Mapping[str, SignStatus] = field(default_factory=dict)
    fit: Mapping[str, ResponseFit] = field(default_factory=dict)
    histories: tuple[ResponseHistory, ...] = ()
    reconstructed: tuple[ResponseHistory, ...] = ()
    noise: Mapping[str, float] = field(default_factory=dict)
    gust: Mapping[str, float] = field(default_factory=dict)
    verdicts: tuple[InstrumentVerdict, ...] = ()
    comparisons: tuple[SensorComparison, ...] = ()
    remedies: tuple[str, ...] = ()
    iterations: int = 0
    converged: bool = True
    warnings: tuple[str, ...] = ()
    summary: str = ""

    @property
    def consistent(self) -> bool:
        """Return whether a fit that converged finds fault with no instrument."""
        return self.converged and not self.verdicts
