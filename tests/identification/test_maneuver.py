"""Cutting maneuvers, completing their motion, bringing late channels to their time."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy import signal
from scipy.integrate import solve_ivp

from gsapp.aircraft import Aircraft, load_aircraft
from gsapp.cli.maneuvers import maneuvers as maneuvers_command
from gsapp.dynamics.equations import attitude_rates
from gsapp.flight import Flight
from gsapp.flight.air_data_histories import add_air_data
from gsapp.flight.info import FlightInfo, Weather
from gsapp.flight.maneuver_settings import ManeuverSettings
from gsapp.flight.read_settings import assumed_aircraft_text
from gsapp.foundation import FlightError
from gsapp.identification.axes import axis_of, free_derivatives
from gsapp.identification.maneuver import (
    cut_maneuver,
    mass_over_flight,
    open_flights_with_maneuvers,
)
from gsapp.identification.motion import integrate_attitude, measured_motion
from gsapp.identification.record_preparation import (
    advance_flags,
    advance_samples,
    channel_delays,
    compensate_delays,
)
from gsapp.quantities import Block
from gsapp.quantities.constants import GRAVITY
from gsapp.virtual.virtual_flight import VirtualFlight

B777 = load_aircraft("b777")


@pytest.fixture(scope="module")
def flown(flown_short: Callable[[int], VirtualFlight]) -> VirtualFlight:
    return flown_short(6)


def flight_of(block: Block, info: FlightInfo | None = None) -> Flight:
    return Flight(name="virtual", path=Path("virtual"), block=block, sources={}, info=info)


def test_free_sets_follow_the_tables() -> None:
    assert len(free_derivatives("lon", ["de"])) == 12
    aileron, rudder = free_derivatives("lat", ["da"]), free_derivatives("lat", ["dr"])
    assert len(aileron) == len(rudder) == 15
    assert not any(name.endswith("_dr") for name in aileron)
    assert not any(name.endswith("_da") for name in rudder)
    assert len(free_derivatives("lat", ["da", "dr"])) == 18
    assert len(free_derivatives("both", ["de", "da", "dr"])) == 30
    assert axis_of(["de"]) == "lon"
    assert axis_of(["da", "dr"]) == "lat"
    assert axis_of(["de", "dr"]) == "both"


def test_measured_motion_follows_the_truth(flown: VirtualFlight) -> None:
    flight = flight_of(flown.measured)
    for index, one in enumerate(flown.maneuvers):
        maneuver = cut_maneuver(
            flight, B777, one.t_start - 1.0, one.t_end, id=str(index), inputs=one.inputs
        )
        motion = measured_motion(maneuver)
        truth = flown.truth.between(maneuver.t_start - 1e-6, maneuver.t_end + 1e-6)
        for name, least in (("V", 0.15), ("alpha", 0.003), ("beta", 0.003)):
            assert np.sqrt(np.mean((motion.state(name) - truth[name]) ** 2)) < least
        assert np.max(np.abs(motion.input("throttle") - truth["throttle"])) < 0.06
        assert {"V", "alpha", "q", "de", "throttle"} <= motion.measured
        assert "theta" not in motion.measured
        assert any("phi and theta" in remark for remark in motion.remarks)
        # No instrument shows attitude: what gravity does at the start, and the rates from there.
        for name in ("phi", "theta"):
            assert np.max(np.abs(motion.state(name) - truth[name])) < 0.03


def test_late_channels_come_to_their_time(flown: VirtualFlight) -> None:
    one = flown.maneuvers[0]
    flight = flight_of(flown.measured)
    errors = []
    for aircraft in (B777, without_filters(B777)):
        maneuver = cut_maneuver(flight, aircraft, one.t_start, one.t_end, id="1", inputs=one.inputs)
        truth = flown.truth.between(maneuver.t_start - 1e-6, maneuver.t_end + 1e-6)["de"]
        errors.append(float(np.std(maneuver.samples("de") - truth)))
    assert errors[0] < 0.6 * errors[1]


def without_filters(aircraft: Aircraft) -> Aircraft:
    sensors = aircraft.sensors
    plain = {
        name: getattr(sensors, name).model_copy(update={"low_pass": None})
        for name in type(sensors).model_fields
    }
    return aircraft.model_copy(update={"sensors": sensors.model_copy(update=plain)})


@pytest.mark.parametrize("steps", [0.0, 0.45, 1.0, 2.3])
def test_advanced_undoes_a_delay(steps: float) -> None:
    times = np.arange(200) / 100.0
    late = np.sin(4.0 * np.pi * (times - steps / 100.0))
    found = advance_samples(late, steps)
    known = np.isfinite(found)
    assert np.all(np.flatnonzero(~known) >= 200 - int(np.ceil(steps)))
    inner = slice(1, 190)
    assert np.max(np.abs(found[inner] - np.sin(4.0 * np.pi * times)[inner])) < 1e-3


def test_advanced_spreads_no_missing_sample_further_than_its_neighbors() -> None:
    samples = np.sin(np.arange(50) / 5.0)
    samples[20] = np.nan
    assert np.flatnonzero(np.isnan(advance_samples(samples, 0.4)))[:2].tolist() == [19, 20]
    flags = np.zeros(50, dtype=bool)
    flags[20] = True
    assert np.flatnonzero(advance_flags(flags, 0.4))[:2].tolist() == [19, 20]


def test_lateness_of_a_filter_is_its_delay_at_low_frequency() -> None:
    """sqrt(2)/(2 pi f) against SciPy's group delay of the Butterworth filter."""
    b, a = signal.butter(2, 2.0 * np.pi * 50.0, analog=True)
    frequency = np.array([0.9, 1.1]) * 2.0 * np.pi
    phase = np.unwrap(np.angle(signal.freqs(b, a, frequency)[1]))
    assert channel_delays(B777)["alpha"] == pytest.approx(
        -np.diff(phase)[0] / np.diff(frequency)[0], rel=1e-3
    )
    assert "q" not in channel_delays(B777)
    assert (
        compensate_delays(Block(channels=("q",), times=[0.0, 0.01], values=[[1.0], [2.0]]), B777)[
            "q"
        ][1]
        == 2.0
    )


def test_mass_falls_with_fuel() -> None:
    times = np.arange(0.0, 420.0, 0.1)
    throttle = np.where(times < 200.0, 1.0, 0.2)
    flight = flight_of(Block(channels=("throttle",), times=times, values=throttle[:, None]))
    found = mass_over_flight(flight, B777)
    assert found[0] == B777.mass.mass
    full, idle = B777.mass.fuel_flow_full, B777.mass.fuel_flow_idle
    expected = 200.0 * full + 220.0 * (idle + 0.2 * (full - idle))
    assert found[0] - found[-1] == pytest.approx(expected, rel=1e-2)
    weighed = replace(flight, info=FlightInfo(takeoff_weight="47.1 lb", landing_weight="45.2 lb"))
    found = mass_over_flight(weighed, B777)
    assert found[0] == pytest.approx(47.1 * 0.45359237, rel=1e-9)
    assert found[-1] == pytest.approx(45.2 * 0.45359237, rel=1e-9)
    # Full throttle burns more in a second than 0.2.
    assert found[0] - found[1000] > 2.0 * (found[3000] - found[4000])
    assert found[-1] * GRAVITY > 0.0


def test_missing_airspeed_gets_a_stand_in_or_a_clear_sentence(flown: VirtualFlight) -> None:
    one = flown.maneuvers[1]
    lost = ("alpha", "beta", "static_pressure", "dynamic_pressure", "temperature")
    kept = [name for name in flown.measured.channels if name not in lost]
    flight = flight_of(flown.measured.select(kept))
    maneuver = cut_maneuver(flight, B777, one.t_start, one.t_end, id="1", inputs=one.inputs)
    motion = measured_motion(maneuver)
    assert np.ptp(motion.state("V")) == 0.0
    assert motion.state("V")[0] == pytest.approx(1.64 * B777.limits.stall_speed)
    assert measured_motion(maneuver, stand_ins={"V": 31.0}).state("V")[0] == 31.0
    unknown = B777.model_copy(
        update={"limits": B777.limits.model_copy(update={"stall_speed": 0.0})}
    )
    with pytest.raises(FlightError, match="no airspeed"):
        measured_motion(replace(maneuver, aircraft=unknown))
    with pytest.raises(FlightError, match="holds no samples"):
        cut_maneuver(flight, B777, 9000.0, 9010.0, id="2", inputs=("de",))


def test_turned_attitude_follows_the_rates_exactly() -> None:
    """A coning motion against an integration of the equations of attitude (4.1.8), (4.1.9)."""
    times = np.arange(0.0, 4.0, 0.01)
    rates = (0.8 * np.sin(2.0 * times), 0.5 * np.cos(1.3 * times), 0.3 * np.sin(0.7 * times))

    def slopes(t: float, y: np.ndarray) -> tuple[float, float]:
        p, q, r = 0.8 * np.sin(2.0 * t), 0.5 * np.cos(1.3 * t), 0.3 * np.sin(0.7 * t)
        found = attitude_rates(p, q, r, y[0], y[1])
        return float(found[0]), float(found[1])

    expected = solve_ivp(slopes, (0.0, 3.99), (0.2, -0.1), t_eval=times, rtol=1e-10, atol=1e-12)
    phi, theta = integrate_attitude(times, rates, 0.2, -0.1)
    assert np.max(np.abs(phi - expected.y[0])) < 5e-5
    assert np.max(np.abs(theta - expected.y[1])) < 5e-5


def test_air_data_follow_from_either_side(flown: VirtualFlight) -> None:
    block = flown.measured.between(41.0, 44.0)
    truth = flown.truth.between(41.0, 44.0)
    whole = add_air_data(block)
    assert np.sqrt(np.mean((whole["V"] - truth["V"]) ** 2)) < 0.15
    assert np.array_equal(whole["qbar"], block["dynamic_pressure"])
    only_speed = Block(
        channels=("V", "static_pressure"), times=whole.times,
        values=np.column_stack([whole["V"], block["static_pressure"]]),
    )  # fmt: skip
    warm = add_air_data(only_speed, Weather(temperature="30 degC"))
    expected = block["static_pressure"] / (287.05 * 303.15)
    assert np.allclose(warm["density"], expected, rtol=1e-3)
    assert np.allclose(warm["qbar"], 0.5 * expected * whole["V"] ** 2, rtol=1e-3)
    assert add_air_data(block.select(("de",))).channels == ("de",)


CSV = "time [s],q [deg/s],de [deg]\n" + "".join(
    f"{0.01 * k:.2f},{0.1 * (k % 7):.1f},{2.0 if 200 < k < 240 else 0.0}\n" for k in range(600)
)


@pytest.fixture
def table(tmp_path: Path) -> Path:
    path = tmp_path / "glider.csv"
    path.write_text(CSV, encoding="utf-8")
    return path


def words_of(flight: Path, aircraft: str = "") -> list[str]:
    (flown,) = open_flights_with_maneuvers(
        [flight], ManeuverSettings(aircraft=aircraft, maneuver_windows=("1:5",))
    )
    return [one for one in flown.remarks if "no aircraft file" in one]


def test_what_is_taken_for_an_unnamed_aircraft_is_said(table: Path) -> None:
    (said,) = words_of(table)
    assert "'glider'" in said
    assert "B777" in said
    assert "--aircraft FILE" in said
    assert words_of(table, "b777") == []


def test_a_flight_card_that_names_the_shipped_aircraft_is_enough() -> None:
    assert assumed_aircraft_text("flight", FlightInfo(aircraft="B777")) == ""
    assert assumed_aircraft_text("flight", FlightInfo()) != ""


def test_maneuvers_are_found_with_the_same_words(
    table: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    maneuvers_command(flights=[table])
    assert "no aircraft file" in capsys.readouterr().out
    maneuvers_command(flights=[table], aircraft="b777")
    assert "no aircraft file" not in capsys.readouterr().out
