"""What the search for a missing effect returns: everything that is told, drawn or written.

One `DiscrepancyResult` holds the answer; its `steps` tell the story from the baseline to the
revised model, its `maneuvers` the histories behind every picture. All numbers are SI and radians.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from gsapp.dynamics.model import Model
from gsapp.dynamics.terms import EffectClass
from gsapp.quantities import FloatArray

DiscrepancyVerdict = Literal[
    "effects-found", "values-wrong", "model-adequate", "ambiguous", "unexplained", "not-observable"
]


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightRegion:
    """Where in the flight envelope a disagreement grows."""

    variable: str
    """``alpha``, ``beta``, ``V``, ``throttle``, ``de``, ``da``, ``dr``, ``flap``; ``q`` and so
    on."""
    low: float
    high: float
    """SI, radians."""
    words: str  # "alpha above 6 deg".


@dataclass(frozen=True, slots=True, kw_only=True)
class Disagreement:
    """One place where model and flight disagree beyond the noise."""

    coefficient: str  # CX, CY, CZ, Cl, Cm, Cn; empty where an instrument disagrees with the others.
    channel: str  # The measured channel in which it shows most.
    maneuver: str  # Its id.
    t_start: float
    t_end: float
    """s of flight time."""
    rms: float
    noise_floor: float
    """Of the missing part of the coefficient over that time, and what noise alone would give."""
    p_value: float
    """Chance of as much, corrected for all that was looked at; see
    `gsapp.discrepancy.localization.ModelErrorLocation`."""
    region: FlightRegion | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Observability:
    """What these flights could show of one effect of the catalog, said before any verdict."""

    effect: str
    effect_class: EffectClass
    sigma: float
    """Standard deviations that the effect's plausible size would show, after the baseline's own
    parameters have taken what they can."""
    sigma_size: float  # Size (first parameter) that would show one standard deviation.
    aliases: tuple[tuple[str, float], ...] = ()
    """Effects that look alike here, with the cosine, most alike first."""
    fly: str = ""
    """The maneuver that would show it, or tell it from its aliases; empty where none is needed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RankedCandidate:
    """One effect in the competition of one step."""

    effect: str  # Id; ``unnamed.Cm.alpha_de2`` for structure without a name.
    title: str
    score: float  # Gain of the log-likelihood by adding it, less what its parameters cost.
    evidence: float  # Its probability among all candidates, 0 to 1.
    held_out: float  # Gain of the log-likelihood on maneuvers left out of the fit.
    sigma: float  # Size over its standard deviation.


@dataclass(frozen=True, slots=True, kw_only=True)
class FoundEffect:
    """An effect that was proven."""

    effect: str
    title: str
    equation: str
    parameters: Mapping[str, tuple[float, float]]  # Value and standard deviation.
    confidence: float
    """Probability that this name is right; of those said with 0.9, nine in ten are."""
    runner_up: str = ""  # Next best candidate, empty where none came near.
    margin: float = 0.0  # Gain in log-likelihood over it.
    held_out: float = 0.0  # Gain of the log-likelihood on the maneuvers kept out.
    forced: bool = False  # Whether the user put it in.
    one_of: tuple[str, ...] = ()
    """Effects that it stands for, itself with them, where these flights cannot tell which it is."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ChangedValue:
    """A derivative whose value moved beyond its bounds."""

    before: float
    after: float
    std: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Alternative:
    """What else these flights would look the same with."""

    effects: tuple[str, ...]  # One effect, or several that act together.
    title: str
    why: str
    fly: str  # The maneuver, or the measurement on the ground, that would tell.


@dataclass(frozen=True, slots=True, kw_only=True)
class ChannelGap:
    """Residual of one channel on the maneuvers kept out, RMS."""

    before: float
    after: float
    floor: float
    """RMS of measured minus computed, and of the noise alone."""
    before_pct: float
    after_pct: float
    """RMS over the range, percent, as in tables 7.4.1 and 7.4.2."""
    theil_before: float
    theil_after: float
    within_before: float
    within_after: float
    """Share of samples within three noise floors."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Gap:
    """The gap between model and flight on maneuvers kept out of naming and fitting."""

    channels: Mapping[str, ChannelGap]
    closed: float | None
    closed_std: float | None
    """Share of the reducible gap that was closed (1: all down to the noise), and its standard
    deviation; None where there was nothing to close."""
    on: tuple[str, ...]  # Ids of the maneuvers kept out.


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ModelStep:
    """One model on the way from the baseline (step 0) to the revised one."""

    model: Model
    added: str  # Id of the effect that this step added; empty for the baseline.
    ranking: tuple[RankedCandidate, ...]
    """Of the competition that this step's model then faced, best first: what to add next."""
    coefficient_map: FloatArray
    """Shape (n_maneuvers, n_coefficients). Missing part of each coefficient in units of the noise
    floor (1: nothing but noise)."""
    gap: Mapping[str, float]  # RMS over the noise floor on the maneuvers kept out, by channel.
    misfit: float  # Of all channels together, on the maneuvers kept out; 1 at the floor.


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ManeuverHistories:
    """Histories of one maneuver."""

    id: str
    flight: str
    kind: str
    held_out: bool
    times: FloatArray  # Shape (n,).
    channels: tuple[str, ...]
    measured: FloatArray  # Shape (n, n_channels). NaN where a sample did not count.
    computed: tuple[FloatArray, ...]  # Shape (n, n_channels). One for each step.
    coefficients: tuple[str, ...]
    missing: tuple[FloatArray, ...]
    """Shape (n, n_coefficients). For each step, the part of each coefficient that its model lacks,
    low-passed."""
    noise_floor: Mapping[str, float]  # Noise floor of each channel.
    coefficient_noise_floor: Mapping[str, float]
    conditions: Mapping[str, FloatArray]
    """Shape (n,). alpha, beta, V, throttle, de, da, dr, flap where they are known."""


@dataclass(frozen=True, slots=True, kw_only=True)
class InstrumentRemark:
    """What the data compatibility check says of one instrument."""

    channel: str  # Or several, with commas.
    words: str
    consistent: bool
    effect: str = ""
    """Of the catalog, where kinematics alone prove it: a turned axis, two that are swapped."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DiscrepancyResult:
    """The answer."""

    verdict: DiscrepancyVerdict
    why: str  # Plain words.
    disagreements: tuple[Disagreement, ...]  # Of the baseline, most significant first.
    observability: tuple[Observability, ...]
    steps: tuple[ModelStep, ...]  # The baseline first.
    effects: tuple[FoundEffect, ...]
    values: Mapping[str, ChangedValue]
    alternatives: tuple[Alternative, ...]
    disturbance: Mapping[str, float]  # ``gust``: rms of turbulence, m/s; with ``gust_std``.
    gap: Gap
    maneuvers: tuple[ManeuverHistories, ...]
    coefficients: tuple[str, ...]
    channels: tuple[str, ...]
    """Order of the maps and histories."""
    instruments: tuple[InstrumentRemark, ...] = ()
    warnings: tuple[str, ...] = ()

    @property
    def ranking(self) -> tuple[RankedCandidate, ...]:
        return self.steps[0].ranking if self.steps else ()

    @property
    def model(self) -> Model:
        return self.steps[-1].model
