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
    """Where in the flight envelope a disagreement grows.

    Attributes
    ----------
    variable : str
        ``alpha``, ``beta``, ``V``, ``throttle``, ``de``, ``da``, ``dr``, ``flap``; ``q`` and so on.
    low, high : float
        SI, radians.
    words : str
        "alpha above 6 deg".
    """

    variable: str
    low: float
    high: float
    words: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Disagreement:
    """One place where model and flight disagree beyond the noise.

    Attributes
    ----------
    coefficient : str
        CX, CY, CZ, Cl, Cm, Cn; empty where an instrument disagrees with the others.
    channel : str
        The measured channel in which it shows most.
    maneuver : str
        Its id.
    t_start, t_end : float
        s of flight time.
    rms, noise_floor : float
        Of the missing part of the coefficient over that time, and what noise alone would give.
    p_value : float
        Chance of as much, corrected for all that was looked at; see
        `gsapp.discrepancy.localization.ModelErrorLocation`.
    region : FlightRegion or None
    """

    coefficient: str
    channel: str
    maneuver: str
    t_start: float
    t_end: float
    rms: float
    noise_floor: float
    p_value: float
    region: FlightRegion | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Observability:
    """What these flights could show of one effect of the catalog, said before any verdict.

    Attributes
    ----------
    effect : str
    effect_class : {"A", "B", "C"}
    sigma : float
        Standard deviations that the effect's plausible size would show, after the baseline's own
        parameters have taken what they can.
    sigma_size : float
        Size (first parameter) that would show one standard deviation.
    aliases : tuple of (str, float)
        Effects that look alike here, with the cosine, most alike first.
    fly : str
        The maneuver that would show it, or tell it from its aliases; empty where none is needed.
    """

    effect: str
    effect_class: EffectClass
    sigma: float
    sigma_size: float
    aliases: tuple[tuple[str, float], ...] = ()
    fly: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class RankedCandidate:
    """One effect in the competition of one step.

    Attributes
    ----------
    effect : str
        Id; ``unnamed.Cm.alpha_de2`` for structure without a name.
    title : str
    score : float
        Gain of the log-likelihood by adding it, less what its parameters cost.
    evidence : float
        Its probability among all candidates, 0 to 1.
    held_out : float
        Gain of the log-likelihood on maneuvers left out of the fit.
    sigma : float
        Size over its standard deviation.
    """

    effect: str
    title: str
    score: float
    evidence: float
    held_out: float
    sigma: float


@dataclass(frozen=True, slots=True, kw_only=True)
class FoundEffect:
    """An effect that was proven.

    Attributes
    ----------
    effect, title, equation : str
    parameters : mapping of str to (float, float)
        Value and standard deviation.
    confidence : float
        Probability that this name is right; of those said with 0.9, nine in ten are.
    runner_up : str
        Next best candidate, empty where none came near.
    margin : float
        Gain in log-likelihood over it.
    held_out : float
        Gain of the log-likelihood on the maneuvers kept out.
    forced : bool
        Whether the user put it in.
    one_of : tuple of str
        Effects that it stands for, itself with them, where these flights cannot tell which it is.
    """

    effect: str
    title: str
    equation: str
    parameters: Mapping[str, tuple[float, float]]
    confidence: float
    runner_up: str = ""
    margin: float = 0.0
    held_out: float = 0.0
    forced: bool = False
    one_of: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class ChangedValue:
    """A derivative whose value moved beyond its bounds."""

    before: float
    after: float
    std: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Alternative:
    """What else these flights would look the same with.

    Attributes
    ----------
    effects : tuple of str
        One effect, or several that act together.
    title, why : str
    fly : str
        The maneuver, or the measurement on the ground, that would tell.
    """

    effects: tuple[str, ...]
    title: str
    why: str
    fly: str


@dataclass(frozen=True, slots=True, kw_only=True)
class ChannelGap:
    """Residual of one channel on the maneuvers kept out, RMS.

    Attributes
    ----------
    before, after, floor : float
        RMS of measured minus computed, and of the noise alone.
    before_pct, after_pct : float
        RMS over the range, percent, as in tables 7.4.1 and 7.4.2.
    theil_before, theil_after : float
    within_before, within_after : float
        Share of samples within three noise floors.
    """

    before: float
    after: float
    floor: float
    before_pct: float
    after_pct: float
    theil_before: float
    theil_after: float
    within_before: float
    within_after: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Gap:
    """The gap between model and flight on maneuvers kept out of naming and fitting.

    Attributes
    ----------
    channels : mapping of str to ChannelGap
    closed, closed_std : float or None
        Share of the reducible gap that was closed (1: all down to the noise), and its standard
        deviation; None where there was nothing to close.
    on : tuple of str
        Ids of the maneuvers kept out.
    """

    channels: Mapping[str, ChannelGap]
    closed: float | None
    closed_std: float | None
    on: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ModelStep:
    """One model on the way from the baseline (step 0) to the revised one.

    Attributes
    ----------
    model : Model
    added : str
        Id of the effect that this step added; empty for the baseline.
    ranking : tuple of RankedCandidate
        Of the competition that this step's model then faced, best first: what to add next.
    coefficient_map : ndarray, shape (n_maneuvers, n_coefficients)
        Missing part of each coefficient in units of the noise floor (1: nothing but noise).
    gap : mapping of str to float
        RMS over the noise floor on the maneuvers kept out, by channel.
    misfit : float
        Of all channels together, on the maneuvers kept out; 1 at the floor.
    """

    model: Model
    added: str
    ranking: tuple[RankedCandidate, ...]
    coefficient_map: FloatArray
    gap: Mapping[str, float]
    misfit: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ManeuverHistories:
    """Histories of one maneuver.

    Attributes
    ----------
    id, flight, kind : str
    held_out : bool
    times : ndarray, shape (n,)
    channels : tuple of str
    measured : ndarray, shape (n, n_channels)
        NaN where a sample did not count.
    computed : tuple of ndarray, shape (n, n_channels)
        One for each step.
    coefficients : tuple of str
    missing : tuple of ndarray, shape (n, n_coefficients)
        For each step, the part of each coefficient that its model lacks, low-passed.
    noise_floor : mapping of str to float
        Noise floor of each channel.
    coefficient_noise_floor : mapping of str to float
    conditions : mapping of str to ndarray, shape (n,)
        alpha, beta, V, throttle, de, da, dr, flap where they are known.
    """

    id: str
    flight: str
    kind: str
    held_out: bool
    times: FloatArray
    channels: tuple[str, ...]
    measured: FloatArray
    computed: tuple[FloatArray, ...]
    coefficients: tuple[str, ...]
    missing: tuple[FloatArray, ...]
    noise_floor: Mapping[str, float]
    coefficient_noise_floor: Mapping[str, float]
    conditions: Mapping[str, FloatArray]


@dataclass(frozen=True, slots=True, kw_only=True)
class InstrumentRemark:
    """What the data compatibility check says of one instrument.

    Attributes
    ----------
    channel : str
        Or several, with commas.
    words : str
    consistent : bool
    effect : str
        Of the catalog, where kinematics alone prove it: a turned axis, two that are swapped.
    """

    channel: str
    words: str
    consistent: bool
    effect: str = ""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DiscrepancyResult:
    """The answer.

    Attributes
    ----------
    verdict : str
    why : str
        Plain words.
    disagreements : tuple of Disagreement
        Of the baseline, most significant first.
    observability : tuple of Observability
    steps : tuple of ModelStep
        The baseline first.
    effects : tuple of FoundEffect
    values : mapping of str to ChangedValue
    alternatives : tuple of Alternative
    disturbance : mapping of str to float
        ``gust``: rms of turbulence, m/s; with ``gust_std``.
    gap : Gap
    maneuvers : tuple of ManeuverHistories
    coefficients, channels : tuple of str
        Order of the maps and histories.
    instruments : tuple of InstrumentRemark
    warnings : tuple of str
    """

    verdict: DiscrepancyVerdict
    why: str
    disagreements: tuple[Disagreement, ...]
    observability: tuple[Observability, ...]
    steps: tuple[ModelStep, ...]
    effects: tuple[FoundEffect, ...]
    values: Mapping[str, ChangedValue]
    alternatives: tuple[Alternative, ...]
    disturbance: Mapping[str, float]
    gap: Gap
    maneuvers: tuple[ManeuverHistories, ...]
    coefficients: tuple[str, ...]
    channels: tuple[str, ...]
    instruments: tuple[InstrumentRemark, ...] = ()
    warnings: tuple[str, ...] = ()

    @property
    def ranking(self) -> tuple[RankedCandidate, ...]:
        """Return the competition that the baseline faced."""
        return self.steps[0].ranking if self.steps else ()

    @property
    def model(self) -> Model:
        """Return the revised model."""
        return self.steps[-1].model
