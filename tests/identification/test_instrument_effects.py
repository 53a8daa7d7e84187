"""Effects of a model on instruments and control paths, undone in the record."""

from dataclasses import replace

import numpy as np
import pytest

from gsapp.dynamics.actuators import simulate_control_path
from gsapp.dynamics.model import Model, load_model
from gsapp.dynamics.terms import create_term
from gsapp.identification import equation_error
from gsapp.identification.campaign import CampaignSettings, run_campaign
from gsapp.identification.coefficients import reconstruct_coefficients
from gsapp.identification.instrument_effects import (
    effective_record,
    effective_records,
    has_instrument_effects,
    undo_instrument_effects,
    without_path_effects,
)
from gsapp.identification.maximum_likelihood import MLSettings, estimate
from tests.identification.virtual_maneuvers import edited, fly

BASE = load_model("b777")
INNER = slice(60, -60)


@pytest.fixture(scope="module")
def clean():
    return fly(8, "both", model=BASE, noise=0.0)


def recorded(maneuver, effect, channels, *parameters):
    term = create_term(effect, maneuver.aircraft)
    return edited(
        maneuver,
        **{name: lambda x: term.respond(x, maneuver.dt, parameters).values for name in channels},
    )


def with_sensor(maneuver, instrument, axis, by):
    sensors = maneuver.aircraft.sensors
    old = getattr(sensors, instrument)
    position = tuple(p + by * (k == axis) for p, k in zip(old.position, "xyz", strict=True))
    moved = sensors.model_copy(update={instrument: old.model_copy(update={"position": position})})
    return replace(maneuver, aircraft=maneuver.aircraft.model_copy(update={"sensors": moved}))


@pytest.mark.parametrize(
    ("effect", "channels", "given"),
    [
        ("sensor.alpha.scale", ("alpha",), {"scale": 1.3}),
        ("sensor.q.bias", ("q",), {"bias": 0.05}),
        ("sensor.ay.reversed", ("ay",), {}),
        ("sensor.beta.delay", ("beta",), {"delay": 0.04}),
        ("sensor.alpha.lag", ("alpha",), {"tau": 0.05}),
        ("sensor.airdata.delay", ("alpha", "beta", "V"), {"delay": 0.03}),
        ("sensor.surfaces.delay", ("de", "da", "dr"), {"delay": 0.03}),
    ],
)
def test_the_record_comes_back(clean, effect, channels, given) -> None:
    shown = recorded(clean.maneuver, effect, channels, *given.values())
    back = undo_instrument_effects(shown, BASE.with_effect(effect, given))
    for name in clean.maneuver.block.channels:
        true, wrong, found = (one.samples(name)[INNER] for one in (clean.maneuver, shown, back))
        if name in channels:
            harm = np.sqrt(np.mean((wrong - true) ** 2))
            assert harm > 0.0
            assert np.sqrt(np.mean((found - true) ** 2)) < 0.12 * harm, name
        else:
            assert np.array_equal(found, true, equal_nan=True), name


def test_missing_samples_stay_missing_and_spread_no_further_than_they_must(clean) -> None:
    def gap(x):
        x[100:110] = np.nan
        return x

    holed = edited(clean.maneuver, q=gap)
    back = undo_instrument_effects(holed, BASE.with_effect("sensor.q.delay", {"delay": 0.02}))
    lost = np.flatnonzero(~np.isfinite(back.samples("q")))
    # Two samples late: what is right for sample k was recorded at k + 2.
    assert lost.tolist() == list(range(98, 108))


def test_what_was_cut_off_is_missing(clean) -> None:
    limit = 0.5 * float(np.abs(clean.maneuver.samples("q")).max())
    shown = recorded(clean.maneuver, "sensor.q.clipping", ("q",), limit)
    back = undo_instrument_effects(shown, BASE.with_effect("sensor.q.clipping", {"limit": limit}))
    beyond = np.abs(clean.maneuver.samples("q")) >= limit
    assert beyond.any()
    assert np.array_equal(~np.isfinite(back.samples("q")), beyond)


def test_swapped_channels_go_back_with_their_flags(clean) -> None:
    names = clean.maneuver.block.channels
    p, r = (clean.maneuver.samples(name) for name in "pr")
    flags = np.zeros(p.size, dtype=bool)
    flags[5] = True
    swapped = replace(edited(clean.maneuver, p=lambda _: r, r=lambda _: p), clipped={"p": flags})
    back = undo_instrument_effects(swapped, BASE.with_effect("sensor.p_r.swapped"), keep=names)
    assert np.array_equal(back.block["p"], p)
    assert np.array_equal(back.block["r"], r)
    assert set(back.clipped) == {"r"}


def test_nothing_to_undo_is_the_same_object(clean) -> None:
    bent = BASE.with_effect("aero.Cm.alpha2")
    assert not has_instrument_effects(bent)
    assert not has_instrument_effects(None)
    assert undo_instrument_effects(clean.maneuver, bent) is clean.maneuver
    assert effective_records([clean.maneuver], bent)[1] is bent
    late = bent.with_effect("sensor.q.delay")
    assert has_instrument_effects(late)
    assert [one.id for one in without_path_effects(late).effects] == ["aero.Cm.alpha2"]


def test_a_misplaced_accelerometer_is_put_right(clean) -> None:
    wrong = with_sensor(clean.maneuver, "accelerometer", "z", -0.4)
    model = Model().with_effect("sensor.accelerometer.z", {"z": 0.4})
    right, bad, good = (
        reconstruct_coefficients(clean.maneuver).value("CY"),
        reconstruct_coefficients(wrong).value("CY"),
        reconstruct_coefficients(wrong, model=model).value("CY"),
    )
    harm = np.nanmax(np.abs(bad - right))
    assert harm > 1e-3
    assert np.nanmax(np.abs(good - right)) < 1e-9
    assert effective_record(wrong, model).aircraft.sensors.accelerometer.position[
        2
    ] == pytest.approx(clean.maneuver.aircraft.sensors.accelerometer.position[2])


@pytest.mark.parametrize(
    ("effect", "given", "channel"),
    [
        ("control.elevator.lag", {"tau": 0.08}, "de"),
        ("control.elevator.gearing", {"gearing": 0.7}, "de"),
        ("control.elevator.backlash", {"slop": 0.02}, "de"),
    ],
)
def test_a_control_path_is_walked_forward(clean, effect, given, channel) -> None:
    term = create_term(effect, clean.maneuver.aircraft)
    found = effective_record(clean.maneuver, BASE.with_effect(effect, given)).samples(channel)
    path = ((term, tuple(given.values())),)
    expected = simulate_control_path(path, clean.maneuver.samples(channel), clean.maneuver.dt)
    assert np.allclose(found, expected.values, atol=1e-14)


def test_equation_error_runs_with_a_revised_model() -> None:
    virtual = fly(21, "lon", model=BASE)
    effect = "sensor.surfaces.delay"
    late = recorded(virtual.maneuver, effect, ("de",), 0.05)
    model = Model().with_effect(effect, {"delay": 0.05})
    right = equation_error.estimate([virtual.maneuver], "lon", delays={})
    bent = equation_error.estimate([late], "lon", delays={})
    found = equation_error.estimate([late], "lon", model=model, delays={})
    std = right.derivatives["Cm_de"].std
    assert abs(bent.value("Cm_de") - right.value("Cm_de")) > 5.0 * std
    assert abs(found.value("Cm_de") - right.value("Cm_de")) < 2.0 * std


def test_transform_regression_runs_with_a_revised_model() -> None:
    sound = fly(3, "lon", model=BASE).maneuver
    shown = recorded(sound, "sensor.alpha.scale", ("alpha",), 1.25)
    model = BASE.with_effect("sensor.alpha.scale", {"scale": 1.25})
    plain = CampaignSettings(method="ftr")
    revised = CampaignSettings(method="ftr", known_model=model)
    right, bent = (run_campaign([one], plain).values for one in (sound, shown))
    found = run_campaign([shown], revised).values
    for name in ("CN_alpha", "Cm_alpha"):
        assert found[name].mean == pytest.approx(right[name].mean, rel=1e-6)
        assert abs(bent[name].mean - right[name].mean) > 0.12 * abs(right[name].mean)


def test_transform_regression_leaves_known_effects_out() -> None:
    effect = {"Cm_alpha2": -2.0}
    model = BASE.with_effect("aero.Cm.alpha2", effect)
    flown = fly(3, "lon", model=model).maneuver
    plain = CampaignSettings(method="ftr")
    revised = CampaignSettings(method="ftr", known_model=model)
    bent, found = (run_campaign([flown], one).values["Cm_alpha"] for one in (plain, revised))
    true = BASE.derivative("Cm_alpha")
    assert abs(bent.mean - true) > 0.2 * abs(true)
    assert found.mean == pytest.approx(true, rel=0.1)
    assert abs(found.mean - true) < 4.0 * found.std


def test_output_error_is_driven_by_the_true_motion() -> None:
    """The vane that drives the lateral equations reads 40 % too much: known, it does no harm."""
    virtual = fly(3, "lat", model=BASE)
    shown = recorded(virtual.maneuver, "sensor.alpha.scale", ("alpha",), 1.4)
    model = BASE.with_effect("sensor.alpha.scale", {"scale": 1.4})
    right = estimate([virtual.maneuver], MLSettings(axis="lat", model=BASE))
    found = estimate([shown], MLSettings(axis="lat", model=model))
    for name in ("Cl_beta", "Cn_beta", "Cl_p", "Cn_r"):
        assert found.value(name) == pytest.approx(right.value(name), rel=1e-6), name
