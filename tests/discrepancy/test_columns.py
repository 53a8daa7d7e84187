"""Proves what parameters and effects change against differences of the whole filter.

A parameter is changed in the model, the equations are linearized anew along the same motion, and
the residual goes through the same filter: what the innovations then lose is the column.
"""

from dataclasses import dataclass

import numpy as np
import pytest

from gsapp.discrepancy.candidates import (
    CandidateEffect,
    catalog_candidates,
    unnamed_candidates,
)
from gsapp.discrepancy.effect_catalog import all_effects
from gsapp.discrepancy.effect_selection import screen_candidates
from gsapp.dynamics.flight_model import FlightModel
from gsapp.dynamics.model import Model
from gsapp.dynamics.signal_terms import Delay, Lag, SignalTerm
from gsapp.dynamics.terms import create_term
from gsapp.identification.axes import axis_derivatives
from gsapp.identification.filter_error.filter_error_fit import (
    FilterErrorFit,
    ManeuverState,
    bias_name,
)
from gsapp.identification.filter_error.kalman import SteadyStateFilter, create_filter
from gsapp.identification.filter_error.maneuver_state import SensitivityColumn, filter_inputs
from gsapp.identification.filter_error.motion_linearization import (
    Linearization,
    NominalMotion,
    initial_motion,
    linearize_along,
)
from gsapp.quantities import FloatArray
from tests.discrepancy.core_kit import AIRCRAFT, TRUTH, maneuver, prepared, true_noise, with_channel

DERIVATIVES = axis_derivatives("both")
WITH_EFFECTS = (
    TRUTH.with_effect("aero.Cm.alpha2", {"Cm_alpha2": -1.5})
    .with_effect("control.elevator.lag", {"tau": 0.05})
    .with_effect("sensor.alpha.scale", {"scale": 1.1})
    .with_effect("sensor.q.lag", {"tau": 0.04})
    .with_effect("sensor.r.delay", {"delay": 0.023})
)


@dataclass(frozen=True)
class Prepared:
    """A maneuver in which everything moves, filtered in gusts along the filter's prediction."""

    fit: FilterErrorFit
    one: ManeuverState
    own: SteadyStateFilter

    def innovations(self, column: SensitivityColumn) -> FloatArray:
        z, b = filter_inputs(self.own, [column])
        found, _ = self.own.innovations(z, b)
        return (self.own.whitener @ found)[:, :, 0]

    def lost(self, model: Model, size: float) -> FloatArray:
        zero = np.zeros(len(self.one.record.channels))
        flight_model = FlightModel(AIRCRAFT, model)
        motion = self.one.motion
        before = self.own.residual(zero)
        linearization = linearize_along(
            self.one.record, flight_model, np.array(flight_model.defaults), motion
        )
        after = create_filter(linearization, self.fit.noise["virtual"], motion).residual(zero)
        z, b = ((old - new) / size for old, new in zip(before[:2], after[:2], strict=True))
        found, _ = self.own.innovations(z[:, :, None], b[:, :, None])
        return (self.own.whitener @ found)[:, :, 0]


def prepare(model: Model, free: tuple[str, ...] = (), turbulence: float = 1e-3) -> Prepared:
    flown = maneuver(1, dt=0.01, duration=5.0)
    times = flown.block.times - flown.block.times[0]
    flap = np.radians(10.0) * np.clip((times - 2.0) / 1.0, 0.0, 1.0)
    throttle = flown.samples("throttle") + 0.2 * np.sin(1.5 * times)
    flown = with_channel(with_channel(flown, "flap", flap), "throttle", throttle)
    fit = prepared([flown], model, free)
    fit.noise = {"virtual": true_noise(gusts=turbulence, moments=turbulence)}
    for _ in range(2):
        fit.linearize()
        fit.update_motion()
    fit.linearize()
    one = fit.maneuvers[0]
    assert one.filter is not None
    return Prepared(fit, one, one.filter)


def error(found: FloatArray, expected: FloatArray) -> float:
    return float(np.linalg.norm(found - expected) / np.linalg.norm(expected))


@pytest.fixture(scope="module")
def plain() -> Prepared:
    return prepare(TRUTH, DERIVATIVES)


@pytest.fixture(scope="module")
def rich() -> Prepared:
    """Return it under a model with effects of every entry point, their parameters free.

    In still air: slopes by a lag leave out the jumps where measurements correct a prediction.
    """
    free = tuple(
        f"{effect.id}.{name}" for effect in WITH_EFFECTS.effects for name in effect.parameters
    )
    return prepare(WITH_EFFECTS, free, turbulence=1e-9)


def test_derivatives(plain: Prepared) -> None:
    columns = plain.fit.model_columns(plain.one, plain.own.linearization)
    for name, column in zip(plain.fit.free, columns, strict=True):
        step = 1e-3 * max(abs(TRUTH.derivative(name)), 0.05)
        changed = TRUTH.with_derivatives({name: TRUTH.derivative(name) + step})
        expected = plain.lost(changed, step)
        assert error(plain.innovations(column), expected) < 0.02, name


def test_parameters_of_effects_in_the_model(rich: Prepared) -> None:
    """An effect in the equations, a servo lag; a scale, a lag and a delay of instruments.

    As they stand, within 2 %; how late an instrument is within 5, its jumps left out.
    """
    assert len(rich.fit.free) == 5
    columns = rich.fit.model_columns(rich.one, rich.own.linearization)
    for name, column in zip(rich.fit.free, columns, strict=True):
        effect, _, item = name.rpartition(".")
        value = rich.fit.values[name]
        step = 1e-3 * abs(value)
        changed = WITH_EFFECTS.with_effect(effect, {item: value + step})
        expected = rich.lost(changed, step)
        most = 0.05 if effect in ("sensor.q.lag", "sensor.r.delay") else 0.02
        assert error(rich.innovations(column), expected) < most, name


def tried_size(one: CandidateEffect, term: object) -> float:
    # Smaller lags ask for slopes at a corner: straight lines between samples have two.
    return one.plausible_size * (1.0 if isinstance(term, Lag | Delay) else 0.02)


def test_effects_of_the_catalog(plain: Prepared) -> None:
    """Every effect of the catalog: its column is what a small size of it in the model changes.

    Within 2 %; lags and delays are tried at a usual size, to which they are not straight lines.
    """
    records = [one for one in all_effects() if not one.disturbance]
    compared, kinds = 0, set()
    for one in catalog_candidates(records, AIRCRAFT):
        column = one.build_column(plain.own.linearization)
        term = create_term(one.id, AIRCRAFT)
        if not column or term.states:
            continue
        found = plain.innovations(column)
        if not np.any(found):
            continue
        neutral = {item.name: item.neutral for item in term.parameters if item.free}
        size = tried_size(one, term)
        values = {**term.defaults, **neutral, one.parameter: one.neutral + size}
        expected = plain.lost(TRUTH.with_effect(one.id, values), size)
        bent = isinstance(term, Lag | Delay) and not one.id.startswith("aero")
        assert error(found, expected) < (0.3 if bent else 0.02), one.id
        compared += 1
        kinds.add((one.id.split(".")[0], isinstance(term, SignalTerm)))
    assert compared > 120
    assert kinds >= {
        ("aero", False), ("propulsion", False), ("control", True), ("sensor", True),
    }  # fmt: skip


def test_effects_that_are_not_linear_are_tried_at_sizes(plain: Prepared) -> None:
    """Play and end stops: the column of each size is the whole of what that size changes."""
    records = [one for one in all_effects() if one.id.startswith("control.elevator.")]
    table = {
        one.id: one
        for one in catalog_candidates(records, AIRCRAFT, flown=[plain.own.linearization])
    }
    for name in ("control.elevator.backlash", "control.elevator.saturation"):
        one = table[name]
        assert len(one.trials) >= 2
        for trial in one.trials:
            column = trial.build_column(plain.own.linearization)
            assert column is not None, (name, trial.value)
            model = TRUTH.with_effect(name, {one.parameter: trial.value})
            assert error(plain.innovations(column), plain.lost(model, 1.0)) < 0.05, trial.value
    assert not table["control.elevator.lag"].trials


def test_an_effect_with_a_memory(plain: Prepared) -> None:
    """A lag of the normal force: its column is what it changes once its own state has settled."""
    record = next(one for one in all_effects() if one.id == "aero.Cm.memory")
    (one,) = catalog_candidates([record], AIRCRAFT)
    column = one.build_column(plain.own.linearization)
    term = create_term(one.id, AIRCRAFT)
    size = 0.02 * one.plausible_size
    changed = TRUTH.with_effect(one.id, {**term.defaults, one.parameter: size})
    flight_model = FlightModel(AIRCRAFT, changed)
    values = np.array(flight_model.defaults)
    start = initial_motion(plain.one.record, flight_model).states[8:]

    def along(own: FloatArray) -> tuple[Linearization, NominalMotion]:
        motion = NominalMotion(
            states=np.vstack((plain.one.motion.states, own)), gust=plain.one.motion.gust
        )
        return linearize_along(plain.one.record, flight_model, values, motion), motion

    # Its state runs along the motion: a step is a straight line in it.
    at_rest = along(np.zeros_like(start))[0].next_states[8]
    decays = along(np.ones_like(start))[0].next_states[8] - at_rest
    own = np.empty_like(start)
    own[0, 0] = start[0, 0]
    for k, (decay, moved) in enumerate(zip(decays, at_rest, strict=True)):
        own[0, k + 1] = decay * own[0, k] + moved
    found, motion = along(own)
    assert found.next_states[8] == pytest.approx(own[0, 1:], abs=1e-9)
    zero = np.zeros(len(plain.one.record.channels))
    after = create_filter(found, plain.fit.noise["virtual"], motion).residual(zero)
    before = plain.own.residual(zero)
    z = (before[0] - after[0]) / size
    # The states of the airframe are the same; the effect's own left no defect.
    b = (before[1] - np.delete(after[1], 8, axis=1)) / size
    expected, _ = plain.own.innovations(z[:, :, None], b[:, :, None])
    expected = (plain.own.whitener @ expected)[:, :, 0]
    assert column is not None
    assert error(plain.innovations(column), expected) < 0.06


def test_structure_without_a_name(plain: Prepared) -> None:
    """Products are what they say: alpha * de in Cm is the catalog's effect of that name."""
    found = plain.own.linearization
    bare = unnamed_candidates([], AIRCRAFT, throttle=True, flap=True)
    named = {
        one.id: one
        for one in catalog_candidates(
            [one for one in all_effects() if not one.disturbance], AIRCRAFT
        )
    }
    table = {one.id: one for one in bare}
    for ours_id, name in (
        ("Cm.alpha_de", "Cm.alpha_de"),
        ("Cl.da_alpha", "Cl.alpha_da"),
        ("Cn.r_alpha", "Cn.alpha_r"),
        ("Cm.alpha_q", "Cm.alpha_q"),
        ("Cn.beta3", "Cn.beta3"),
    ):
        ours = table[f"unnamed.{ours_id}"].build_column(found)
        theirs = named[f"aero.{name}"].build_column(found)
        assert ours[0].target == theirs[0].target
        size = np.dot(ours[0].history, theirs[0].history) / np.dot(*[theirs[0].history] * 2)
        assert ours[0].history == pytest.approx(size * theirs[0].history, rel=1e-9), name
    # What the catalog holds does not compete a second time without a name.
    rest = {
        one.id for one in unnamed_candidates([*named.values()], AIRCRAFT, throttle=True, flap=True)
    }
    assert rest < set(table)
    looks = {}
    for one in named.values():
        column = one.build_column(found)
        if column and column[0].target in ("CN", "CA", "CY", "Cl", "Cm", "Cn"):
            looks[one.id] = plain.innovations(column)
    for name in sorted(rest):
        ours = table[name].build_column(found)
        assert ours is not None
        own = plain.innovations(ours)
        for other, theirs in looks.items():
            size = np.linalg.norm(own) * np.linalg.norm(theirs)
            assert size == 0.0 or abs(np.vdot(own, theirs)) < 0.999999 * size, (name, other)
    # What a coefficient of the other axis follows late lacks the present: nothing else has it.
    late = table["unnamed.Cn.late_q"].build_column(found)
    present, past = np.abs(found.variables["q_hat"]), np.abs(late[0].history)
    assert past.max() < present.max()
    assert np.argmax(past) > np.argmax(present)
    assert {"unnamed.Cm.late_p", "unnamed.Cl.late_alpha"} < rest
    assert "unnamed.Cm.late_q" not in table
    assert not any(
        "throttle" in one.id for one in unnamed_candidates([], AIRCRAFT, throttle=False, flap=True)
    )


def test_screening_gains_are_those_of_a_refit() -> None:
    """Gain and size of candidates: plain least squares on all rows, initial states among them."""
    flown = [maneuver(seed, flight=f"v{seed % 2}", duration=4.0) for seed in (1, 2, 3)]
    fit = prepared(flown, TRUTH, DERIVATIVES)
    for flight in fit.noise:
        fit.noise[flight] = true_noise(gusts=1e-2, moments=1e-3)
    fit.linearize()
    wanted = ("aero.Cm.alpha2", "aero.Cl.alpha_beta", "sensor.beta.delay", "aero.CN.alpha2")
    competitors = [
        one
        for one in catalog_candidates([r for r in all_effects() if not r.disturbance], AIRCRAFT)
        if one.id in wanted
    ]
    found = screen_candidates(fit, competitors)

    # All rows of all maneuvers, written out: shared columns, biases by flight, initial states.
    biases = fit.bias_names()
    n_shared = len(DERIVATIVES) + len(competitors) + len(biases)
    n_x = 11
    rows, target = [], []
    for index, one in enumerate(fit.maneuvers):
        seen, _, n_local = fit.whitened_columns(
            one, lambda linear: [other.build_column(linear) or () for other in competitors]
        )
        assert n_local == n_x
        flat = seen.reshape(-1, seen.shape[2])
        wide = np.zeros((len(flat), n_shared + n_x * len(flown)))
        own = len(DERIVATIVES) + len(competitors)
        wide[:, :own] = flat[:, :own]
        for k, name in enumerate(one.record.channels):
            wide[:, own + biases.index(bias_name(one.record.flight, name))] = flat[:, own + k]
        first = n_shared + n_x * index
        wide[:, first : first + n_x] = flat[:, -1 - n_x : -1]
        rows.append(wide)
        target.append(flat[:, -1])
    prior = np.zeros((len(biases), rows[0].shape[1]))
    for k, name in enumerate(biases):
        value, std = fit.priors()[name]
        assert value == 0.0
        prior[k, len(DERIVATIVES) + len(competitors) + k] = 1.0 / std
    X, y = np.vstack((*rows, prior)), np.concatenate((*target, np.zeros(len(biases))))
    X = X / np.maximum(np.linalg.norm(X, axis=0), 1e-12)
    scale = np.linalg.norm(np.vstack((*rows, prior)), axis=0)
    model_only = [k for k in range(X.shape[1]) if not 0 <= k - len(DERIVATIVES) < len(competitors)]

    def fitted(columns: list[int]) -> tuple[float, float]:
        values, *_ = np.linalg.lstsq(X[:, columns], y, rcond=None)
        left = y - X[:, columns] @ values
        return float(left @ left), float(values[-1])

    without, _ = fitted(model_only)
    for k, one in enumerate(competitors):
        with_it, value = fitted([*model_only, len(DERIVATIVES) + k])
        index = found.index(one.id)
        size = value / scale[len(DERIVATIVES) + k]
        assert found.size[index] == pytest.approx(size, rel=1e-3)
        allowed = one.low <= size <= one.high
        assert found.gain[index] == pytest.approx(
            (without - with_it) if allowed else 0.0, rel=1e-3, abs=1e-5
        )
    assert float(found.projected_information.matrix[-1, -1]) == pytest.approx(without, rel=1e-5)


def test_a_size_that_makes_no_sense_gains_nothing() -> None:
    """A delay that would have to be negative: no gain, however well it fits."""
    flown = [maneuver(seed, duration=4.0) for seed in (1, 2)]
    early = [
        with_channel(
            one, "alpha", np.interp(one.block.times + 0.06, one.block.times, one.block["alpha"])
        )
        for one in flown
    ]
    records = [one for one in all_effects() if one.id == "sensor.alpha.delay"]
    competitors = catalog_candidates(records, AIRCRAFT)
    gains = []
    for given in (flown, early):
        fit = prepared(given, TRUTH)
        fit.linearize()
        found = screen_candidates(fit, competitors)
        gains.append(found)
    assert gains[1].size[0] < -0.02
    assert gains[1].gain[0] == 0.0
