"""Candidates as columns: what each effect of the catalog would change.

At its neutral value an effect adds one history to a coefficient, a control or a channel. Effects
that are not linear in their size (play, end stops) are taken at a finite one. Structure without a
name (products of states and inputs, lags, modes) competes too, so that what is in no catalog is
not given the name of what is.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.signal import lfilter

from gsapp.aircraft import Aircraft
from gsapp.discrepancy.effect_catalog import EffectRecord
from gsapp.discrepancy.settings import SEARCH
from gsapp.dynamics.actuators import simulate_control_path
from gsapp.dynamics.buildup import LONGITUDINAL_COEFFICIENTS
from gsapp.dynamics.effect_terms import STALL_SHAPE, StallTerm
from gsapp.dynamics.effects.unnamed_terms import PREFIX, unnamed_ids
from gsapp.dynamics.flight_model import MODEL_INPUTS
from gsapp.dynamics.model import Model
from gsapp.dynamics.sensors import Vector, accelerations_at, alpha_vane, beta_vane, velocity_at
from gsapp.dynamics.signal_terms import (
    SURFACE_CHANNELS,
    Backlash,
    Bias,
    Delay,
    Lag,
    RateLimit,
    Saturation,
    ScaleFactor,
    SignalTerm,
    channels_of_target,
)
from gsapp.dynamics.terms import BOOM_INSTRUMENTS, COEFFICIENTS, Term, create_term
from gsapp.foundation import FlightError
from gsapp.identification.equation_error.stepwise_regression import select_terms
from gsapp.identification.filter_error.maneuver_state import (
    SensitivityColumn,
    SensitivityEntry,
)
from gsapp.identification.filter_error.motion_linearization import Linearization
from gsapp.identification.maneuver import Maneuver
from gsapp.quantities import FloatArray

ColumnBuilder = Callable[[Linearization], SensitivityColumn | None]
_AXES = {"CX": ("CA", -1.0), "CZ": ("CN", -1.0)}
_LOADS = {
    "X": ("CA", -1.0, ""),
    "thrust": ("CA", -1.0, ""),
    "Y": ("CY", 1.0, ""),
    "Z": ("CN", -1.0, ""),
    "L": ("Cl", 1.0, "span"),
    "M": ("Cm", 1.0, "chord"),
    "N": ("Cn", 1.0, "span"),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class TrialSize:
    """An effect at one size: its column is the whole of what it changes."""

    value: float  # Of its parameter.
    build_column: ColumnBuilder


@dataclass(frozen=True, slots=True, kw_only=True)
class CandidateEffect:
    """One competitor for the place of the missing effect."""

    id: str  # Of the catalog, or ``unnamed.<coefficient>.<terms>``.
    title: str
    named: bool  # Whether the catalog explains it.
    parameter: str  # Whose size the column belongs to; empty without a name.
    plausible_size: float  # A usual size, as a difference from neutral.
    excited: bool = True  # Whether the input that it acts through moved in these flights.
    neutral: float
    low: float = -np.inf
    high: float = np.inf
    """Bounds of the size, as differences from neutral."""
    build_column: ColumnBuilder
    """Takes a `Linearization`, returns its column, or None where it cannot act."""
    shape: Mapping[str, float] = field(default_factory=dict)
    """Other parameters of the effect, at which its column was made: it is not linear in them."""
    fitted: tuple[str, ...] = ()
    """Those of them that the full fit moves, too."""
    proven: bool = False
    """Whether regression of measured coefficients prefers it, so that it is fitted fully whatever
    its column gains: a model that lacks it may stand too far from the record for columns."""
    trials: tuple[TrialSize, ...] = ()
    """Of an effect that is not linear in its size, in place of its column: that at several sizes,
    of which the best counts."""

    @property
    def shape_cost(self) -> float:
        """Return what the effect's own shape takes off its gain in the sum of squares."""
        return SEARCH.shape_parameter_cost * len(self.fitted)


def catalog_candidates(
    records: Sequence[EffectRecord],
    aircraft: Aircraft,
    still: Collection[str] = (),
    flown: Sequence[Linearization] = (),
    *,
    stall: StallScreening | None = None,
) -> tuple[CandidateEffect, ...]:
    """Return the competitors for effects of the catalog that can be made a column.

    `still`: ids of those whose input did not move. `flown`: the maneuvers, whose inputs tell at
    which sizes end stops and rate limits are tried. `stall`: without the shape of one none
    competes.
    """
    found = []
    for record in records:
        term = create_term(record.id, aircraft)
        own = stall.shape if stall and isinstance(term, StallTerm) else {}
        maker = _column_builder(term, aircraft, own)
        free = [item for item in term.parameters if item.free]
        trials = _control_trials(term, flown)
        if maker is None or not free or (isinstance(term, StallTerm) and not own):
            continue
        item = free[0]
        found.append(
            CandidateEffect(
                id=record.id,
                title=record.title,
                named=not record.decoy,
                parameter=item.name,
                plausible_size=item.default - item.neutral,
                excited=record.id not in still,
                neutral=item.neutral,
                low=item.bounds[0] - item.neutral,
                high=item.bounds[1] - item.neutral,
                build_column=maker,
                shape=own,
                fitted=() if stall and stall.is_known else tuple(own),
                proven=bool(stall and record.id in stall.proven[:1]),
                trials=trials,
            )
        )
    return tuple(found)


@dataclass(frozen=True, slots=True, kw_only=True)
class StallScreening:
    """What measured coefficients say of a stall, before any motion is simulated."""

    shape: Mapping[str, float]  # Of the stall; empty where none shows.
    is_known: bool = False  # Whether it is that of a stall in the model.
    proven: tuple[str, ...] = ()
    """Ids of the stalls that win over all other terms of their coefficient, clearest first."""


def screen_stall(model: Model, maneuvers: Sequence[Maneuver], aircraft: Aircraft) -> StallScreening:
    """Return the stall that measured coefficients show beside the model's effects."""
    missing, shape = [], {}
    for name in LONGITUDINAL_COEFFICIENTS:
        effect = next((one for one in model.effects if one.id == f"aero.{name}.stall"), None)
        if effect is None:
            missing.append(name)
        else:
            values = {**effect.term(aircraft).defaults, **effect.parameters}
            shape = {one: values[one] for one in STALL_SHAPE}
    is_known = bool(shape)
    chosen = [one for one in maneuvers if "de" in one.inputs] or list(maneuvers)
    proven: dict[str, float] = {}
    for name in missing:
        try:
            found = select_terms(chosen, name, model=model, most_terms=1)
        except FlightError:
            continue
        effect_id = f"aero.{name}.stall"
        if effect_id in found.shapes:
            proven[effect_id] = found.steps[0].partial_f
            if not is_known and proven[effect_id] == max(proven.values()):
                shape = dict(found.shapes[effect_id])
    return StallScreening(
        shape=shape,
        is_known=is_known,
        proven=tuple(sorted(proven, key=lambda one: -proven[one])),
    )


def _column_builder(
    term: Term, aircraft: Aircraft, shape: Mapping[str, float]
) -> ColumnBuilder | None:
    if term.target.startswith("control."):
        return _control_column_builder(term)
    if term.target.startswith("sensor."):
        return _sensor_column_builder(term)
    if term.target.startswith("place."):
        return _position_column_builder(term, aircraft)
    if term.target in COEFFICIENTS or term.target in _AXES or term.target in _LOADS:
        return _equation_column_builder(term, aircraft, shape)
    return None


def _equation_column_builder(
    term: Term, aircraft: Aircraft, shape: Mapping[str, float]
) -> ColumnBuilder:
    index = next((k for k, item in enumerate(term.parameters) if item.free), 0)
    neutral = [shape.get(item.name, item.neutral) for item in term.parameters]

    def make(found: Linearization) -> SensitivityColumn | None:
        reads = [found.variables[name] for name in term.reads]
        states = term.states_along(reads, neutral, found.record.dt)
        history = np.broadcast_to(
            np.asarray(term.jacobian(reads, states, neutral).parameters[index], dtype=float),
            (len(found.record),),
        )
        entries = [coefficient_entry(term.target, history, found, aircraft)]
        if term.target == "thrust":
            # It acts at the engines: below the center of gravity it pitches.
            height = float(np.mean([z for _, _, z in aircraft.propulsion.position]))
            entries.append(coefficient_entry("M", height * history, found, aircraft))
        return tuple(entries)

    return make


def coefficient_of(target: str) -> str:
    """Return the coefficient that what adds to a coefficient, force or moment shows in."""
    return (_AXES.get(target) or _LOADS.get(target) or (target,))[0]


def coefficient_entry(
    target: str, history: FloatArray, found: Linearization, aircraft: Aircraft
) -> SensitivityEntry:
    """Return what adds to a coefficient, force or moment as an entry of a coefficient."""
    if target in COEFFICIENTS:
        return SensitivityEntry(target=target, history=history)
    if target in _AXES:
        place, sign = _AXES[target]
        return SensitivityEntry(target=place, history=sign * history)
    place, sign, arm = _LOADS[target]
    geometry = aircraft.geometry
    size = found.variables["qbar"] * geometry.wing_area
    length = geometry.span if arm == "span" else geometry.chord if arm == "chord" else 1.0
    return SensitivityEntry(target=place, history=sign * history / (size * length))


def _control_column_builder(term: Term) -> ColumnBuilder | None:
    channel = SURFACE_CHANNELS[term.target.partition(".")[2]]
    if not isinstance(term, SignalTerm):
        return None

    def make(found: Linearization) -> SensitivityColumn | None:
        signal = found.inputs[MODEL_INPUTS.index(channel)]
        if isinstance(term, Lag | Delay):
            change = -np.gradient(signal, found.record.dt)
        elif isinstance(term, ScaleFactor):
            change = signal
        else:
            return None
        return (SensitivityEntry(target=channel, history=change),)

    return make


def _control_trials(term: Term, flown: Sequence[Linearization]) -> tuple[TrialSize, ...]:
    """Return the sizes at which play, end stops and rate limits are tried."""
    group, _, name = term.target.partition(".")
    is_tried = group == "control" and isinstance(term, Backlash | Saturation | RateLimit)
    if not is_tried or not flown:
        return ()
    channel = SURFACE_CHANNELS[name]
    row = MODEL_INPUTS.index(channel)
    if isinstance(term, Backlash):
        values = SEARCH.trial_backlashes
    elif isinstance(term, Saturation):
        most = max(float(np.abs(one.inputs[row]).max()) for one in flown)
        values = tuple(share * most for share in SEARCH.trial_limit_shares)
    else:
        most = max(
            float(np.abs(np.gradient(one.inputs[row], one.record.dt)).max()) for one in flown
        )
        values = tuple(share * most for share in SEARCH.trial_limit_shares)

    def trial(value: float) -> TrialSize:
        assert isinstance(term, SignalTerm)  # noqa: S101  every control effect is one

        def make(found: Linearization) -> SensitivityColumn | None:
            signal = found.inputs[row]
            moved = simulate_control_path(((term, (value,)),), signal, found.record.dt)
            change = moved.values - signal
            return (SensitivityEntry(target=channel, history=change),) if np.any(change) else None

        return TrialSize(value=value, build_column=make)

    return tuple(trial(value) for value in values)


def _sensor_column_builder(term: Term) -> ColumnBuilder | None:
    name = term.target.partition(".")[2]
    channels = channels_of_target(name)
    if not isinstance(term, Lag | Delay | ScaleFactor | Bias):
        return None

    def make(found: Linearization) -> SensitivityColumn | None:
        entries = []
        for channel in channels:
            if channel in ("de", "da", "dr", "flap"):
                if isinstance(term, Lag | Delay):
                    signal = found.inputs[MODEL_INPUTS.index(channel)]
                    # What was recorded late came earlier.
                    change = np.gradient(signal, found.record.dt)
                    entries.append(SensitivityEntry(target=channel, history=change))
                continue
            if channel not in found.record.channels:
                continue
            column = found.record.channels.index(channel)
            if isinstance(term, Lag | Delay):
                history = -found.output_rates[:, column]
            elif isinstance(term, ScaleFactor):
                history = found.computed[:, column]
            else:
                history = np.ones(len(found.record))
            entries.append(SensitivityEntry(target=f"channel.{channel}", history=history))
        return tuple(entries) or None

    return make


def _position_column_builder(term: Term, aircraft: Aircraft) -> ColumnBuilder | None:
    """Return what a vane, a boom with both, or an accelerometer to one side shows elsewhere."""
    _, instrument, axis = term.target.split(".")
    if term.target == "place.accelerometer.y":
        return _accelerations_beside
    if instrument not in ("boom", *BOOM_INSTRUMENTS):
        return None
    vanes = BOOM_INSTRUMENTS if instrument == "boom" else (instrument,)
    step = tuple(SEARCH.trial_distance * (one == axis) for one in "xyz")

    def shown(name: str, flow: Vector, rates: Vector, arm: Sequence[float]) -> FloatArray:
        vane = getattr(aircraft.sensors, name)
        x, y, z = np.add(vane.position, arm)
        local = velocity_at((x, y, z), flow, rates)
        if name == "alpha_vane":
            return np.asarray(alpha_vane(local, vane.upwash))
        return np.asarray(beta_vane(local, vane.kind, vane.upwash))

    def make(found: Linearization) -> SensitivityColumn | None:
        V, alpha, beta, p, q, r = (found.variables[one] for one in _FLOW)
        forward = V * np.cos(beta)
        flow = (forward * np.cos(alpha), V * np.sin(beta), forward * np.sin(alpha))
        entries = []
        for vane in vanes:
            channel = vane.removesuffix("_vane")
            if channel in found.record.channels:
                moved, here = (shown(vane, flow, (p, q, r), arm) for arm in (step, (0.0,) * 3))
                history = (moved - here) / SEARCH.trial_distance
                entries.append(SensitivityEntry(target=f"channel.{channel}", history=history))
        return tuple(entries) or None

    return make


def _accelerations_beside(found: Linearization) -> SensitivityColumn | None:
    """Return what an accelerometer shows for each meter to the right, shape (n,) per channel.

    Only there. Ahead or below, it shows angular accelerations that the free derivatives of its own
    coefficient follow: no flight parts the two.
    """
    # The rates of the model itself; differences of the motion hold what the filter corrects.
    spin = (_model_rate(found, "p"), _model_rate(found, "q"), _model_rate(found, "r"))
    rates = (found.variables["p"], found.variables["q"], found.variables["r"])
    shown = accelerations_at((0.0, 1.0, 0.0), (0.0,) * 3, rates, spin)
    return tuple(
        SensitivityEntry(target=f"channel.{channel}", history=np.asarray(history))
        for channel, history in zip(("ax", "ay", "an"), shown, strict=True)
        if channel in found.record.channels
    )


def _model_rate(found: Linearization, state: str) -> FloatArray:
    """Return the rate of a state that the model gives, shape (n,)."""
    if state in found.record.channels:
        return found.sensor_input_rates[:, found.record.channels.index(state)]
    row = found.record.states.index(state)
    steps = (found.next_states[row] - found.states[row, :-1]) / found.record.dt
    # A step is the mean of the rates at its ends.
    ends = np.arange(len(found.record)) - 0.5
    return np.asarray(np.interp(ends, np.arange(len(steps)), steps))


_FLOW = ("V", "alpha", "beta", "p", "q", "r")
VIBRATING_CHANNELS = ("ax", "ay", "an")
"""Instruments that the structure shakes."""
_NO_NAME = "no catalog effect does that"


def unnamed_candidates(
    named: Sequence[CandidateEffect], aircraft: Aircraft, *, throttle: bool, flap: bool
) -> tuple[CandidateEffect, ...]:
    """Return products of states and inputs, and lags, that no effect of the catalog explains."""
    taken = {_sorted_name(one.id.partition(".")[2]) for one in named}
    found = []
    for effect in unnamed_ids(throttle=throttle, flap=flap):
        name = effect.removeprefix(PREFIX)
        target, _, structure = name.partition(".")
        # The lag of the catalog's memory effect is that of alpha.
        is_memory = structure == "late_alpha" and f"{target}.memory" in taken
        if _sorted_name(name) not in taken and not is_memory:
            term = create_term(effect, aircraft)
            found.append(
                CandidateEffect(
                    id=effect,
                    title=f"{term.title}; {_NO_NAME}",
                    named=False,
                    parameter=term.parameters[0].name,
                    plausible_size=1.0,
                    neutral=0.0,
                    build_column=_equation_column_builder(term, aircraft, {}),
                )
            )
    found += [
        _structural_mode_candidate(channel, mode)
        for channel in VIBRATING_CHANNELS
        for mode in SEARCH.mode_frequencies
    ]
    return tuple(found)


def _sorted_name(name: str) -> str:
    """Return a name by which products compare whatever the order of their factors."""
    target, _, factors = name.partition(".")
    return f"{target}.{'_'.join(sorted(factors.split('_')))}"


def _structural_mode_candidate(channel: str, frequency: float) -> CandidateEffect:
    def make(found: Linearization) -> SensitivityColumn | None:
        if channel not in found.record.channels:
            return None
        felt = found.computed[:, found.record.channels.index(channel)]
        history = _mode_response(felt - felt[0], frequency, found.record.dt)
        return (SensitivityEntry(target=f"channel.{channel}", history=history),)

    return CandidateEffect(
        id=f"{PREFIX}{channel}.mode{frequency:g}",
        title=f"{channel} rings at about {frequency:g} Hz, like a flexible structure; {_NO_NAME}",
        named=False,
        parameter="",
        plausible_size=1.0,
        neutral=0.0,
        build_column=make,
    )


def _mode_response(signal: FloatArray, frequency: float, dt: float) -> FloatArray:
    """Return what a lightly damped mode adds that changes of a signal shake, at rest before."""
    omega = 2.0 * np.pi * frequency
    pole = np.exp(complex(-SEARCH.mode_damping, np.sqrt(1.0 - SEARCH.mode_damping**2)) * omega * dt)
    return np.asarray(
        lfilter(np.array([1.0, -1.0]) * omega * dt, [1.0, -2.0 * pole.real, abs(pole) ** 2], signal)
    )
