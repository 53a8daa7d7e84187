"""The one vocabulary of channels: ids, symbols, units, signs, limits.

Signs are those of the project's axes: body axes x forward, y right, z down; rates and moments
right-handed about them; each description says what a positive value means.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace
from functools import cache
from typing import Final

from gsapp.foundation import UnknownNameError
from gsapp.foundation.name_suggestions import did_you_mean
from gsapp.quantities import units
from gsapp.quantities.constants import DEGREE, FOOT, GRAVITY


@dataclass(frozen=True, slots=True, kw_only=True)
class ChannelSpec:
    """What a channel means and how it is shown."""

    id: str  # Name in files and in code. A redundant sensor of ``q`` is ``q.2``.
    symbol: str  # As shown beside a chart.
    title: str
    quantity: str
    """Key in `gsapp.quantities.units.QUANTITIES`: SI unit and allowed units."""
    si_display: str
    us_display: str
    """Unit on screen when the user chose SI or US customary units."""
    limits: tuple[float, float]
    """Lowest and highest plausible value, SI. Outside is an instrument at fault."""
    precision: float  # The smallest difference that the sensor earns, in SI; sets the digits shown.
    group: str  # Which charts it is listed with.
    description: str  # What it is and what a positive value means.

    @property
    def unit(self) -> str:
        return units.quantity(self.quantity).si

    @property
    def allowed_units(self) -> tuple[str, ...]:
        return units.quantity(self.quantity).units

    def display_unit(self, system: str) -> str:
        return self.si_display if system == "SI" else self.us_display

    def decimals(self, unit: str) -> int:
        """Return the digits after the point that the sensor's precision earns in `unit`."""
        zero = units.from_si(0.0, unit, self.quantity)
        step = abs(units.from_si(self.precision, unit, self.quantity) - zero)
        digits = 0
        # Of units that are no round multiples of each other one shows steps a little coarser than
        # the sensor's: 0.1 ft/s are 0.03 m/s, which earn one digit, not two.
        while digits < 6 and step < 0.25 * 10.0**-digits:
            digits += 1
        return digits


# fmt: off
INSTRUMENTS: tuple[str, ...] = (
    "elevator_left", "elevator_right", "aileron_left", "aileron_right", "rudder", "alpha", "beta",
    "p", "q", "r", "ax", "ay", "an", "static_pressure", "dynamic_pressure", "temperature",
    "throttle", "flap",
)
# fmt: on
"""Channels whose instruments give volts: each has a ``<id>_volts`` before its calibration."""


def _table() -> list[ChannelSpec]:
    specs: list[ChannelSpec] = []

    def group(
        name: str,
        quantity: str,
        si: str,
        us: str,
        low: float,
        high: float,
        precision: float,
        *rows: tuple[str, str, str, str],
    ) -> None:
        for channel_id, symbol, title, description in rows:
            specs.append(
                ChannelSpec(
                    id=channel_id,
                    symbol=symbol,
                    title=title,
                    quantity=quantity,
                    si_display=si,
                    us_display=us,
                    limits=(low, high),
                    precision=precision,
                    group=name,
                    description=description,
                )
            )

    # fmt: off
    group("Surfaces", "angle", "deg", "deg", -45 * DEGREE, 45 * DEGREE, 0.1 * DEGREE,
          ("de", "delta_e", "Elevator",
           "Mean of both elevators (6.1.1), positive trailing edge down"),
          ("da", "delta_a", "Aileron",
           "Mean of both ailerons (6.1.2), positive rolls the right wing down"),
          ("dr", "delta_r", "Rudder", "Rudder (6.1.3), positive trailing edge left"),
          ("elevator_left", "delta_e left", "Left elevator", "Positive trailing edge down"),
          ("elevator_right", "delta_e right", "Right elevator", "Positive trailing edge down"),
          ("aileron_left", "delta_a left", "Left aileron", "Positive trailing edge down"),
          ("aileron_right", "delta_a right", "Right aileron", "Positive trailing edge up"),
          ("rudder", "rudder", "Rudder surface", "Positive trailing edge left"),
          ("ruddervator_left", "delta_rv left", "Left half of a V-tail",
           "Positive trailing edge down"),
          ("ruddervator_right", "delta_rv right", "Right half of a V-tail",
           "Positive trailing edge down"),
          ("elevon_left", "delta_ev left", "Left elevon", "Positive trailing edge down"),
          ("elevon_right", "delta_ev right", "Right elevon", "Positive trailing edge down"))
    group("Flow", "angle", "deg", "deg", -40 * DEGREE, 40 * DEGREE, 0.1 * DEGREE,
          ("alpha", "alpha", "Angle of attack",
           "At the vane; positive with the nose above the flow"),
          ("beta", "beta", "Angle of sideslip", "At the vane; positive with wind from the right"))
    group("Rates", "angular_rate", "deg/s", "deg/s", -400 * DEGREE, 400 * DEGREE, 0.1 * DEGREE,
          ("p", "p", "Roll rate", "Body axes, positive right wing down"),
          ("q", "q", "Pitch rate", "Body axes, positive nose up"),
          ("r", "r", "Yaw rate", "Body axes, positive nose right"))
    group("Accelerations", "acceleration", "g", "g", -12 * GRAVITY, 12 * GRAVITY, 0.005 * GRAVITY,
          ("ax", "a_x", "Axial acceleration", "Specific force along x, positive forward"),
          ("ay", "a_y", "Lateral acceleration", "Specific force along y, positive right"),
          ("an", "a_n", "Normal acceleration", "Specific force along -z, positive up"))
    group("Air data", "speed", "m/s", "ft/s", 0.0, 150.0, 0.1 * FOOT,
          ("V", "V", "True airspeed", "From dynamic pressure and density"),
          ("Vc", "V_c", "Calibrated airspeed", "At sea-level density; what stall speed follows"))
    group("Air data", "pressure", "Pa", "lbf/ft^2", -500.0, 12000.0, 2.0,
          ("qbar", "qbar", "Dynamic pressure", "rho V^2 / 2, corrected and used by the model"),
          ("dynamic_pressure", "p_dyn", "Differential pressure",
           "Pitot minus static, as measured"))
    group("Air data", "pressure", "kPa", "psi", 20e3, 110e3, 10.0,
          ("static_pressure", "p_static", "Static pressure", "Absolute"))
    group("Air data", "temperature", "degC", "degF", 220.0, 340.0, 0.5,
          ("temperature", "T_air", "Air temperature", "Outside, or of the ground when entered"))
    group("Air data", "length", "m", "ft", -500.0, 12000.0, 1.0 * FOOT,
          ("altitude", "h", "Pressure altitude", "Above sea level in the standard atmosphere"),
          ("height", "h_agl", "Height above the field", "Positive up"))
    group("Air data", "density", "kg/m^3", "slug/ft^3", 0.2, 1.6, 0.001,
          ("density", "rho", "Air density", "From static pressure and temperature"))
    group("Air data", "speed", "m/s", "ft/s", -60.0, 60.0, 0.1,
          ("climb_rate", "h_dot", "Rate of climb", "Positive up"))
    group("Attitude", "angle", "deg", "deg", -181 * DEGREE, 181 * DEGREE, 0.1 * DEGREE,
          ("phi", "phi", "Bank angle", "Positive right wing down"),
          ("theta", "theta", "Pitch attitude", "Positive nose up"))
    group("Attitude", "angle", "deg", "deg", -181 * DEGREE, 361 * DEGREE, 0.1 * DEGREE,
          ("psi", "psi", "Heading", "From true north, positive clockwise"),
          ("track", "chi", "Ground track", "From true north, positive clockwise"))
    group("Propulsion", "ratio", "%", "%", -0.05, 1.05, 0.01,
          ("throttle", "throttle", "Throttle", "0 idle, 1 full"),
          ("throttle_left", "throttle left", "Left throttle", "0 idle, 1 full"),
          ("throttle_right", "throttle right", "Right throttle", "0 idle, 1 full"))
    group("Propulsion", "rotation_speed", "rpm", "rpm", 0.0, 4200.0, 1.0,
          ("rpm_left", "n left", "Left engine speed", "Fan revolutions"),
          ("rpm_right", "n right", "Right engine speed", "Fan revolutions"))
    group("Propulsion", "force", "N", "lbf", -50.0, 1000.0, 0.5,
          ("thrust", "T", "Thrust", "All engines, along x"))
    group("Propulsion", "mass", "kg", "lb", 0.0, 100.0, 0.01,
          ("fuel", "fuel", "Fuel left", "Mass on board"),
          ("mass", "m", "Mass", "Aircraft with fuel"))
    group("Controls", "angle", "deg", "deg", -5 * DEGREE, 90 * DEGREE, 0.5 * DEGREE,
          ("flap", "flap", "Flap", "Positive trailing edge down"))
    group("Controls", "angle", "deg", "deg", -45 * DEGREE, 45 * DEGREE, 0.1 * DEGREE,
          ("de_command", "delta_e cmd", "Elevator command", "As the receiver asks of the servo"),
          ("da_command", "delta_a cmd", "Aileron command", "As the receiver asks of the servo"),
          ("dr_command", "delta_r cmd", "Rudder command", "As the receiver asks of the servo"))
    group("Controls", "ratio", "%", "%", -1.3, 1.3, 0.01,
          ("stick_pitch", "stick pitch", "Pitch stick", "-1 to 1, positive pulled: nose up"),
          ("stick_roll", "stick roll", "Roll stick", "-1 to 1, positive right"),
          ("stick_yaw", "stick yaw", "Rudder stick", "-1 to 1, positive right: nose right"),
          ("rate_switch", "rates", "Rate switch", "0 low rate, 1 high rate"),
          ("gear", "gear", "Landing gear", "0 up, 1 down"))
    group("Position", "latitude", "deg", "deg", -3.1415927, 3.1415927, 1e-8,
          ("latitude", "lat", "Latitude", "WGS 84, positive north"),
          ("longitude", "lon", "Longitude", "WGS 84, positive east"))
    group("Position", "length", "m", "ft", -2e5, 2e5, 0.5,
          ("north", "north", "Distance north", "From the field's origin"),
          ("east", "east", "Distance east", "From the field's origin"))
    group("Position", "speed", "m/s", "ft/s", 0.0, 200.0, 0.1,
          ("ground_speed", "V_g", "Ground speed", "Over the ground"))
    group("Position", "speed", "m/s", "ft/s", -60.0, 60.0, 0.1,
          ("wind_north", "wind north", "Wind from the south", "Air moving north positive"),
          ("wind_east", "wind east", "Wind from the west", "Air moving east positive"))
    group("Health", "voltage", "V", "V", 0.0, 60.0, 0.01,
          ("battery", "V_bat", "Battery", "Recorder and sensors"),
          ("battery_receiver", "V_rx", "Receiver battery", "Receiver and servos"),
          ("excitation", "V_exc", "Excitation", "Supply of the potentiometers"))
    group("Health", "current", "A", "A", -200.0, 500.0, 0.1,
          ("battery_current", "I_bat", "Battery current", "Positive out of the battery"))
    group("Health", "ratio", "%", "%", 0.0, 1.0, 0.01,
          ("rc_rssi", "RC", "Receiver signal", "0 lost, 1 full"),
          ("link_rssi", "link", "Telemetry signal", "0 lost, 1 full"),
          ("link_loss", "loss", "Frames lost on the link", "Share over the last seconds"),
          ("cpu_load", "cpu", "Load of the on-board computer", "0 idle, 1 full"))
    group("Health", "count", "", "", 0.0, 99.0, 1.0,
          ("gps_satellites", "sats", "Satellites", "Used in the position"))
    group("Health", "ratio", "", "", 0.0, 99.99, 0.01,
          ("gps_hdop", "HDOP", "Horizontal dilution of precision", "Below 2 good"))
    group("Health", "temperature", "degC", "degF", 200.0, 400.0, 1.0,
          ("box_temperature", "T_box", "Temperature in the box", "Of the on-board computer"))
    for instrument in INSTRUMENTS:
        group("Volts", "voltage", "V", "V", -10.0, 15.0, 0.002,
              (f"{instrument}_volts", f"{instrument} volts", f"Volts of {instrument}",
               f"As converted, before the calibration of {instrument}"))
    # fmt: on
    return specs


CHANNELS: dict[str, ChannelSpec] = {spec.id: spec for spec in _table()}
"""Every channel by its id, in the order in which they are listed."""

_SHORT_NAMES: Final = {"beta": "sideslip", "V": "airspeed"}


def name_in_text(channel_id: str) -> str:
    """Return the name of a channel within a sentence: ``angle of attack``, ``elevator``."""
    return _SHORT_NAMES.get(channel_id) or CHANNELS[channel_id].title.lower()


SURFACE_NAMES: Final = {name: name_in_text(name) for name in ("de", "da", "dr")}
"""Control surfaces by channel."""
CIRCULAR_CHANNELS: Final = frozenset({"phi", "psi", "track", "longitude"})
"""Angles that begin anew after a turn: between two samples they take the short way."""
STEPWISE_CHANNELS: Final = frozenset({"rate_switch", "gear", "gps_satellites"})
"""Switches and counts: they keep the former value between two samples."""
_REDUNDANT = re.compile(r"(?P<base>.+)\.(?P<number>[2-9])")


_RAW = re.compile(r"(?P<message>[A-Za-z]\w*)(\[\w+\])?\.[A-Za-z_]\w*(\[\d+\])?")


def is_raw_channel(channel_id: str) -> bool:
    """Return whether an id names a field of a message: ``ATT.DesRoll``, ``ESC[1].RPM``.

    Raw channels are numbers as the message holds them, without unit and meaning.
    """
    match = _RAW.fullmatch(channel_id)
    return match is not None and match["message"] not in CHANNELS


def base_id(channel_id: str) -> str:
    """Return ``q`` for ``q``, ``q.2`` and ``q.3``: the quantity that is measured."""
    match = _REDUNDANT.fullmatch(channel_id)
    return match["base"] if match else channel_id


@cache
def channel(channel_id: str) -> ChannelSpec:
    """Return the spec of a channel, redundant ones included.

    Raise UnknownNameError if the vocabulary has no such id; the nearest known ids are named.
    """
    base = base_id(channel_id)
    spec = CHANNELS.get(base)
    if spec is None and is_raw_channel(channel_id):
        return _raw_channel(channel_id)
    if spec is None:
        usual = "ids are such as alpha, q, de, V, elevator_left or static_pressure"
        hint = did_you_mean(base, CHANNELS, usual)
        raise UnknownNameError(f"no channel is called '{channel_id}'; {hint}")
    if base == channel_id:
        return spec
    number = channel_id.rpartition(".")[2]
    return replace(
        spec,
        id=channel_id,
        symbol=f"{spec.symbol} {number}",
        title=f"{spec.title}, sensor {number}",
    )


def _raw_channel(channel_id: str) -> ChannelSpec:
    return ChannelSpec(
        id=channel_id,
        symbol=channel_id,
        title="As recorded",
        quantity="count",
        si_display="",
        us_display="",
        limits=(-math.inf, math.inf),
        precision=1e-3,
        group="Raw",
        description="The number that the message holds",
    )
