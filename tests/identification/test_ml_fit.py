"""Maximum likelihood on virtual maneuvers whose derivatives are known."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from gsapp.aircraft import load_aircraft
from gsapp.dynamics.model import load_model
from gsapp.dynamics.terms import create_term
from gsapp.foundation import FlightError, UnknownNameError
from gsapp.identification.axes import axis_derivatives
from gsapp.identification.maximum_likelihood import MLSettings, estimate, fit, simulate
from gsapp.quantities import Block
from tests.identification.virtual_maneuvers import edited, fly, without

BASE = load_model("b777")
# Five standard deviations: once in a million, were the bounds exact.
FAR = 5.0


def off(found, truth):
    return {
        name: (found.value(name) - truth[name]) / found.derivatives[name].std
        for name in found.free
        if name in truth
    }


def missing(first, last):
    def change(samples):
        samples[first:last] = np.nan
        return samples

    return change


def along(maneuver, channel, effect, *parameters):
    term = create_term(effect, maneuver.aircraft)
    return edited(maneuver, **{channel: lambda x: term.respond(x, maneuver.dt, parameters).values})


@pytest.fixture(scope="module")
def lon():
    return fly(1, "lon", model=BASE)


@pytest.fixture(scope="module")
def lat():
    return fly(2, "lat", model=BASE)


# --- truth --------------------------------------------------------------------------------------


@pytest.mark.parametrize(("kind", "count"), [("lon", 12), ("lat", 18), ("both", 30)])
def test_all_derivatives_are_found_within_their_bounds(kind, count):
    """Of another integration of other equations of motion, with noise and 12-bit converters."""
    virtual = fly(11, kind)
    found = estimate([virtual.maneuver], MLSettings(axis=kind))
    assert found.converged
    assert found.iterations <= 6
    assert len(found.free) == count
    assert set(found.free) == set(axis_derivatives(kind))
    wrong = off(found, virtual.truth)
    assert max(abs(z) for z in wrong.values()) < FAR
    assert found.covariance.shape == (count, count)
    for name, std in zip(found.free, np.sqrt(found.covariance.diagonal()), strict=True):
        assert found.derivatives[name].std == pytest.approx(std)
        assert found.derivatives[name].cramer_rao > 0.0


@pytest.mark.parametrize("kind", ["lon", "lat"])
def test_without_noise_the_truth_comes_back(kind):
    virtual = fly(4, kind, noise=0.0, model=BASE)
    found = estimate([virtual.maneuver], MLSettings(axis=kind))
    for name, true in virtual.truth.items():
        size = {"CN": 5.0, "CA": 0.1, "CY": 0.6, "Cl": 0.4, "Cm": 1.0, "Cn": 0.1}[name[:2]]
        assert found.value(name) == pytest.approx(true, rel=5e-3, abs=5e-3 * size), name


def test_a_single_surface_frees_its_own_derivatives_only(lat):
    found = estimate([replace(lat.maneuver, inputs=("da",))], MLSettings(axis="lat"))
    assert found.derivatives["Cn_dr"].status == "held"
    assert "Cn_dr" not in found.free
    assert len(found.free) == 15


def test_derivatives_may_be_held_freed_and_started(lon):
    settings = MLSettings(axis="lon", held={"CA_q": 0.0, "Cm_q": -23.0}, start={"Cm_alpha": -0.2})
    found = estimate([lon.maneuver], settings)
    assert found.value("Cm_q") == -23.0
    assert found.derivatives["Cm_q"].status == "held"
    assert found.derivatives["Cm_q"].std is None
    assert len(found.free) == 10
    assert max(map(abs, off(found, lon.truth).values())) < FAR
    only = estimate(
        [lon.maneuver], MLSettings(axis="lon", model=BASE, free=("Cm_alpha", "Cm_q", "Cm_de"))
    )
    assert only.free == ("Cm_alpha", "Cm_q", "Cm_de")
    assert only.value("CN_alpha") == BASE.derivative("CN_alpha")
    # What is known need not be estimated: the bounds shrink.
    assert only.derivatives["Cm_alpha"].std < found.derivatives["Cm_alpha"].std


# --- weights, priors, bounds --------------------------------------------------------------------


def test_the_scale_of_given_weights_is_of_no_account(lon):
    weights = {"alpha": 3e5, "q": 3e3, "an": 400.0, "ax": 400.0}
    priors = {"CN_q": (5.0, 0.2)}
    one = estimate([lon.maneuver], MLSettings(axis="lon", weights=weights, priors=priors))
    scaled = {name: 1e-3 * weight for name, weight in weights.items()}
    other = estimate([lon.maneuver], MLSettings(axis="lon", weights=scaled, priors=priors))
    for name in one.free:
        assert one.value(name) == pytest.approx(other.value(name), rel=1e-6, abs=1e-9)
        assert one.derivatives[name].std == pytest.approx(other.derivatives[name].std, rel=1e-4)
    assert max(map(abs, off(one, lon.truth).values())) < FAR


def test_a_response_with_weight_zero_or_none_is_switched_off(lon):
    settings = MLSettings(axis="lon", weights={"alpha": 3e5, "q": 3e3, "an": 400.0, "ax": 0.0})
    found = estimate([lon.maneuver], settings)
    assert set(found.fit) == {"alpha", "q", "an"}
    bound = found.derivatives["CA_0"].std
    assert bound is None or bound > 0.01


def test_an_a_priori_value_pulls_as_hard_as_it_is_sure(lon):
    free = estimate([lon.maneuver], MLSettings(axis="lon", tolerance=1e-10))
    value, bound = free.value("CN_q"), free.derivatives["CN_q"].cramer_rao
    away = value + 6.0 * bound

    def pulled(std):
        settings = MLSettings(axis="lon", priors={"CN_q": (away, std)}, tolerance=1e-10)
        return estimate([lon.maneuver], settings)

    assert pulled(1e-4 * bound).value("CN_q") == pytest.approx(away, abs=0.01 * bound)
    assert pulled(1e4 * bound).value("CN_q") == pytest.approx(value, abs=0.01 * bound)
    half = pulled(bound)
    assert half.value("CN_q") == pytest.approx(0.5 * (value + away), abs=0.2 * bound)
    assert half.derivatives["CN_q"].cramer_rao == pytest.approx(bound / np.sqrt(2.0), rel=0.03)


def test_an_a_priori_value_of_something_held_is_pointed_out(lon):
    settings = MLSettings(axis="lon", held={"CA_q": 0.0}, priors={"CA_q": (0.0, 1.0)})
    found = estimate([lon.maneuver], settings)
    assert any("CA_q" in warning and "is not used" in warning for warning in found.warnings)


def test_the_source_factor_takes_the_place_of_the_correction(lon):
    found = estimate([lon.maneuver], MLSettings(axis="lon", bound_factor=10.0))
    for name in found.free:
        one = found.derivatives[name]
        assert one.std == pytest.approx(10.0 * one.cramer_rao)


def test_noise_of_responses_may_be_taken_as_dependent(lon):
    one = estimate([lon.maneuver], MLSettings(axis="lon"))
    other = estimate([lon.maneuver], MLSettings(axis="lon", noise="full"))
    assert other.converged
    for name in one.free:
        assert abs(one.value(name) - other.value(name)) < one.derivatives[name].std


def test_the_default_tolerance_is_tight_and_a_tighter_one_is_rounding(lon, lat):
    """1e-6 is within a thousandth of a bound of the minimum; the minimum itself is one."""
    for axis, virtual in (("lon", lon), ("lat", lat)):
        usual = fit([virtual.maneuver], MLSettings(axis=axis))
        exact = fit([virtual.maneuver], MLSettings(axis=axis, tolerance=1e-14))
        again = fit(
            [virtual.maneuver],
            MLSettings(
                axis=axis,
                tolerance=1e-14,
                start={name: 1.02 * exact.value(name) for name in exact.estimate.free},
            ),
        )
        bounds = np.sqrt(exact.covariance.diagonal())
        assert (np.abs(usual.values - exact.values) < 1e-3 * bounds).all()
        assert (np.abs(again.values - exact.values) < 1e-7 * bounds).all()


# --- several maneuvers --------------------------------------------------------------------------


def test_several_flights_with_own_mass_and_inertia_in_one_fit():
    plain = load_aircraft("b777")
    heavy = plain.model_copy(
        update={
            "mass": plain.mass.model_copy(
                update={"mass": 1.15 * plain.mass.mass, "iyy": 1.2 * plain.mass.iyy}
            )
        }
    )
    first = fly(21, "lon", model=BASE, aircraft=plain)
    second = fly(22, "lon", model=BASE, aircraft=heavy)
    one = replace(first.maneuver, id="1:1", flight="A")
    two = replace(second.maneuver, id="2:1", flight="C")
    joint = estimate([one, two], MLSettings(axis="lon"))
    assert joint.maneuvers == ("1:1", "2:1")
    assert len(joint.histories) == 2
    assert max(map(abs, off(joint, first.truth).values())) < FAR
    singles = [estimate([each], MLSettings(axis="lon")) for each in (one, two)]
    for name in joint.free:
        assert joint.derivatives[name].std < min(s.derivatives[name].std for s in singles)
    assert {"1:1.bias.an", "2:1.bias.an", "2:1.initial.alpha"} <= joint.nuisance.keys()
    # The wrong aircraft for the second shows.
    swapped = estimate([one, replace(two, aircraft=plain)], MLSettings(axis="lon"))
    assert abs(off(swapped, first.truth)["Cm_de"]) > FAR


def test_weights_may_differ_between_maneuvers(lon):
    other = fly(23, "lon", model=BASE)
    broken = replace(edited(other.maneuver, alpha=lambda x: 1.3 * x), id="broken")
    weights = {"alpha": 3e5, "q": 3e3, "an": 400.0, "ax": 400.0}
    faint = {name: 1e-6 * weight for name, weight in weights.items()}
    maneuvers = [lon.maneuver, broken]
    alike = estimate(maneuvers, MLSettings(axis="lon", weights=weights))
    apart = estimate(
        maneuvers, MLSettings(axis="lon", weights=weights, joint_weights={"broken": faint})
    )
    truth = lon.truth["CN_alpha"]
    assert abs(apart.value("CN_alpha") - truth) < 0.2 * abs(alike.value("CN_alpha") - truth)


# --- gaps and missing channels ------------------------------------------------------------------


def test_missing_samples_of_a_response_do_not_count(lon):
    hole = edited(lon.maneuver, alpha=missing(300, 420))

    def nonsense(samples):
        samples[300:420] = 9.0
        return samples

    clipped = np.zeros(len(hole.block), dtype=bool)
    clipped[300:420] = True
    wild = replace(edited(lon.maneuver, alpha=nonsense), clipped={"alpha": clipped})
    one, other = (estimate([each], MLSettings(axis="lon")) for each in (hole, wild))
    assert one.fit["alpha"].samples == len(hole.block) - 120
    assert one.fit["q"].samples == len(hole.block)
    for name in one.free:
        assert one.value(name) == pytest.approx(other.value(name), rel=1e-9)
    assert max(map(abs, off(one, lon.truth).values())) < FAR
    history = one.histories[0]
    column = history.channels.index("alpha")
    assert np.isnan(history.measured[300:420, column]).all()
    assert np.isfinite(history.computed).all()


def test_a_gap_in_time_or_in_the_input_starts_a_new_segment(lon):
    block = lon.maneuver.block
    kept = np.r_[0:400, 470 : len(block)]
    gap = replace(
        lon.maneuver,
        block=Block(channels=block.channels, times=block.times[kept], values=block.values[kept]),
    )
    lost = edited(lon.maneuver, de=missing(400, 470))
    for maneuver in (gap, lost):
        found = estimate([maneuver], MLSettings(axis="lon"))
        assert {"1.initial.alpha", "1.initial.alpha.2"} <= found.nuisance.keys()
        assert max(map(abs, off(found, lon.truth).values())) < FAR
        assert found.fit["q"].samples == len(block) - 70
    short = estimate([edited(lon.maneuver, de=missing(400, 405))], MLSettings(axis="lon"))
    assert "1.initial.alpha.2" not in short.nuisance
    assert short.fit["q"].samples == len(block) - 5
    assert max(map(abs, off(short, lon.truth).values())) < FAR


def test_a_flight_without_vanes_and_airspeed_still_gives_something(lat):
    bare = without(lat.maneuver, "alpha", "beta", "V")
    stand_ins = {"V": float(lat.motion["u"].mean()), "alpha": 0.06}
    found = estimate([bare], MLSettings(axis="lat", stand_ins=stand_ins))
    assert set(found.fit) == {"p", "r", "ay"}
    assert found.converged
    assert found.value("Cl_p") == pytest.approx(lat.truth["Cl_p"], rel=0.15)
    assert found.value("Cl_da") == pytest.approx(lat.truth["Cl_da"], rel=0.15)
    assert found.value("Cn_beta") == pytest.approx(lat.truth["Cn_beta"], rel=0.25)
    assert any("beta" in warning for warning in found.warnings)


@pytest.mark.parametrize(("kind", "name"), [("lon", "theta"), ("lat", "phi")])
def test_attitude_that_was_not_measured_is_computed_along(kind, name, lon, lat):
    virtual = {"lon": lon, "lat": lat}[kind]
    found = estimate([without(virtual.maneuver, "phi", "theta")], MLSettings(axis=kind))
    assert any(name in warning and "computed" in warning for warning in found.warnings)
    assert max(map(abs, off(found, virtual.truth).values())) < FAR


# --- instruments and effects --------------------------------------------------------------------


def test_scale_factors_and_time_shifts_of_instruments_are_found(lon):
    changed = along(lon.maneuver, "alpha", "sensor.alpha.scale", 1.1)
    changed = along(changed, "an", "sensor.an.delay", 0.05)
    settings = MLSettings(axis="lon", scale_factors=("alpha",), time_shifts=("an",))
    found = estimate([changed], settings)
    scale, scale_std = found.nuisance["1.scale.alpha"]
    shift, shift_std = found.nuisance["1.shift.an"]
    assert abs(scale - 1.1) < FAR * scale_std < 0.1
    assert abs(shift - 0.05) < FAR * shift_std < 0.02
    assert max(map(abs, off(found, lon.truth).values())) < FAR


@pytest.mark.parametrize(
    ("effect", "true", "start"),
    [
        ("aero.Cm.alpha2", {"Cm_alpha2": -4.0}, {"Cm_alpha2": 0.0}),
        ("aero.CN.memory", {"CN_memory": 1.5, "tau": 0.15}, {"CN_memory": 0.5, "tau": 0.15}),
        ("aero.Cm.alphadot", {"Cm_alphadot": -8.0}, {"Cm_alphadot": 0.0}),
        ("mass.cg.x", {"x": 0.03}, None),
    ],
)
def test_effects_in_the_equations_join_the_fit(effect, true, start):
    flown = BASE.with_effect(effect, true)
    virtual = fly(31, "lon", model=flown)
    name = f"{effect}.{next(iter(true))}"
    if start is None:
        found = estimate([virtual.maneuver], MLSettings(axis="lon", model=flown))
    else:
        settings = MLSettings(
            axis="lon", model=BASE.with_effect(effect, start), free_effects=(name,)
        )
        found = estimate([virtual.maneuver], settings)
        one = found.derivatives[name]
        assert one.status == "estimated"
        assert abs(one.value - next(iter(true.values()))) < FAR * one.std
    assert max(map(abs, off(found, virtual.truth).values())) < FAR


def test_an_effect_left_out_shows_in_color_and_wrong_values():
    virtual = fly(31, "lon", model=BASE.with_effect("aero.Cm.alphadot", {"Cm_alphadot": -12.0}))
    found = estimate([virtual.maneuver], MLSettings(axis="lon"))
    assert max(map(abs, off(found, virtual.truth).values())) > FAR


def test_a_response_in_another_unit_takes_the_values_their_credit(lon):
    for wrong in ({"an": lambda an: 9.81 * an}, {"q": lambda q: q / 57.3}):
        found = estimate([edited(lon.maneuver, **wrong)], MLSettings(axis="lon"))
        (said,) = [one for one in found.warnings if "does not follow" in one]
        assert "an (R2" in said
        assert "gsapp compatibility" in said
    honest = estimate([lon.maneuver], MLSettings(axis="lon"))
    assert not [one for one in honest.warnings if "does not follow" in one]


@pytest.mark.parametrize(
    ("effect", "name", "true", "start"),
    [
        ("sensor.alpha.scale", "scale", 1.1, 1.0),
        ("sensor.alpha.lag", "tau", 0.06, 0.02),
        ("sensor.an.delay", "delay", 0.04, 0.02),
    ],
)
def test_effects_on_an_instrument_join_the_fit(lon, effect, name, true, start):
    changed = along(lon.maneuver, effect.split(".")[1], effect, true)
    settings = MLSettings(
        axis="lon",
        model=BASE.with_effect(effect, {name: start}),
        free_effects=(f"{effect}.{name}",),
        free=axis_derivatives("lon"),
    )
    found = estimate([changed], settings)
    one = found.derivatives[f"{effect}.{name}"]
    assert abs(one.value - true) < FAR * one.std
    assert one.std < 0.1 * abs(true)


def test_the_lag_of_a_servo_behind_the_recorded_command_is_found():
    """The command is what makes the true deflection after a lag of 0.08 s."""
    virtual = fly(7, "lon", model=BASE)
    deflection = virtual.motion["de"]
    command = deflection + 0.08 * np.gradient(deflection, virtual.maneuver.dt)
    commanded = edited(virtual.maneuver, de=lambda _: command)
    effect = "control.elevator.lag"
    settings = MLSettings(
        axis="lon",
        model=BASE.with_effect(effect, {"tau": 0.03}),
        free_effects=(f"{effect}.tau",),
        held={"Cm_q": BASE.derivative("Cm_q")},
    )
    found = estimate([commanded], settings)
    one = found.derivatives[f"{effect}.tau"]
    assert one.value == pytest.approx(0.08, abs=0.005)
    assert found.value("Cm_de") == pytest.approx(BASE.derivative("Cm_de"), rel=0.05)


def test_gearing_and_control_power_cannot_be_told_apart(lon):
    effect = "control.elevator.gearing"
    settings = MLSettings(
        axis="lon", model=BASE.with_effect(effect, {"gearing": 1.0}),
        free_effects=(f"{effect}.gearing",), free=axis_derivatives("lon"),
    )  # fmt: skip
    found = estimate([lon.maneuver], settings)
    for name in ("Cm_de", f"{effect}.gearing"):
        assert found.derivatives[name].status == "not-identifiable"
        assert found.derivatives[name].value is None
    assert f"{effect}.gearing" in found.derivatives["Cm_de"].confounded_with
    wrong = off(found, lon.truth)
    assert {"Cm_alpha", "Cm_q", "CN_alpha"} <= wrong.keys()
    assert max(map(abs, wrong.values())) < FAR


# --- the rest of the interface ------------------------------------------------------------------


def test_euler_is_another_integration(lon):
    """Selectable; at 100 Hz it differs by more than a bound, RK4 does not."""
    found = estimate([lon.maneuver], MLSettings(axis="lon", integration="euler"))
    assert found.converged
    exact = estimate([lon.maneuver], MLSettings(axis="lon"))
    moved = abs(found.value("Cm_q") - exact.value("Cm_q")) / exact.derivatives["Cm_q"].std
    assert moved > 1.0


def test_progress_is_reported_and_may_stop_the_fit(lat):
    reports = []
    estimate([lat.maneuver], MLSettings(axis="lat", tolerance=1e-12), progress=reports.append)
    assert [one.iteration for one in reports] == [*range(1, len(reports) + 1)]
    costs = [one.cost for one in reports]
    assert all(b <= a * (1.0 + 1e-9) for a, b in pairwise(costs))
    stopped = estimate([lat.maneuver], MLSettings(axis="lat"), progress=lambda _: False)
    assert not stopped.converged
    assert "interrupted" in stopped.message
    assert stopped.free == ()
    assert stopped.derivatives["Cl_p"].value is None


def test_a_solution_keeps_what_tests_and_predictions_need(lat):
    solution = fit([lat.maneuver], MLSettings(axis="lat", tolerance=1e-12))
    part = solution.parts[0]
    count = len(lat.maneuver.block)
    assert part.sensitivities.shape == (count, 4, len(solution.names))
    assert part.residuals.shape == (count, 4)
    # White noise of the size that the weights say.
    assert np.einsum("nr,rs,ns->", part.residuals, part.weights, part.residuals) == pytest.approx(
        4 * count, rel=1e-6
    )
    # At the minimum the gradient vanishes; the information is that of the sensitivities.
    gradient = np.einsum("nrp,rs,ns->p", part.sensitivities, part.weights, part.residuals)
    scale = np.sqrt(solution.information.diagonal())
    assert np.abs(gradient / scale).max() < 1e-4
    H = np.einsum("nrp,rs,nsq->pq", part.sensitivities, part.weights, part.sensitivities)
    assert np.allclose(H / scale / scale[:, None], solution.information / scale / scale[:, None])
    assert solution.value("Cl_p") == solution.estimate.value("Cl_p")


def test_simulation_with_the_estimate_gives_the_fit_again(lon):
    settings = MLSettings(axis="lon", tolerance=1e-12)
    found = estimate([lon.maneuver], settings)
    values = {name: found.value(name) for name in found.free}
    nuisance = {name: value for name, (value, _) in found.nuisance.items()}
    again = simulate(lon.maneuver, values, settings, nuisance=nuisance)
    assert again.channels == found.histories[0].channels
    assert np.abs(again.computed - found.histories[0].computed).max() < 1e-9
    fitted = simulate(lon.maneuver, values, settings, fit_nuisance=True)
    assert np.abs(fitted.computed - again.computed).max() < 1e-4
    with pytest.raises(FlightError, match="diverges"):
        simulate(lon.maneuver, {**values, "Cm_alpha": 30.0, "Cm_q": 50.0}, settings)


def test_names_that_nobody_knows_are_refused(lon):
    for settings in (
        MLSettings(axis="lon", held={"Cm_gamma": 1.0}),
        MLSettings(axis="lon", free=("Cm_alfa",)),
        MLSettings(axis="lon", free_effects=("aero.Cm.alpha2.Cm_alpha2",)),
    ):
        with pytest.raises(UnknownNameError):
            estimate([lon.maneuver], settings)
    with pytest.raises(FlightError, match="responses"):
        MLSettings(axis="lon", responses=("altitude",))
    with pytest.raises(FlightError, match="standard deviation"):
        MLSettings(axis="lon", priors={"Cm_q": (-23.0, 0.0)})
    with pytest.raises(FlightError, match="greater than or equal to 0"):
        MLSettings(axis="lon", weights={"q": -1.0})


def test_reports_of_gusts_point_to_filter_error():
    gusty = fly(9, "lon", gust=0.8)
    found = estimate([gusty.maneuver], MLSettings(axis="lon"))
    assert any("turbulence" in one and "filter error" in one for one in found.warnings)
    calm = fly(9, "lon")
    found = estimate([calm.maneuver], MLSettings(axis="lon"))
    assert not any("turbulence" in one for one in found.warnings)


def test_responses_and_states_can_be_switched(lon):
    few = estimate([lon.maneuver], MLSettings(axis="lon", responses=("alpha", "q")))
    assert set(few.fit) == {"alpha", "q"}
    more = MLSettings(
        axis="lon",
        states=("V", "alpha", "q", "theta"),
        responses=("V", "alpha", "q", "theta", "an", "ax"),
    )
    found = estimate([lon.maneuver], more)
    assert set(found.fit) == {"V", "alpha", "q", "theta", "an", "ax"}
    assert {"1.initial.V", "1.initial.theta"} <= found.nuisance.keys()
    assert found.value("Cm_alpha") == pytest.approx(lon.truth["Cm_alpha"], rel=0.05)
    assert found.value("Cm_de") == pytest.approx(lon.truth["Cm_de"], rel=0.05)


def test_without_ax_the_axial_force_takes_nothing_of_the_normal_force_along():
    """With its constants free, the bound of Cm_alpha doubled and Cm_q fell off by 2.5 bounds."""
    virtual = fly(2001, "lon", dt=0.02)
    whole = estimate([virtual.maneuver], MLSettings(axis="lon"))
    few = estimate([virtual.maneuver], MLSettings(axis="lon", responses=("alpha", "q", "an")))
    assert {few.derivatives[name].status for name in ("CA_0", "CA_alpha", "CA_q", "CA_de")} == {
        "unknown"
    }
    for name in ("CN_alpha", "CN_de", "Cm_alpha", "Cm_q", "Cm_de"):
        one, other = whole.derivatives[name], few.derivatives[name]
        assert other.std == pytest.approx(one.std, rel=0.03)
        assert other.value == pytest.approx(one.value, abs=0.2 * one.std)


def test_a_measured_input_is_neither_integrated_nor_compared(lat):
    found = estimate([lat.maneuver], MLSettings(axis="lat", measured_inputs=("beta",)))
    assert set(found.fit) == {"p", "r", "ay"}
    assert not [name for name in found.nuisance if "initial.beta" in name]
    wrong = off(found, lat.truth)
    assert max(abs(z) for z in wrong.values()) < FAR
    by_states = estimate([lat.maneuver], MLSettings(axis="lat", states=("p", "r")))
    assert by_states.value("Cn_beta") == found.value("Cn_beta")
