"""Maximum likelihood with instruments that are late, swapped or misplaced: found with the rest."""

from dataclasses import replace

import pytest

from gsapp.dynamics.model import load_model
from gsapp.dynamics.terms import create_term
from gsapp.identification.maximum_likelihood import MLSettings, estimate
from tests.identification.virtual_maneuvers import edited, fly

BASE = load_model("b777")
FAR = 5.0


def off(found, truth):
    return max(
        abs(found.value(name) - truth[name]) / found.derivatives[name].std
        for name in found.free
        if name in truth
    )


def effect_value(found, name):
    return found.value(name), found.derivatives[name].std


def through(maneuver, effect, channels, *parameters):
    term = create_term(effect, maneuver.aircraft)
    changes = {name: lambda x: term.respond(x, maneuver.dt, parameters).values for name in channels}
    return edited(maneuver, **changes)


@pytest.fixture(scope="module")
def lon():
    return fly(1, "lon", model=BASE)


@pytest.fixture(scope="module")
def lat():
    return fly(2, "lat", model=BASE)


def settings(axis, effect, start, parameter):
    return MLSettings(
        axis=axis, model=BASE.with_effect(effect, start), free_effects=(f"{effect}.{parameter}",)
    )


def test_a_late_box_of_surfaces_is_found_with_one_delay(lat) -> None:
    effect = "sensor.surfaces.delay"
    late = through(lat.maneuver, effect, ("da", "dr"), 0.03)
    found = estimate([late], settings("lat", effect, {"delay": 0.005}, "delay"))
    value, std = effect_value(found, f"{effect}.delay")
    assert value == pytest.approx(0.03, abs=max(FAR * std, 1e-3))
    assert std < 0.004
    assert off(found, lat.truth) < FAR
    blind = estimate([late], MLSettings(axis="lat", model=BASE))
    assert off(blind, lat.truth) > 2.0 * FAR


@pytest.mark.parametrize(
    ("kind", "parameter", "true", "start"),
    [("delay", "delay", 0.03, 0.005), ("lag", "tau", 0.05, 0.01)],
)
def test_a_late_elevator_potentiometer_is_found(lon, kind, parameter, true, start) -> None:
    effect = f"sensor.de.{kind}"
    late = through(lon.maneuver, effect, ("de",), true)
    found = estimate([late], settings("lon", effect, {parameter: start}, parameter))
    value, std = effect_value(found, f"{effect}.{parameter}")
    assert value == pytest.approx(true, abs=max(FAR * std, 2e-3))
    assert std < 0.01


def test_a_known_scale_of_a_surface_is_undone(lon) -> None:
    effect = "sensor.de.scale"
    shown = through(lon.maneuver, effect, ("de",), 1.25)
    held = MLSettings(axis="lon", model=BASE.with_effect(effect, {"scale": 1.25}))
    found = estimate([shown], held)
    plain = estimate([lon.maneuver], MLSettings(axis="lon", model=BASE))
    assert found.value("Cm_de") == pytest.approx(plain.value("Cm_de"), rel=1e-6)


def test_late_air_data_is_found_with_one_delay() -> None:
    virtual = fly(8, "both", model=BASE)
    effect = "sensor.airdata.delay"
    late = through(virtual.maneuver, effect, ("alpha", "beta", "V"), 0.03)
    found = estimate([late], settings("both", effect, {"delay": 0.01}, "delay"))
    value, std = effect_value(found, f"{effect}.delay")
    assert value == pytest.approx(0.03, abs=max(FAR * std, 2e-3))
    assert std < 0.005


@pytest.mark.parametrize(
    ("instrument", "axis", "kind"),
    [
        ("accelerometer", "x", "lon"),
        ("accelerometer", "z", "lat"),
        ("alpha_vane", "x", "lon"),
        ("beta_vane", "x", "lat"),
    ],
)
def test_a_misplaced_instrument_is_found(lon, lat, instrument, axis, kind) -> None:
    virtual = {"lon": lon, "lat": lat}[kind]
    sensors = virtual.maneuver.aircraft.sensors
    old = getattr(sensors, instrument)
    wrong = tuple(p - 0.5 * (name == axis) for p, name in zip(old.position, "xyz", strict=True))
    plane = virtual.maneuver.aircraft.model_copy(
        update={
            "sensors": sensors.model_copy(
                update={instrument: old.model_copy(update={"position": wrong})}
            )
        }
    )
    maneuver = replace(virtual.maneuver, aircraft=plane)
    effect = f"sensor.{instrument}.{axis}"
    found = estimate([maneuver], settings(kind, effect, {axis: 0.0}, axis))
    value, std = effect_value(found, f"{effect}.{axis}")
    assert value == pytest.approx(0.5, abs=max(FAR * std, 0.02))
    assert std < 0.15


def test_swapped_gyros_in_the_model_give_the_derivatives_back(lat) -> None:
    names = lat.maneuver.block.channels
    p, r = (lat.maneuver.block.values[:, names.index(name)].copy() for name in "pr")
    swapped = edited(lat.maneuver, p=lambda _: r, r=lambda _: p)
    model = BASE.with_effect("sensor.p_r.swapped")
    found = estimate([swapped], MLSettings(axis="lat", model=model))
    assert found.converged
    assert off(found, lat.truth) < FAR
