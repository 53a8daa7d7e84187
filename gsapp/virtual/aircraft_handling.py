"""What a pilot knows of an aircraft after many flights: level flight, and what the sticks do.

Found by asking the equations, so that the same pilot flies any aircraft.
"""

from __future__ import annotations

import math

import numpy as np

from gsapp.dynamics.flight_model import FlightModel
from gsapp.dynamics.linearization import linearize
from gsapp.dynamics.trim import Trim, trim
from gsapp.foundation import FlightError
from gsapp.virtual.pilot_controllers import AircraftHandling

_BANK = math.radians(25.0)


def compute_handling(model: FlightModel, speed: float, density: float) -> AircraftHandling:
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
        If the aircraft cannot fly level or turn at that speed, or answers the sticks the wrong
        way round.
    """
    level = trim(model, V=speed, rho=density)
    slower = trim(model, V=0.95 * speed, rho=density)
    turn = trim(model, V=speed, rho=density, bank=_BANK)
    controls, now = model.aircraft.controls, level.controls
    pitch_rate = _steady_rate(model, level, ("alpha", "q"), "de") * controls.de.full_stick_high
    roll_rate = _steady_rate(model, level, ("p",), "da") * controls.da.full_stick_high
    if not (pitch_rate > 0.05 and roll_rate > 0.05):
        raise FlightError(
            "the aircraft does not answer the sticks the right way round "
            f"(full pull {math.degrees(pitch_rate):.0f} deg/s, full right "
            f"{math.degrees(roll_rate):.0f} deg/s); check Cm_de, Cl_da, and full_stick in the "
            "aircraft file"
        )
    pull = (turn.controls["de"] - now["de"]) / (1.0 / math.cos(_BANK) - 1.0)
    return AircraftHandling(
        speed=speed,
        pitch_rate=pitch_rate,
        roll_rate=roll_rate,
        low_rate=(
            controls.de.full_stick_low / controls.de.full_stick_high,
            controls.da.full_stick_low / controls.da.full_stick_high,
            controls.dr.full_stick_low / controls.dr.full_stick_high,
        ),
        pitch=level.state[7],
        trim=now["de"] / controls.de.full_stick_high,
        throttle=now["throttle"],
        throttle_slope=(now["throttle"] - slower.controls["throttle"]) / (0.05 * speed),
        turn_pull=pull / controls.de.full_stick_high,
        turn_roll=turn.controls["da"] / math.sin(_BANK) / controls.da.full_stick_high,
        turn_yaw=turn.controls["dr"] / math.sin(_BANK) / controls.dr.full_stick_high,
        flap_travel=controls.flap.travel[1],
    )


def _steady_rate(model: FlightModel, level: Trim, states: tuple[str, ...], surface: str) -> float:
    linear = linearize(model, level, states=states, inputs=(surface,))
    return float(-np.linalg.solve(linear.A, linear.B)[-1, 0])
