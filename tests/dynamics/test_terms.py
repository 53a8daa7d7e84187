"""Every term of the registry keeps to the one interface."""

import math

import numpy as np
import pytest

from gsapp.aircraft import Aircraft
from gsapp.dynamics.buildup import create_linear_terms, derivative_names
from gsapp.dynamics.effects.unnamed_terms import is_unnamed, unnamed_ids
from gsapp.dynamics.model import Model, load_model
from gsapp.dynamics.signal_terms import SignalTerm
from gsapp.dynamics.simulation import stall_terms
from gsapp.dynamics.terms import (
    TARGETS,
    VARIABLES,
    Term,
    TermJacobian,
    create_term,
    effect_guidance,
    effect_ids,
    register_effect,
)
from gsapp.foundation import UnknownNameError

BUILD_UP = {term.id: term for term in create_linear_terms()}
UNNAMED = (
    "unnamed.CA.absbeta", "unnamed.Cm.alpha_de2", "unnamed.Cn.absr_r", "unnamed.CN.V2",
    "unnamed.Cm.table_alpha_q", "unnamed.CA.table_beta", "unnamed.Cm.late_de",
    "unnamed.Cn.late_q", "unnamed.Cl.beta_throttle",
)  # fmt: skip
EVERY = (*BUILD_UP, *effect_ids(), *UNNAMED)
TYPICAL = {
    "V": (30.0, 3.0), "thrust": (60.0, 10.0), "qbar": (500.0, 50.0), "rho": (1.2, 0.05),
    "ax": (1.0, 3.0), "ay": (0.5, 3.0), "an": (9.0, 3.0), "throttle": (0.5, 0.2),
}  # fmt: skip
NEEDED = [
    *(f"aero.{c}.alpha2" for c in ("Cm", "CN", "CA")), "aero.Cm.alphadot",
    *(f"aero.{c}.speed" for c in ("CX", "CZ", "Cm")),
    *(f"aero.{c}.flap" for c in ("Cm", "CN", "CA")),
    *(f"aero.{c}.{k}" for c in ("Cl", "Cn") for k in ("alpha_beta", "beta3")), "aero.Cm.beta2",
    "aero.Cn.da", "propulsion.Cm.throttle", "propulsion.Cn.asymmetry", "mass.cg.x",
    "mass.inertia.ixz",
    *(f"aero.{c}.alpha_de" for c in ("Cm", "CN", "CA")),
    *(f"aero.{c}.alpha_{s}" for c in ("Cl", "Cn", "CY") for s in ("da", "dr", "p", "r")),
    "aero.Cm.alpha_q", "aero.CN.alpha_q", "aero.Cl.alpha", "aero.Cn.alpha",
    "aero.Cm.de_falloff", "aero.Cl.da_falloff", "aero.Cn.dr_falloff",
    "propulsion.Cm.slipstream", "propulsion.thrust.scale",
    "mass.cg.z", "mass.mass.error", "mass.inertia.ixx", "mass.inertia.iyy", "mass.inertia.izz",
    *(f"control.{s}.{k}" for s in ("elevator", "aileron", "rudder")
      for k in ("backlash", "saturation", "lag", "rate", "delay")),
    *(f"sensor.{c}.{k}" for c in ("alpha", "beta", "q", "ay")
      for k in ("scale", "bias", "delay", "lag", "clipping", "reversed")),
    *(f"sensor.{c}.{k}" for c in ("de", "da", "dr", "V", "qbar")
      for k in ("scale", "bias", "delay")),
    *(f"sensor.{box}.delay" for box in ("airdata", "inertial", "surfaces")),
    *(f"sensor.accelerometer.{axis}" for axis in "xyz"), "sensor.alpha_vane.x",
    "sensor.p_r.swapped",
]  # fmt: skip


def term_of(name: str, aircraft: Aircraft) -> Term:
    return BUILD_UP.get(name) or create_term(name, aircraft)


def sample(term: Term, count: int, seed: int = 3) -> tuple[list, list, list]:
    random = np.random.default_rng(seed)

    def drawn(name: str) -> np.ndarray:
        mean, spread = TYPICAL.get(name, (0.05, 0.25))
        return mean + spread * random.standard_normal(count)

    reads = [drawn(name) for name in term.reads]
    states = [0.3 * random.standard_normal(count) for _ in term.states]
    parameters = [
        np.full(count, item.default or 0.7) * random.uniform(0.9, 1.1) for item in term.parameters
    ]
    return reads, states, parameters


def flat(jacobian: TermJacobian) -> list:
    own = zip(
        jacobian.rate_reads, jacobian.rate_states, jacobian.rate_parameters, strict=True
    )  # fmt: skip
    return [
        (*jacobian.reads, *jacobian.states, *jacobian.parameters),
        *(tuple(x for part in row for x in part) for row in own),
    ]


def outputs(term: Term, point: list, sizes: tuple[int, int]) -> list:
    reads, states, parameters = (
        point[: sizes[0]], point[sizes[0] : sum(sizes)], point[sum(sizes) :]
    )  # fmt: skip
    value = term.value(reads, states, parameters)
    return [value, *term.rates(reads, states, parameters)]


def test_structure_without_a_name_is_described_by_its_id(aircraft: Aircraft) -> None:
    """All ids that compete make a term, and a model file holds it; others make none."""
    ids = unnamed_ids(throttle=True, flap=True)
    assert len(set(ids)) == len(ids) > 200
    for name in ids:
        term = create_term(name, aircraft)
        assert (term.id, term.target) == (name, name.split(".")[1])
    kink = create_term("unnamed.CA.absbeta", aircraft)
    assert kink.value((-0.2,), (), (3.0,)) == kink.value((0.2,), (), (3.0,)) == pytest.approx(0.6)
    model = Model().with_effect("unnamed.Cm.alpha_de2", {"Cm_alpha_de2": 2.0})
    assert model.effects[0].values(aircraft) == (2.0,)
    assert not set(ids) & set(effect_ids())
    for wrong in ("unnamed.Cm", "unnamed.Cm.gamma2", "unnamed.XX.alpha2", "unnamed.Cm.alpha9"):
        assert not is_unnamed(wrong)
        with pytest.raises(UnknownNameError):
            create_term(wrong, aircraft)


def test_the_effects_for_hiding_are_all_there() -> None:
    assert not set(NEEDED) - set(effect_ids())


@pytest.mark.parametrize("name", EVERY)
def test_jacobian_equals_differences(name: str, aircraft: Aircraft) -> None:
    term = term_of(name, aircraft)
    reads, states, parameters = sample(term, 7)
    point = [*reads, *states, *parameters]
    sizes = (len(reads), len(states))
    rows = flat(term.jacobian(reads, states, parameters))
    assert len(rows) == 1 + len(term.states)
    for row in rows:
        assert len(row) == len(point)
    for column, x in enumerate(point):
        h = 1e-6 * max(1.0, float(np.abs(x).max()))
        up, down = list(point), list(point)
        up[column], down[column] = x + h, x - h
        high, low = outputs(term, up, sizes), outputs(term, down, sizes)
        for row, one, two in zip(rows, high, low, strict=True):
            numeric = (one - two) / (2 * h) + np.zeros(7)
            scale = 1.0 + np.abs(numeric)
            assert np.all(np.abs(row[column] - numeric) < 2e-6 * scale), (column, row[column])


@pytest.mark.parametrize("name", EVERY)
def test_single_numbers_give_what_arrays_give(name: str, aircraft: Aircraft) -> None:
    term = term_of(name, aircraft)
    parts = sample(term, 5)
    together = np.array(np.broadcast_arrays(*outputs(
        term, [*parts[0], *parts[1], *parts[2]], (len(parts[0]), len(parts[1]))
    ), np.zeros(5))[:-1])  # fmt: skip
    slopes = flat(term.jacobian(*parts))
    for k in range(5):
        single = [[float(x[k]) for x in part] for part in parts]
        values = [term.value(*single), *term.rates(*single)]
        assert np.allclose(together[:, k], values, rtol=1e-13, atol=1e-13)
        for one, many in zip(flat(term.jacobian(*single)), slopes, strict=True):
            for a, b in zip(one, many, strict=True):
                assert a == pytest.approx(float((b + np.zeros(5))[k]), rel=1e-12, abs=1e-12)


# Reversed and swapped signals have no size.
SIZED = [name for name in effect_ids() if not name.endswith((".reversed", ".swapped"))]


@pytest.mark.parametrize("name", SIZED)
def test_neutral_parameters_do_nothing(name: str, aircraft: Aircraft) -> None:
    term = create_term(name, aircraft)
    neutral = tuple(parameter.neutral for parameter in term.parameters)
    reads, states, _ = sample(term, 4)
    if isinstance(term, SignalTerm):
        signal = np.sin(np.arange(50) / 8.0)
        assert np.allclose(term.respond(signal, 0.01, neutral).values, signal, atol=1e-12)
    else:
        assert np.all(term.value(reads, states, neutral) == 0.0)


@pytest.mark.parametrize("name", EVERY)
def test_description_is_complete(name: str, aircraft: Aircraft) -> None:
    term = term_of(name, aircraft)
    assert term.title
    assert "=" in term.equation or "moves only" in term.equation or "<=" in term.equation
    outside = term.target.startswith(("control.", "sensor."))
    assert outside or (term.target in TARGETS and set(term.reads) <= set(VARIABLES))
    for item in term.parameters:
        assert item.bounds[0] <= item.default <= item.bounds[1]
        assert item.bounds[0] <= item.neutral <= item.bounds[1]
        assert item.description
    assert len({item.name for item in term.parameters}) == len(term.parameters)
    if name not in BUILD_UP:
        assert name == term.id
        assert name.count(".") == 2


@pytest.mark.parametrize("name", EVERY)
def test_states_at_rest_have_no_rate(name: str, aircraft: Aircraft) -> None:
    term = term_of(name, aircraft)
    reads, _, parameters = sample(term, 3)
    reads = [
        np.zeros(3) if name in term.rate_only_reads else one
        for name, one in zip(term.reads, reads, strict=True)
    ]
    rest = term.steady_state(reads, parameters)
    assert len(rest) == len(term.states)
    for rate in term.rates(reads, rest, parameters):
        assert np.all(rate == 0.0)


def test_the_virtual_stall_is_exactly_nothing_in_the_linear_range(aircraft: Aircraft) -> None:
    low, high = aircraft.limits.alpha_linear
    alpha = np.linspace(low, high, 101)
    for term in stall_terms(aircraft, load_model("b777")):
        values = tuple(term.defaults.values())
        assert np.all(term.value((alpha,), (), values) == 0.0)
        assert term.value((high + 0.05,), (), values) != 0.0
        assert term.value((low - 0.05,), (), values) != 0.0


def test_a_virtual_flow_separates_once(aircraft: Aircraft) -> None:
    """Proves that a stall of the model replaces the virtual one, of lift that of all."""
    model = load_model("b777")
    own = stall_terms(aircraft, model.with_effect("aero.Cm.stall", {}))
    assert [term.id for term in own] == ["aero.CN.stall", "aero.CA.stall"]
    assert stall_terms(aircraft, model.with_effect("aero.CN.stall", {})) == ()


def test_the_stall_is_that_of_kirchhoff(aircraft: Aircraft) -> None:
    """Proves lift factor, settled separation and hysteresis against the formulas of the source."""
    lift, moment = (create_term(f"aero.{name}.stall", aircraft) for name in ("CN", "Cm"))
    size, a1, alpha_star, tau1, tau2 = parameters = (-4.6, 20.0, 0.24, 0.3, 0.1)
    dt, V = 0.005, 20.0
    times = np.arange(0.0, 8.0, dt)
    alpha = 0.24 - 0.12 * np.cos(2.0 * np.pi * times / 8.0)
    alpha_dot = np.gradient(alpha, dt)
    hat = alpha_dot * aircraft.geometry.chord / (2.0 * V)
    reads = (alpha, np.full_like(alpha, V), hat)
    (X,) = lift.states_along(reads, parameters, dt)
    settled = 0.5 * (1.0 - np.tanh(a1 * (alpha - tau2 * alpha_dot - alpha_star)))
    assert tau1 * np.gradient(X, dt) + X == pytest.approx(settled, abs=2e-3)
    factor = ((1.0 + np.sqrt(X)) / 2.0) ** 2
    assert lift.value(reads, (X,), parameters) == pytest.approx(size * alpha * (1.0 - factor))
    assert moment.value(reads, (X,), parameters) == pytest.approx(size * (1.0 - X))
    # Attached longer on the way up than on the way down: half a cycle apart at the same alpha.
    assert X[400] > X[1200] + 0.2
    # The general way gives the same as the closed form.
    (general,) = Term.states_along(lift, reads, parameters, dt)
    assert general == pytest.approx(X, abs=1e-4)


def test_an_id_is_registered_once() -> None:
    with pytest.raises(ValueError, match="registered twice"):
        register_effect(
            "aero.Cm.alpha2",
            lambda _: create_linear_terms()[0],
            effect_guidance("aero.Cm.alpha2"),
        )


def test_an_id_has_a_known_group() -> None:
    with pytest.raises(ValueError, match="group"):
        register_effect(
            "flow.Cm.alpha2",
            lambda _: create_linear_terms()[0],
            effect_guidance("aero.Cm.alpha2"),
        )


def test_an_unknown_effect_is_named_with_its_neighbors(aircraft: Aircraft) -> None:
    with pytest.raises(UnknownNameError, match=r"aero\.Cm\.alpha2"):
        create_term("aero.Cm.alfa2", aircraft)


def test_an_unknown_parameter_is_named_with_its_neighbors(aircraft: Aircraft) -> None:
    term = create_term("control.elevator.backlash", aircraft)
    with pytest.raises(UnknownNameError, match="'slop'"):
        term.values_for({"slopp": 0.1})
    assert term.values_for({"slop": 0.1}) == (0.1,)


def test_derivative_names_are_those_of_the_design() -> None:
    names = derivative_names()
    assert len(names) == 30
    assert {"CN_0", "CA_de", "Cm_q", "CY_dr", "Cl_da", "Cn_r"} <= set(names)


def test_memory_tends_to_the_rate_of_the_variable(aircraft: Aircraft) -> None:
    term = create_term("aero.Cm.memory", aircraft)
    values = (2.0, 0.1)
    x, dt = 0.0, 1e-3
    for k in range(2000):
        (rate,) = term.rates((0.5 * k * dt,), (x,), values)
        x += dt * rate
    assert term.value((0.5 * 2.0,), (x,), values) == pytest.approx(2.0 * 0.1 * 0.5, rel=2e-2)
    assert math.isfinite(x)
