"""What the crew does not know of its instruments changes the record and nothing else."""

from dataclasses import replace

import numpy as np
import pytest

from gsapp.aircraft import load_aircraft
from gsapp.dynamics.model import load_model
from gsapp.dynamics.terms import effect_ids
from gsapp.foundation import FlightError
from gsapp.virtual import airframe
from gsapp.virtual.airframe import INSTRUMENT_INPUT_CHANNELS, TRUTH_CHANNELS, Airframe
from gsapp.virtual.flight_plan import load_flight_plan
from gsapp.virtual.settings import VIRTUAL
from gsapp.virtual.sticks import StickPositions
from gsapp.virtual.virtual_flight import add_hidden_effects

DT = 0.01
COUNT = 250
SURFACES = ("elevator_left", "elevator_right", "aileron_left", "aileron_right", "rudder")


def ride(*hide: str) -> tuple[np.ndarray, np.ndarray]:
    """Return truth and exposures of a take-off run with the sticks moved, one row a step."""
    aircraft = load_aircraft("b777")
    frame = Airframe(
        load_flight_plan("short"),
        aircraft,
        add_hidden_effects(aircraft, load_model("b777"), hide),
        turbulence=0.0,
        random=np.random.default_rng(5),
        dt=DT,
    )
    truth, exposed = [], []
    for step in range(COUNT):
        time = step * DT
        frame.advance(
            StickPositions(
                throttle=1.0,
                pitch=0.3 * float(np.sin(9.0 * time)),
                roll=0.2 * float(np.sin(7.0 * time)),
                yaw=0.1 * float(np.sin(5.0 * time)),
                flap=0.5,
                engines=True,
                high_rate=True,
            )
        )
        truth.append(frame.truth())
        exposed.append(frame.instrument_inputs())
        frame.onboard_values()
    return np.array(truth), np.array(exposed)


@pytest.fixture(scope="module")
def plain() -> tuple[np.ndarray, np.ndarray]:
    return ride()


def shown(exposed: np.ndarray, name: str) -> np.ndarray:
    return np.asarray(exposed[:, INSTRUMENT_INPUT_CHANNELS.index(name)])


def late(signal: np.ndarray, by: float) -> np.ndarray:
    times = DT * np.arange(signal.size)
    return np.interp(times - by, times, signal)


def changed(one: np.ndarray, other: np.ndarray) -> set[str]:
    return {
        name
        for k, name in enumerate(INSTRUMENT_INPUT_CHANNELS)
        if not np.array_equal(one[:, k], other[:, k])
    }


def test_a_late_potentiometer_leaves_the_surface_alone(plain) -> None:
    truth, exposed = ride("sensor.de.delay:delay=0.02")
    assert np.array_equal(truth, plain[0])
    assert changed(exposed, plain[1]) == {"elevator_left", "elevator_right"}
    # Left and right differ by the rigging, which is not late.
    mean = 0.5 * (shown(exposed, "elevator_left") + shown(exposed, "elevator_right"))
    true = plain[0][:, TRUTH_CHANNELS.index("de")]
    assert np.allclose(mean[5:], late(true, 0.02)[5:], atol=1e-12)


def test_a_box_of_surfaces_is_late_as_a_whole(plain) -> None:
    truth, exposed = ride("sensor.surfaces.delay:delay=0.03")
    assert np.array_equal(truth, plain[0])
    assert changed(exposed, plain[1]) == {*SURFACES, "flap"}
    for name in ("rudder", "flap"):
        assert np.allclose(
            shown(exposed, name)[5:], late(shown(plain[1], name), 0.03)[5:], atol=1e-12
        )


def test_late_air_data_makes_the_pressure_late_once(plain) -> None:
    truth, exposed = ride("sensor.airdata.delay:delay=0.1")
    assert np.array_equal(truth, plain[0])
    assert changed(exposed, plain[1]) == {"alpha", "beta", "dynamic_pressure"}
    pressure = shown(plain[1], "dynamic_pressure")
    assert pressure.max() > 20.0
    found = shown(exposed, "dynamic_pressure")
    # The speed is late, the density from which the pressure follows is not.
    assert np.allclose(found[15:], late(pressure, 0.1)[15:], rtol=1e-6)


def test_swapped_accelerometers(plain) -> None:
    truth, exposed = ride("sensor.ax_an.swapped")
    assert np.array_equal(truth, plain[0])
    assert changed(exposed, plain[1]) == {"ax", "an"}
    assert np.array_equal(shown(exposed, "ax"), shown(plain[1], "an"))
    assert np.array_equal(shown(exposed, "an"), shown(plain[1], "ax"))


def test_a_misplaced_accelerometer(plain) -> None:
    truth, exposed = ride("sensor.accelerometer.x:x=0.5")
    assert np.array_equal(truth, plain[0])
    assert changed(exposed, plain[1]) == {"ax", "ay", "an"}
    q = plain[0][:, TRUTH_CHANNELS.index("q")]
    p, r = plain[0][:, TRUTH_CHANNELS.index("p")], plain[0][:, TRUTH_CHANNELS.index("r")]
    extra = shown(exposed, "an") - shown(plain[1], "an")
    expected = 0.5 * (np.gradient(q, DT) - p * r)
    assert np.corrcoef(extra[5:], expected[5:])[0, 1] > 0.95


def test_a_clipped_gyro(plain) -> None:
    limit = 0.5 * float(np.abs(shown(plain[1], "q")).max())
    truth, exposed = ride(f"sensor.q.clipping:limit={limit!r}")
    assert np.array_equal(truth, plain[0])
    assert np.array_equal(shown(exposed, "q"), np.clip(shown(plain[1], "q"), -limit, limit))


def test_what_comes_early_cannot_be_flown() -> None:
    with pytest.raises(FlightError, match="must not be negative"):
        ride("sensor.airdata.delay:delay=-0.1")


def test_every_effect_can_be_hidden(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(airframe, "VIRTUAL", replace(VIRTUAL, settling_time=0.03))
    aircraft, model, plan = load_aircraft("b777"), load_model("b777"), load_flight_plan("short")
    sticks = StickPositions(throttle=1.0, pitch=0.2, roll=0.1, yaw=0.1, flap=0.5, engines=True)
    for name in effect_ids():
        frame = Airframe(
            plan,
            aircraft,
            add_hidden_effects(aircraft, model, (name,)),
            turbulence=0.0,
            random=np.random.default_rng(1),
            dt=DT,
        )
        for _ in range(5):
            frame.advance(sticks)
            seen = (*frame.instrument_inputs(), *frame.truth(), *frame.onboard_values())
            assert np.isfinite(seen).all(), name
