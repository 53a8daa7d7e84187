"""Model files, the atmosphere and engines: read strictly, as tables and the design have them."""

from pathlib import Path

import numpy as np
import pytest
from scipy import signal

from gsapp.aircraft import Aircraft
from gsapp.dynamics.atmosphere import (
    Atmosphere,
    DrydenTurbulence,
    Wind,
    pressure_altitude,
    pressure_at,
)
from gsapp.dynamics.flight_model import FlightModel
from gsapp.dynamics.model import Effect, Model, load_model, save_model, shipped_models
from gsapp.dynamics.propulsion import Engines, fan_speed, throttle_for, thrust
from gsapp.dynamics.terms import POSITIONED_INSTRUMENTS, create_term, effect_ids
from gsapp.foundation import FileProblemsError, UnknownNameError

GOOD = """
name = "revised"
parent = "b777"
[derivatives]
Cm_alpha = -0.34
[[effects]]
id = "aero.Cm.alpha2"
[effects.parameters]
Cm_alpha2 = -1.5
[[effects]]
id = "control.elevator.backlash"
"""


def write(folder: Path, text: str) -> Path:
    path = folder / "model.toml"
    path.write_text(text)
    return path


def test_a_file_as_in_the_design(tmp_path: Path, aircraft: Aircraft) -> None:
    model = load_model(write(tmp_path, GOOD))
    assert (model.name, model.parent) == ("revised", "b777")
    assert model.derivative("Cm_alpha") == -0.34
    assert model.derivative("Cm_q") == 0.0
    assert model.effects[0].values(aircraft) == (-1.5,)
    assert model.effects[1].values(aircraft) == (0.02,)
    built = FlightModel(aircraft, model)
    assert built.defaults[built.parameter_names.index("aero.Cm.alpha2.Cm_alpha2")] == -1.5
    assert [term.id for term, _ in built.control_terms["elevator"]] == ["control.elevator.backlash"]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ('nam = "x"', "did you mean 'name'"),
        ("[derivatives]\nCm_alfa = 1.0", "did you mean 'Cm_alpha'"),
        ("[derivatives]\nCm_alpha = nan", "derivatives.Cm_alpha"),
        ('[derivatives]\nCm_alpha = "steep"', "derivatives.Cm_alpha"),
        ('[[effects]]\nid = "aero.Cm.alfa2"', "did you mean 'aero.Cm.alpha2'"),
        (
            '[[effects]]\nid = "aero.Cm.alpha2"\n[effects.parameters]\nCm_alfa2 = 1',
            "effects[0].parameters.Cm_alfa2",
        ),
        (
            '[[effects]]\nid = "aero.Cm.alpha2"\n[effects.parameters]\nCm_alpha2 = inf',
            "effects[0].parameters.Cm_alpha2",
        ),
        ('[[effects]]\nid = "aero.Cm.alpha2"\n' * 2, "appears twice"),
        ("[derivatives", "not valid TOML"),
    ],
)
def test_mistakes_are_named(tmp_path: Path, text: str, says: str) -> None:
    with pytest.raises(FileProblemsError) as caught:
        load_model(write(tmp_path, text))
    assert says in str(caught.value)


def test_an_unknown_model_names_those_shipped() -> None:
    with pytest.raises(UnknownNameError, match="b777"):
        load_model("b77")


def test_written_and_read_again(tmp_path: Path) -> None:
    model = load_model(write(tmp_path, GOOD))
    again = load_model(save_model(model, tmp_path / "again.toml"))
    assert again == model


def test_revising_names_the_parent(model: Model) -> None:
    revised = model.with_effect("aero.Cm.beta2", {"Cm_beta2": -0.4}, name="b777-r1")
    assert (revised.name, revised.parent) == ("b777-r1", "b777")
    assert revised.derivatives == model.derivatives
    changed = revised.with_derivatives({"Cm_alpha": -0.4})
    assert changed.derivative("Cm_alpha") == -0.4
    assert model.derivative("Cm_alpha") == -0.339
    twice = changed.with_effect("aero.Cm.beta2", {"Cm_beta2": -0.2})
    assert [effect.parameters for effect in twice.effects] == [{"Cm_beta2": -0.2}]
    assert twice.without_effect("aero.Cm.beta2").effects == ()


def test_the_shipped_model_is_that_of_the_notes(model: Model) -> None:
    assert "b777" in shipped_models()
    expected = {
        "CN_de": 0.379, "Cm_alpha": -0.339, "Cm_q": -23.0, "Cm_de": -1.104, "Cl_beta": -0.324,
        "Cl_p": -1.056, "Cl_r": 0.474, "Cl_da": 0.395, "Cl_dr": 0.0127, "Cn_beta": 0.121,
        "Cn_p": -0.121, "Cn_r": -0.350, "Cn_da": 0.0073, "Cn_dr": -0.0661,
        "CY_beta": -0.6, "CY_r": 0.3, "CY_dr": 0.15, "CN_q": 5.0,
    }  # fmt: skip
    assert {name: model.derivative(name) for name in expected} == expected


def test_a_model_with_every_effect_comes_back_from_its_file(
    tmp_path: Path, aircraft: Aircraft
) -> None:
    effects = tuple(
        Effect(id=name, parameters=create_term(name, aircraft).defaults) for name in effect_ids()
    )
    model = Model(name="all", effects=effects)
    path = save_model(model, tmp_path / "all.toml")
    back = load_model(path)
    assert back == model
    built, again = FlightModel(aircraft, model), FlightModel(aircraft, back)
    assert built.defaults == again.defaults
    assert built.swapped_channels == again.swapped_channels
    assert set(built.displaced_instruments) == set(POSITIONED_INSTRUMENTS)
    # Every signal term stands on one path, that of a box on those of all its channels.
    paths = {
        term.id
        for group in (*built.control_terms.values(), *built.sensor_terms.values())
        for term, _ in group
    }
    inside = {term.id for term, _ in built.terms}
    swapped = {name for name in effect_ids() if name.endswith(".swapped")}
    assert paths | inside | swapped >= set(effect_ids())


@pytest.mark.parametrize(
    ("height", "temperature", "pressure", "density"),
    [
        (0.0, 288.15, 101325.0, 1.2250),
        (1000.0, 281.65, 89874.6, 1.1116),
        (5000.0, 255.65, 54019.9, 0.7361),
    ],
)
def test_standard_day(height: float, temperature: float, pressure: float, density: float) -> None:
    """The published table of the standard atmosphere."""
    air = Atmosphere().at(height)
    assert air.temperature == pytest.approx(temperature)
    assert air.pressure == pytest.approx(pressure, rel=2e-5)
    assert air.density == pytest.approx(density, rel=1e-4)


def test_the_day_at_the_field_counts() -> None:
    day = Atmosphere(ground_altitude=300.0, ground_temperature=308.15, ground_pressure=97000.0)
    air = day.at(300.0)
    assert air.temperature == pytest.approx(308.15)
    assert air.pressure == pytest.approx(97000.0)
    assert air.density == pytest.approx(97000.0 / (287.05287 * 308.15))
    # Hydrostatic above it.
    slope = (day.pressure(410.0) - day.pressure(390.0)) / 20.0
    assert slope == pytest.approx(-9.80665 * day.density(400.0), rel=1e-6)


def test_numbers_and_arrays_agree() -> None:
    heights = np.array([0.0, 120.0, 900.0])
    together = Atmosphere(ground_altitude=100.0).at(heights)
    for k, height in enumerate(heights.tolist()):
        single = Atmosphere(ground_altitude=100.0).at(height)
        assert isinstance(single.density, float)
        assert np.allclose([x[k] for x in together], single, rtol=1e-14)


def test_pressure_altitude_is_the_inverse() -> None:
    heights = np.linspace(-300.0, 8000.0, 20)
    assert np.allclose(pressure_altitude(pressure_at(heights)), heights, atol=1e-8)


def test_wind_grows_with_height() -> None:
    wind = Wind(north=-5.0, east=1.0, shear=0.14)
    assert wind.at(10.0) == pytest.approx((-5.0, 1.0, 0.0))
    assert wind.at(100.0)[0] == pytest.approx(-5.0 * 10**0.14)
    assert Wind(north=-5.0).at(3.0) == (-5.0, 0.0, 0.0)


@pytest.mark.parametrize(("dt", "count"), [(0.01, 60000), (0.5, 60000)])
def test_turbulence_keeps_its_strength_at_every_step(dt: float, count: int) -> None:
    gusts = DrydenTurbulence((1.0, 0.8, 0.5), scale=(10.0, 10.0, 10.0), seed=4).series(
        count, dt, 30.0
    )
    # Samples closer than the time constant L/V are not independent.
    independent = count * min(1.0, dt / (2.0 * 10.0 / 30.0))
    tolerance = 4.0 / np.sqrt(2.0 * independent)
    assert np.allclose(gusts.std(axis=0), (1.0, 0.8, 0.5), rtol=tolerance)


def test_turbulence_has_the_spectrum_of_dryden() -> None:
    V, L, sigma, dt = 30.0, 30.0, 1.0, 0.05
    gusts = DrydenTurbulence(sigma, scale=(L, L, L), seed=1).series(60000, dt, V)
    f, power = signal.welch(gusts, fs=1.0 / dt, nperseg=2048, axis=0)
    w = 2.0 * np.pi * f
    tau = L / V
    longitudinal = 4.0 * sigma**2 * tau / (1.0 + (tau * w) ** 2)
    lateral = 2.0 * sigma**2 * tau * (1.0 + 3.0 * (tau * w) ** 2) / (1.0 + (tau * w) ** 2) ** 2
    band = (f > 0.05) & (f < 2.0)
    for column, expected in ((0, longitudinal), (1, lateral), (2, lateral)):
        ratio = power[band, column] / expected[band]
        assert abs(ratio.mean() - 1.0) < 0.06


def test_rotational_gusts_have_the_spectra_of_mil_f_8785c() -> None:
    """Roll by its own formula, pitch and yaw as filtered slopes of w and v."""
    V, L, b, dt = 30.0, 30.0, 2.7, 0.02
    air = DrydenTurbulence(1.0, scale=(L, L, L), span=b, seed=1)
    rows = np.array([(*air.advance(dt, V), *air.rotation) for _ in range(60000)])
    f, power = signal.welch(rows, fs=1.0 / dt, nperseg=2048, axis=0)
    w = 2.0 * np.pi * f
    half = 1.0 + (4.0 * b * w / (np.pi * V)) ** 2
    roll = 2.0 * np.pi * 0.8 * (np.pi * L / (4.0 * b)) ** (1.0 / 3.0) / (L * V) / half
    pitch = (w / V) ** 2 / half * power[:, 2]
    yaw = (w / V) ** 2 / (1.0 + (3.0 * b * w / (np.pi * V)) ** 2) * power[:, 1]
    band = (f > 0.1) & (f < 3.0)
    for column, expected in ((3, roll), (4, pitch), (5, yaw)):
        assert abs((power[band, column] / expected[band]).mean() - 1.0) < 0.06
    plain = DrydenTurbulence(1.0, scale=(L, L, L), seed=1).series(50, dt, V)
    assert np.array_equal(rows[:50, :3], plain), "the gusts along the axes stay"


def test_turbulence_repeats_with_its_seed() -> None:
    one, two, other = (DrydenTurbulence(1.0, seed=s).series(50, 0.01, 30.0) for s in (7, 7, 8))
    assert np.array_equal(one, two)
    assert not np.array_equal(one, other)


FT = 0.3048
LBF = 4.4482216152605
RPM = 2.0 * np.pi / 60.0


def test_thrust_of_the_design(aircraft: Aircraft) -> None:
    assert thrust(aircraft, 1.0, 1.225, 0.0) == pytest.approx(24.0 * LBF)
    assert thrust(aircraft, 0.5, 1.1, 100 * FT) == pytest.approx(
        24.0 * LBF * 0.5 * (1.1 / 1.225) * (1.0 - 100.0 / 250.0)
    )


def test_throttle_from_a_measured_thrust(aircraft: Aircraft) -> None:
    throttle = np.array([0.1, 0.6, 1.0])
    force = thrust(aircraft, throttle, 1.1, 30.0)
    assert np.allclose(throttle_for(aircraft, force, 1.1, 30.0), throttle)


def test_fan_speed_between_idle_and_full(aircraft: Aircraft) -> None:
    assert fan_speed(aircraft, 0.0) / RPM == pytest.approx(7000.0)
    assert fan_speed(aircraft, 1.0) / RPM == pytest.approx(19000.0)
    speeds = fan_speed(aircraft, np.linspace(0.0, 1.0, 11))
    assert np.all(np.diff(speeds) > 0.0)


def test_engines_follow_the_lever_with_their_lag(aircraft: Aircraft) -> None:
    engines = Engines(aircraft, 0.01)
    steps = round(aircraft.propulsion.lag / 0.01)
    for _ in range(steps):
        state = engines.step(1.0, 1.0)
    assert state.throttle == pytest.approx(1.0 - np.exp(-1.0), abs=1e-9)
    assert state.difference == pytest.approx(0.0)


def test_engines_may_differ(aircraft: Aircraft) -> None:
    engines = Engines(aircraft, 0.01)
    for _ in range(500):
        state = engines.step(0.8, 0.4)
    assert (state.throttle, state.difference) == pytest.approx((0.6, 0.2), abs=1e-4)
    assert state.rpm_left > state.rpm_right


def test_stopped_engines_run_down_and_burn_nothing(aircraft: Aircraft) -> None:
    engines = Engines(aircraft, 0.01, throttle=0.5)
    assert engines.state.fuel_flow > aircraft.mass.fuel_flow_idle
    for _ in range(1000):
        state = engines.step(0.5, 0.5, running=False)
    assert state.fuel_flow == 0.0
    assert state.rpm_left < 10.0 * RPM
    assert state.throttle < 1e-6
