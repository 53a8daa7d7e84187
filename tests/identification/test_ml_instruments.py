"""Maximum likelihood where instruments are late, swapped, misplaced, stuck or missing."""

from dataclasses import replace

import numpy as np
import pytest

from gsapp.dynamics.model import load_model
from gsapp.dynamics.terms import create_term
from gsapp.foundation import FlightError
from gsapp.identification.maximum_likelihood import MLSettings, estimate
from gsapp.quantities import Block
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


def test_no_maneuver():
    with pytest.raises(FlightError, match="no maneuver"):
        estimate([], MLSettings(axis="lon"))


@pytest.mark.parametrize(
    ("rows", "axis", "words"),
    [
        (slice(10), "lon", r"10 samples.*widen"),
        (slice(0, 275, 5), "both", r"55 samples.* unknowns"),
    ],
)
def test_too_few_samples(lon, rows, axis, words):
    block = lon.maneuver.block
    short = Block(channels=block.channels, times=block.times[rows], values=block.values[rows])
    with pytest.raises(FlightError, match=words):
        estimate([replace(lon.maneuver, block=short)], MLSettings(axis=axis))


def test_nothing_measured(lon):
    dead = edited(lon.maneuver, alpha=np.nan, q=np.nan, an=np.nan, ax=np.nan)
    with pytest.raises(FlightError, match="alpha"):
        estimate([dead], MLSettings(axis="lon"))


@pytest.mark.parametrize("mass", [0.0, -3.0, float("nan")])
def test_no_mass(lon, mass):
    with pytest.raises(FlightError, match="mass of"):
        estimate([replace(lon.maneuver, mass=mass)], MLSettings(axis="lon"))


def test_input_missing_wherever_it_matters(lon):
    def holes(samples):
        samples[np.arange(samples.size) % 40 < 20] = np.nan
        return samples

    with pytest.raises(FlightError, match="no stretch"):
        estimate([edited(lon.maneuver, de=holes)], MLSettings(axis="lon"))


def test_a_stuck_response_is_left_out_and_named(lon):
    found = estimate([edited(lon.maneuver, ax=0.3)], MLSettings(axis="lon"))
    assert "ax" not in found.fit
    assert any("ax stays at 0.3" in warning for warning in found.warnings)
    assert found.value("Cm_alpha") == pytest.approx(BASE.derivative("Cm_alpha"), rel=0.1)


NOISE = 0.05 * np.pi / 180.0 * np.random.default_rng(3).standard_normal(1001)


@pytest.mark.parametrize(
    ("rudder", "words"),
    [(0.01, "dr does not"), (0.02 + NOISE, ""), (np.nan, "not measured")],
    ids=["stuck", "noise", "lost"],
)
def test_a_surface_that_was_not_seen_to_move_has_no_derivative(lat, rudder, words):
    found = estimate([edited(lat.maneuver, dr=rudder)], MLSettings(axis="lat"))
    for name in ("CY_dr", "Cl_dr", "Cn_dr"):
        one = found.derivatives[name]
        assert (one.status, one.value) == ("unknown", None)
        assert words in one.why


def test_surfaces_that_move_as_one_are_not_told_apart(lat):
    linked = edited(lat.maneuver, da=2.0 * lat.maneuver.block["dr"])
    found = estimate([linked], MLSettings(axis="lat"))
    for name, other in (("Cn_da", "Cn_dr"), ("Cl_dr", "Cl_da")):
        assert found.derivatives[name].value is None
        assert found.derivatives[name].status == "not-identifiable"
        assert other in found.derivatives[name].confounded_with


def test_nothing_moves():
    still = fly(5, "lon", model=BASE, noise=1.0)
    quiet = 0.002 * np.random.default_rng(1).standard_normal((4, len(still.maneuver.block)))
    flat = edited(
        still.maneuver,
        de=-0.01,
        alpha=0.06 + quiet[0],
        q=quiet[1],
        an=9.8 + 10.0 * quiet[2],
        ax=0.5 + 10.0 * quiet[3],
        theta=0.06,
        V=30.0,
    )
    found = estimate([flat], MLSettings(axis="lon"))
    slopes = [name for name in found.free if not name.endswith("_0")]
    assert slopes == []


@pytest.mark.parametrize(
    ("channel", "words"), [("de", "elevator"), ("q", "pitch rate"), ("alpha", "angle of attack")]
)
def test_a_reversed_channel_is_named(lon, channel, words):
    found = estimate([edited(lon.maneuver, **{channel: lambda x: -x})], MLSettings(axis="lon"))
    signs = [warning for warning in found.warnings if "sign" in warning]
    assert signs
    assert words in signs[0]


def test_an_absurd_start_does_not_end_the_fit(lon):
    """A start that diverges is replaced by equation error's."""
    absurd = {"Cm_alpha": 3.0, "Cm_q": 30.0}
    found = estimate([lon.maneuver], MLSettings(axis="lon", start=absurd))
    assert found.converged
    assert found.value("Cm_alpha") == pytest.approx(BASE.derivative("Cm_alpha"), rel=0.05)


def test_a_model_that_diverges_says_so(lon):
    held = {"Cm_alpha": 30.0, "Cm_q": 60.0}
    with pytest.raises(FlightError, match="maneuver 1"):
        estimate([lon.maneuver], MLSettings(axis="lon", held=held))
