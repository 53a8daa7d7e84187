"""What a pilot knows of an aircraft after many flights: level flight, and what the sticks do.

Found by asking the equations: trim by a search over angle of attack, elevator and throttle;
steady rates and the rudder of a turn from small changes. So the same pilot flies any aircraft.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy.optimize import fsolve

from gsapp.dynamics.flight_model import FlightModel
from gsapp.dynamics.pilot.control import Feel
from gsapp.foundation import FlightError

_STEP = 1e-3


def learn(model: FlightModel, speed: float, density: float) -> Feel:
    """Return what a pilot knows.

    Parameters
    ----------
    model : FlightModel
        The aircraft, hidden effects included: it is this one that the pilot has flown.
    speed : float
        Airspeed at which it is flown, m/s.
    density : float
        Of the air, kg/m^3.

    Raises
    ------
    FlightError
        If the aircraft cannot fly level at that speed, or does not answer the sticks.
    """
    level = _level(model, speed, density)
    faster = _level(model, 1.1 * speed, density)
    controls = model.aircraft.controls
    pitch_rate = _steady_rate(model, speed, density, level, "de") * controls.de.full_stick_high
    roll_rate = _steady_rate(model, speed, density, level, "da") * controls.da.full_stick_high
    if not (pitch_rate > 0.05 and roll_rate > 0.05):
        raise FlightError(
            "the aircraft does not answer the sticks the right way round "
            f"(full pull {math.degrees(pitch_rate):.0f} deg/s, full right "
            f"{math.degrees(roll_rate):.0f} deg/s); check the signs of Cm_de, Cl_da and of "
            "full_stick in the aircraft file"
        )
    alpha, elevator, throttle = level
    return Feel(
        speed=speed,
        pitch_rate=pitch_rate,
        roll_rate=roll_rate,
        low_rate=(
            controls.de.full_stick_low / controls.de.full_stick_high,
            controls.da.full_stick_low / controls.da.full_stick_high,
            controls.dr.full_stick_low / controls.dr.full_stick_high,
        ),
        pitch=alpha,
        trim=elevator / controls.de.full_stick_high,
        throttle=throttle,
        throttle_slope=(faster[2] - throttle) / (0.1 * speed),
        turn_pull=_turn_pull(model, speed, density, level) / controls.de.full_stick_high,
        turn_yaw=_turn_yaw(model, speed, density, level) / controls.dr.full_stick_high,
        flap_travel=controls.flap.travel[1],
    )


def _rates(
    model: FlightModel,
    speed: float,
    density: float,
    motion: Sequence[float],
    inputs: Sequence[float],
) -> tuple[float, ...]:
    """Return V' alpha' beta' p' q' r' at alpha beta p q r phi and de da dr throttle."""
    alpha, beta, p, q, r, phi = motion
    de, da, dr, throttle = inputs
    state = (speed, alpha, beta, p, q, r, phi, alpha, 0.0)
    given = (de, da, dr, 0.0, throttle, 0.0, density, model.aircraft.mass.mass)
    full = (*state, *model.resting_states(state, given))
    return tuple(float(rate) for rate in model.rates(full, given)[:6])


def _solve(equations: object, start: Sequence[float], why: str) -> np.ndarray:
    found, _, status, _ = fsolve(equations, start, full_output=True)
    if status != 1 or not np.all(np.isfinite(found)):
        raise FlightError(why)
    return np.asarray(found)


def _level(model: FlightModel, speed: float, density: float) -> tuple[float, float, float]:
    """Return alpha, elevator (rad) and throttle in level flight."""

    def balance(x: np.ndarray) -> list[float]:
        rates = _rates(
            model, speed, density, (float(x[0]), 0, 0, 0, 0, 0), (float(x[1]), 0, 0, float(x[2]))
        )
        return [rates[0], rates[1], rates[4]]

    why = (
        f"the aircraft cannot fly level at {speed:.1f} m/s; check mass, wing area and the "
        "derivatives CN_alpha, Cm_alpha, Cm_de"
    )
    alpha, elevator, throttle = _solve(balance, (0.08, 0.0, 0.4), why)
    if not (throttle < 1.0 and abs(alpha) < 0.35):
        raise FlightError(why)
    return float(alpha), float(elevator), max(float(throttle), 0.0)


def _steady_rate(
    model: FlightModel,
    speed: float,
    density: float,
    level: tuple[float, float, float],
    surface: str,
) -> float:
    """Return the rate (rad/s) that a radian of elevator, or aileron, holds after a second."""
    alpha, elevator, throttle = level
    if surface == "da":

        def roll(x: np.ndarray) -> list[float]:
            motion = (alpha, 0, float(x[0]), 0, 0, 0)
            return [_rates(model, speed, density, motion, (elevator, _STEP, 0, throttle))[3]]

        return float(_solve(roll, (0.0,), "the aileron does not roll the aircraft")[0]) / _STEP

    def pull(x: np.ndarray) -> list[float]:
        motion = (float(x[0]), 0, 0, float(x[1]), 0, 0)
        rates = _rates(model, speed, density, motion, (elevator + _STEP, 0, 0, throttle))
        return [rates[1], rates[4]]

    return float(_solve(pull, (alpha, 0.0), "the elevator does not pitch the aircraft")[1]) / _STEP


def _turn(
    model: FlightModel, speed: float, density: float, level: tuple[float, float, float], bank: float
) -> np.ndarray:
    """Return alpha, elevator, aileron, rudder of a level turn without sideslip."""
    alpha, elevator, throttle = level
    turn = 9.80665 * math.tan(bank) / speed

    def balance(x: np.ndarray) -> list[float]:
        a = float(x[0])
        rates = (-turn * math.sin(a), turn * math.sin(bank), turn * math.cos(bank))
        motion = (a, 0.0, *rates, bank)
        controls = (float(x[1]), float(x[2]), float(x[3]), throttle)
        found = _rates(model, speed, density, motion, controls)
        return [found[1], found[3], found[4], found[5]]

    return _solve(balance, (alpha, elevator, 0.0, 0.0), "the aircraft cannot fly a level turn")


def _turn_pull(
    model: FlightModel, speed: float, density: float, level: tuple[float, float, float]
) -> float:
    bank = math.radians(40.0)
    elevator = _turn(model, speed, density, level, bank)[1]
    return float(elevator - level[1]) / (1.0 / math.cos(bank) - 1.0)


def _turn_yaw(
    model: FlightModel, speed: float, density: float, level: tuple[float, float, float]
) -> float:
    bank = math.radians(30.0)
    return float(_turn(model, speed, density, level, bank)[3]) / math.sin(bank)
