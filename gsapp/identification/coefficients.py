"""Force and moment coefficients at every sample, from measured motion alone.

No aerodynamic model enters: accelerations moved to the center of gravity and angular
accelerations (derivatives of the measured rates) give all forces and moments; thrust and its
moments are taken out; dynamic pressure at each sample makes them coefficients:

    qS C_X = m a_x - T         qS b C_l = Ixx p' - Ixz (r' + p q) + (Izz - Iyy) q r
    qS C_Y = m a_y             qS c C_m = Iyy q' + (Ixx - Izz) p r + Ixz (p^2 - r^2) - z_T T
    qS C_Z = -m a_n            qS b C_n = Izz r' - Ixz (p' - q r) + (Iyy - Ixx) p q - N_T

with C_A = -C_X and C_N = -C_Z. Derivatives, and everything that stands beside them in a
regression, pass the same zero-phase filter (`gsapp.identification.smoothing`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.integrate import cumulative_trapezoid

from gsapp.aircraft import Aircraft
from gsapp.dynamics.arithmetic import Value
from gsapp.dynamics.equations import POLAR_STATES, PolarState, RigidBody, wind_axis_rates
from gsapp.dynamics.flight_model import MODEL_INPUTS, FlightModel
from gsapp.dynamics.model import Model
from gsapp.dynamics.sensors import accelerations_at_cg
from gsapp.dynamics.terms import COEFFICIENTS, Term
from gsapp.foundation import FlightError
from gsapp.identification.instrument_effects import effective_records
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.motion import MeasuredMotion, measured_motion
from gsapp.identification.preparation_settings import PREPARATION
from gsapp.identification.record_preparation import advance_samples
from gsapp.identification.smoothing import (
    BoolArray,
    Smoother,
    build_smoother,
    contiguous_slices,
    interpolate_missing,
    select_cutoff,
)
from gsapp.quantities import FloatArray

REGRESSORS = ("alpha", "beta", "p_hat", "q_hat", "r_hat", "de", "da", "dr")
"""What the linear build-up multiplies; `Coefficients.variables` holds more."""
COEFFICIENT_CHANNELS: Mapping[str, tuple[str, ...]] = {
    "CN": ("an",),
    "CA": ("ax",),
    "CY": ("ay",),
    "Cl": ("p", "r"),
    "Cm": ("q",),
    "Cn": ("p", "r"),
}
"""Channels without which a coefficient cannot be had."""
NEGATED_COEFFICIENTS = {"CX": "CA", "CZ": "CN"}
"""Coefficients that point the other way than those of the model."""
_ACCELERATIONS = ("ax", "ay", "an")
_VARIABLES = (
    "V", "alpha", "beta", "p", "q", "r", "p_hat", "q_hat", "r_hat", "de", "da", "dr", "flap",
    "throttle", "throttle_difference", "rho", "qbar", "thrust", "alpha_dot_hat", "beta_dot_hat",
)  # fmt: skip
_RATES = ("p", "q", "r")
_AIR = ("V", "rho")
_COEFFICIENT_DEPENDENCIES: Mapping[str, tuple[str, ...]] = {
    "CN": ("an", *_AIR, *_RATES),
    "CA": ("ax", *_AIR, *_RATES, "throttle"),
    "CY": ("ay", *_AIR, *_RATES),
    "Cl": (*_AIR, *_RATES),
    "Cm": (*_AIR, *_RATES, "throttle"),
    "Cn": (*_AIR, *_RATES, "throttle_difference"),
    "alpha": ("alpha", "V", "p", "q"),
    "beta": ("beta", "V", "p", "r"),
    "p_hat": ("p", "V"),
    "q_hat": ("q", "V"),
    "r_hat": ("r", "V"),
    "de": ("de",),
    "da": ("da",),
    "dr": ("dr",),
}
"""What each depends on, sample by sample."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Coefficients:
    """Coefficients of one maneuver, with the variables that may explain them."""

    maneuver: str
    times: FloatArray  # Shape (n,). s.
    values: FloatArray
    """Shape (n, 6). Smoothed `gsapp.dynamics.terms.COEFFICIENTS`: CN, CA, CY, Cl, Cm, Cn."""
    valid: BoolArray
    """Shape (n, 6). Samples that count: nothing that they depend on was missing or clipped."""
    variables: Mapping[str, FloatArray]
    """Shape (n,). As `gsapp.dynamics.terms.VARIABLES`, not smoothed: form products first, then
    `smooth`."""
    variable_valid: Mapping[str, BoolArray]
    """Shape (n,). Samples of each variable that count once smoothed."""
    measured: frozenset[str]  # Channels that an instrument measured.
    integrated: frozenset[str]
    """Flow angles that no vane measured, integrated from accelerations and rates instead: their
    changes are right, their offset and a slow drift are not known."""
    missing: Mapping[str, str]  # Coefficients that cannot be had: why.
    smoother: Smoother
    remarks: tuple[str, ...]  # Stand-ins, in words.

    def value(self, coefficient: str) -> FloatArray:
        """Return a coefficient, NaN where it does not count; also CX and CZ. Shape (n,)."""
        sign = -1.0 if coefficient in NEGATED_COEFFICIENTS else 1.0
        found = np.where(
            self.valid_samples(coefficient), self.values[:, self.column(coefficient)], np.nan
        )
        return np.asarray(sign * found, dtype=np.float64)

    def column(self, coefficient: str) -> int:
        """Return where a coefficient stands in `values` and `valid`."""
        return COEFFICIENTS.index(NEGATED_COEFFICIENTS.get(coefficient, coefficient))

    def valid_samples(self, coefficient: str) -> BoolArray:
        """Return the samples of a coefficient that count, shape (n,)."""
        return np.asarray(self.valid[:, self.column(coefficient)], dtype=np.bool_)

    def smooth(self, signals: FloatArray) -> FloatArray:
        """Filter something formed from `variables` just as the coefficients were."""
        return self.smoother.smooth(signals)

    def smoothed_variables(self, names: Sequence[str]) -> FloatArray:
        """Return variables filtered as the coefficients were, shape (n, len(names))."""
        return self.smooth(np.column_stack([self.variables[name] for name in names]))

    def noise(self, names: Sequence[str]) -> FloatArray:
        """Return the covariance that white measurement noise gives smoothed variables."""
        signals = np.column_stack([self.variables[name] for name in names])
        return self.smoother.white_noise(signals)


def reconstruct_coefficients(
    maneuver: Maneuver,
    *,
    motion: MeasuredMotion | None = None,
    stand_ins: Mapping[str, float] | None = None,
    model: Model | None = None,
    cutoff: float | None = None,
    delays: Mapping[str, float] | None = None,
) -> Coefficients:
    """Reconstruct the coefficients of a maneuver at every sample.

    Parameters
    ----------
    motion : MeasuredMotion, optional
        If it is known already. Effects of the model on instruments and control paths are then left
        as they are; else they are undone first (`gsapp.identification.instrument_effects`).
    stand_ins : mapping of str to float, optional
        As in `measured_motion`.
    model : Model, optional
        Its effects (not its derivatives) are taken out of the coefficients.
    cutoff : float, optional
        Of the smoothing, Hz; by default chosen from the data.
    delays : mapping of str to float, optional
        How late channels come, s, beyond what the aircraft file says (`cut_maneuver` has undone
        that already). A difference of half a sample between gyros and surfaces bends damping and
        control derivatives by 5 %.

    Raises
    ------
    FlightError
        If the mass is not greater than zero, or no airspeed can be had.
    """
    if not maneuver.mass > 0.0:
        raise FlightError(
            f"maneuver {maneuver.id} of '{maneuver.flight}' has a mass of {maneuver.mass:g} kg; "
            "give the mass in the aircraft file, or the weights in flight.toml"
        )
    if motion is None:
        (maneuver,), model = effective_records([maneuver], model)
    moved = measured_motion(maneuver, stand_ins=stand_ins) if motion is None else motion
    dt = maneuver.dt
    if cutoff is None:
        cutoff = select_cutoff(moved.states[:, 1:6], dt)
    filtering = build_smoother(dt, cutoff)
    accelerations = np.column_stack([maneuver.samples(name) for name in _ACCELERATIONS])
    gaps = dict(moved.interpolated)
    for column, name in enumerate(_ACCELERATIONS):
        gaps[name] = ~np.isfinite(accelerations[:, column])
        accelerations[:, column] = interpolate_missing(accelerations[:, column], gaps[name])
    states, inputs_shown = moved.states.copy(), moved.inputs.copy()
    for name, delay in (delays or {}).items():
        for names, values in (
            (POLAR_STATES, states),
            (MODEL_INPUTS, inputs_shown),
            (_ACCELERATIONS, accelerations),
        ):
            if delay and name in names:
                column = names.index(name)
                moved_on = advance_samples(values[:, column], delay / dt)
                unknown = ~np.isfinite(moved_on)
                values[:, column] = interpolate_missing(moved_on, unknown)
                gaps[name] = gaps.get(name, np.zeros(unknown.size, dtype=bool)) | unknown
    measured = moved.measured | {name for name in _ACCELERATIONS if not gaps[name].all()}

    signals = filtering.simpson_average(
        np.column_stack((states, inputs_shown, np.nan_to_num(accelerations)))
    ).T
    state, inputs, shown = tuple(signals[:9]), tuple(signals[9:17]), signals[17:]
    rates_of = filtering.differentiate(states[:, 1:6]).T
    aircraft = maneuver.aircraft
    geometry = aircraft.geometry
    span, chord = geometry.wing_area * geometry.span, geometry.wing_area * geometry.chord

    # Loads without any aerodynamic derivative: thrust, its moments, effects.
    without, by_flow_rates, remarks = _without_derivatives(aircraft, model)
    settled = _term_states(without, state, inputs, dt)
    totals = without.evaluate((*state, *settled), inputs)
    loads, body, (cx, cy, cz) = totals.loads, totals.body, totals.cg
    x, y, z = aircraft.sensors.accelerometer.position
    p, q, r = state[3:6]
    p_dot, q_dot, r_dot = rates_of[2:5]
    ax, ay, an = accelerations_at_cg(
        (x - cx, y - cy, z - cz), (shown[0], shown[1], shown[2]), (p, q, r), (p_dot, q_dot, r_dot)
    )
    X = body.mass * ax - loads.X
    Y = body.mass * ay - loads.Y
    Z = -body.mass * an - loads.Z
    L, M, N = moments_from_rates((p, q, r), (p_dot, q_dot, r_dot), body)
    L = L - loads.L - (cz * Y - cy * Z)
    M = M - loads.M - (cx * Z - cz * X)
    N = N - loads.N - (cy * X - cx * Y)

    qbar = np.asarray(totals.variables[_VARIABLES.index("qbar")])
    qS = geometry.wing_area * qbar
    raw = np.column_stack(
        (-Z / qS, -X / qS, Y / qS, L / (qbar * span), M / (qbar * chord), N / (qbar * span))
    )
    variables = {
        name: np.broadcast_to(np.asarray(values, dtype=np.float64), qbar.shape)
        for name, values in zip(_VARIABLES, totals.variables, strict=True)
    }
    flow = _integrate_flow_angles(state, (ax, ay, an), measured, moved.times)
    variables.update(flow)
    half = 0.5 / variables["V"]
    turning = {
        name: filtering.differentiate(flow[name]) if name in flow else rates_of[index]
        for index, name in enumerate(("alpha", "beta"))
    }
    variables["alpha_dot_hat"] = turning["alpha"] * half * geometry.chord
    variables["beta_dot_hat"] = turning["beta"] * half * geometry.span
    for term, parameters in by_flow_rates:
        reads = [variables[name] for name in term.reads]
        own = term.states_along(reads, parameters, dt) if term.states else ()
        given = term.value(reads, own, parameters)
        raw[:, COEFFICIENTS.index(term.target)] -= given

    good = _valid_samples(gaps, _unbridgeable_gaps(gaps, moved.times, dt), filtering)
    missing = {
        name: why
        for name, needs in COEFFICIENT_CHANNELS.items()
        if (why := _missing_text(needs, measured, maneuver))
    }
    for name in flow:
        # Integrated over its own gaps, so that only the samples themselves are lost.
        good[name] = good[_INTEGRATED_FROM[name]]
    for name in missing:
        good[name] = np.zeros(qbar.size, dtype=bool)
    return Coefficients(
        maneuver=maneuver.id,
        times=moved.times,
        values=filtering.smooth(raw),
        valid=np.column_stack([good[name] for name in COEFFICIENTS]),
        variables=variables,
        variable_valid={name: good[name] for name in REGRESSORS},
        measured=frozenset(measured),
        integrated=frozenset(flow),
        missing=missing,
        smoother=filtering,
        remarks=(
            *(text for text in moved.remarks if text.partition(" ")[0] not in flow),
            *remarks,
            *(f"{name} was not measured; it is integrated from other instruments" for name in flow),
            *(_ASSUMED_SPEED_TEXT for name in ("V",) if name not in measured),
        ),
    )


_ASSUMED_SPEED_TEXT = (
    "the airspeed is assumed: coefficients scale with its square, and no bound includes its error"
)
_INTEGRATED_FROM = {"alpha": "CN", "beta": "CY"}
_CHANNELS_INTEGRATED = {"alpha": ("q", "an"), "beta": ("p", "r", "ay")}


def _integrate_flow_angles(
    state: tuple[FloatArray, ...],
    accelerations: tuple[Value, Value, Value],
    measured: AbstractSet[str],
    times: FloatArray,
) -> dict[str, FloatArray]:
    """Return the flow angles that no vane measured, integrated (4.1.16), (4.1.17).

    Unit mass makes forces of the accelerations at the CG. The angles themselves hardly enter
    their own rates, so that a few passes settle.
    """
    lacking = [
        name
        for name, needs in _CHANNELS_INTEGRATED.items()
        if name not in measured and all(need in measured for need in needs)
    ]
    if not lacking:
        return {}
    ax, ay, an = accelerations
    flow = dict.fromkeys(lacking, state[1])
    angles = {"alpha": state[1], "beta": state[2]}
    for _ in range(PREPARATION.flow_angle_passes):
        now = PolarState(state[0], angles["alpha"], angles["beta"], *state[3:])
        rates = wind_axis_rates(now, ax, ay, -np.asarray(an), 1.0)
        for name in lacking:
            index = POLAR_STATES.index(name)
            turned = cumulative_trapezoid(np.asarray(rates[index]), times, initial=0.0)
            flow[name] = state[index][0] + turned
        angles.update(flow)
    return flow


def moments_from_rates(
    rates: tuple[Value, Value, Value], spin: tuple[Value, Value, Value], body: RigidBody
) -> tuple[Value, Value, Value]:
    """Return L, M, N (N m) about the CG from rates (rad/s) and their derivatives (rad/s^2).

    The inverse of `gsapp.dynamics.equations.angular_accelerations`.
    """
    p, q, r = rates
    p_dot, q_dot, r_dot = spin
    ixx, iyy, izz, ixz = body.ixx, body.iyy, body.izz, body.ixz
    return (
        ixx * p_dot - ixz * (r_dot + p * q) + (izz - iyy) * q * r,
        iyy * q_dot + (ixx - izz) * p * r + ixz * (p * p - r * r),
        izz * r_dot - ixz * (p_dot - q * r) + (iyy - ixx) * p * q,
    )


def _without_derivatives(
    aircraft: Aircraft, model: Model | None
) -> tuple[FlightModel, list[tuple[Term, tuple[float, ...]]], list[str]]:
    """Return the effects of a model in the equations, and apart those that read flow rates.

    Flow rates are measured here; the equations would make them from loads that lack the
    derivatives.
    """
    effects = () if model is None else model.effects
    now, late = [], []
    for effect in effects:
        term = effect.term(aircraft)
        if {"alpha_dot_hat", "beta_dot_hat"}.isdisjoint(term.reads):
            now.append(effect)
        else:
            late.append((term, effect.values(aircraft)))
    flight_model = (
        FlightModel(aircraft, Model(effects=tuple(now)))
        if now
        else flight_model_without_aero(aircraft)
    )
    outside = [
        *flight_model.control_terms,
        *flight_model.sensor_terms,
        *(" and ".join(pair) for pair in flight_model.swapped_channels),
        *(f"the place of {name}" for name in flight_model.displaced_instruments),
    ]
    remarks = [
        f"the model's effects on {', '.join(outside)} are not undone in the measurements"
    ] * bool(outside)
    return flight_model, late, remarks


@lru_cache(maxsize=8)
def flight_model_without_aero(aircraft: Aircraft) -> FlightModel:
    """Return the flight model with neither derivatives nor effects.

    Making it takes as long as a step of a fit; a campaign asks for the same one every time.
    """
    return FlightModel(aircraft, Model())


def _term_states(
    model: FlightModel,
    state: tuple[FloatArray, ...],
    inputs: tuple[FloatArray, ...],
    dt: float,
) -> tuple[FloatArray, ...]:
    """Return the states of the effects' own, integrated along the measured motion."""
    if len(model.state_names) == len(POLAR_STATES):
        return ()
    rows = list(zip(*(x.tolist() for x in state), strict=True))
    given = list(zip(*(x.tolist() for x in inputs), strict=True))
    own = [float(x) for x in model.steady_states(rows[0], given[0])]
    found = [own]
    for index in range(len(rows) - 1):
        first = model.evaluate((*rows[index], *own), given[index]).term_rates
        ahead = [x + dt * float(rate) for x, rate in zip(own, first, strict=True)]
        second = model.evaluate((*rows[index + 1], *ahead), given[index + 1]).term_rates
        own = [
            x + 0.5 * dt * float(one + two) for x, one, two in zip(own, first, second, strict=True)
        ]
        found.append(own)
    return tuple(np.array(found).T)


def _missing_text(needs: Sequence[str], measured: AbstractSet[str], maneuver: Maneuver) -> str:
    """Return why a coefficient cannot be had; empty if it can."""
    absent = [name for name in needs if name not in measured]
    if absent:
        return f"{' and '.join(absent)} {'was' if len(absent) == 1 else 'were'} not measured"
    for name in needs:
        shown = maneuver.samples(name)
        shown = shown[np.isfinite(shown)]
        if shown.size > 1 and not np.ptp(shown):
            return f"{name} is constant: the instrument is stuck"
    return ""


def _unbridgeable_gaps(
    gaps: Mapping[str, BoolArray], times: FloatArray, dt: float
) -> dict[str, BoolArray]:
    """Return the missing stretches too long to bridge, and the pauses of the record."""
    pauses = np.zeros(times.size, dtype=bool)
    pauses[:-1] = np.diff(times) > 1.5 * dt
    hard = {_PAUSE: pauses} if pauses.any() else {}
    for name, mask in gaps.items():
        long = np.zeros(times.size, dtype=bool)
        for part in contiguous_slices(mask):
            long[part] = (part.stop - part.start) * dt > PREPARATION.max_filled_gap
        if long.any():
            hard[name] = long
    return hard


_PAUSE = "pause"


def _valid_samples(
    gaps: Mapping[str, BoolArray], hard: Mapping[str, BoolArray], filtering: Smoother
) -> dict[str, BoolArray]:
    """Return the samples that count for each of `_COEFFICIENT_DEPENDENCIES`."""
    count = next(iter(gaps.values())).size
    known: dict[tuple[str, ...], BoolArray] = {}
    found = {}
    for name, needs in _COEFFICIENT_DEPENDENCIES.items():
        touched = tuple(one for one in needs if one in gaps and gaps[one].any())
        if touched not in known:
            missing, out = np.zeros(count, dtype=bool), np.zeros(count, dtype=bool)
            for one in touched:
                missing |= gaps[one]
            for one in (*touched, _PAUSE):
                if one in hard:
                    out |= hard[one]
            known[touched] = filtering.valid_samples(out) & ~missing
        found[name] = known[touched]
    return found


def smooth_coefficients(
    maneuvers: Sequence[Maneuver],
    motions: Sequence[MeasuredMotion] | None = None,
    *,
    stand_ins: Mapping[str, float] | None = None,
    model: Model | None = None,
    cutoff: float | None = None,
    delays: Mapping[str, float] | None = None,
) -> list[Coefficients]:
    """Return the coefficients of all maneuvers, smoothed with the highest cutoff that one needs.

    Parameters as in `gsapp.identification.coefficients.reconstruct_coefficients`.

    Raises `FlightError` if there is no maneuver.
    """
    if not maneuvers:
        raise FlightError("no maneuver to estimate from; name at least one")
    if motions is None:
        maneuvers, model = effective_records(maneuvers, model)
        motions = [measured_motion(maneuver, stand_ins=stand_ins) for maneuver in maneuvers]
    if cutoff is None:
        cutoff = max(
            select_cutoff(motion.states[:, 1:6], maneuver.dt)
            for maneuver, motion in zip(maneuvers, motions, strict=True)
        )
    return [
        reconstruct_coefficients(maneuver, motion=motion, model=model, cutoff=cutoff, delays=delays)
        for maneuver, motion in zip(maneuvers, motions, strict=True)
    ]
