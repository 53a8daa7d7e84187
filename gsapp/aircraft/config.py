"""What an aircraft file holds. Values are in SI and radians once read.

Positions are from the center of gravity in body axes (x forward, y right, z down). A section or
sensor that a file leaves out takes the defaults given here.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator, Field, field_validator, model_validator

from gsapp.foundation import StrictModel
from gsapp.quantities.constants import DEGREE, GRAVITY
from gsapp.quantities.fields import (
    Acceleration,
    Angle,
    AngularRate,
    Area,
    Force,
    Frequency,
    Inertia,
    Length,
    Mass,
    MassFlow,
    Position,
    Pressure,
    Ratio,
    RotationSpeed,
    Speed,
    Time,
    Voltage,
)

AT_CG: Position = (0.0, 0.0, 0.0)


def _check_positive(value: float) -> float:
    if not value > 0.0:
        raise ValueError("it must be greater than zero; measure it and write it here")
    return value


_POSITIVE = AfterValidator(_check_positive)


def _several_positions(value: Any) -> Any:
    if isinstance(value, (list, tuple)) and value and not isinstance(value[0], (list, tuple)):
        return [value]
    return value


class Geometry(StrictModel):
    """Reference geometry."""

    wing_area: Annotated[Area, _POSITIVE]  # S, m^2.
    span: Annotated[Length, _POSITIVE]  # b, m.
    chord: Annotated[Length, _POSITIVE]  # Mean aerodynamic chord c, m.
    length: Length | None = None  # Over all, m.


class MassProperties(StrictModel):
    """Mass and inertia at take-off, about the center of gravity in body axes."""

    mass: Annotated[Mass, _POSITIVE]  # With payload and full fuel, kg.
    ixx: Annotated[Inertia, _POSITIVE]
    iyy: Annotated[Inertia, _POSITIVE]
    izz: Annotated[Inertia, _POSITIVE]
    ixz: Inertia = 0.0
    """kg m^2; Ixy = Iyz = 0 by symmetry."""
    fuel: Mass = 0.0  # The part of `mass` that is fuel at take-off, kg.
    fuel_position: Position = AT_CG  # Where the fuel's own center of gravity lies, from the CG, m.
    fuel_flow_idle: MassFlow = 0.0
    fuel_flow_full: MassFlow = 0.0
    """All engines, kg/s."""

    @model_validator(mode="after")
    def _must_be_a_body(self) -> MassProperties:
        if self.ixz**2 >= self.ixx * self.izz:
            raise ValueError("ixz^2 exceeds ixx*izz, which is physically impossible; check ixz")
        for name, one, two in (
            ("ixx", self.iyy, self.izz),
            ("iyy", self.ixx, self.izz),
            ("izz", self.ixx, self.iyy),
        ):
            if getattr(self, name) > one + two:
                raise ValueError(
                    f"{name} exceeds the sum of the other two moments of inertia, which is "
                    "physically impossible; check all three"
                )
        if not 0.0 <= self.fuel < self.mass:
            raise ValueError("fuel must be less than mass, which includes it; check both")
        return self

    @property
    def rms_mass_height(self) -> float:
        """Return the rms height of the mass above and below the CG, m: sqrt((Ixx+Iyy-Izz)/2m)."""
        return math.sqrt(max(self.ixx + self.iyy - self.izz, 0.0) / (2.0 * self.mass))


class Propulsion(StrictModel):
    """Engines: thrust = max_thrust * throttle * rho/rho0 * (1 - V/zero_thrust_speed) along x."""

    max_thrust: Force = 0.0  # Static, all engines, sea level, N.
    zero_thrust_speed: Annotated[Speed, _POSITIVE] = 1e9  # m/s.
    lag: Time = 0.0  # Time constant from throttle to thrust, s.
    position: Annotated[tuple[Position, ...], BeforeValidator(_several_positions)] = (AT_CG,)
    """One for each engine, from the CG, m."""
    rpm_idle: RotationSpeed = 0.0
    rpm_full: RotationSpeed = 0.0
    """Fan speed at closed and full throttle, rad/s."""


class _Sensor(StrictModel):
    """What every sensor may state: where it is and how slow it is.

    `low_pass` is the corner of a second-order Butterworth filter before the converter; None where
    there is no such filter.
    """

    position: Position = AT_CG
    lag: Time = 0.0
    delay: Time = 0.0
    low_pass: Frequency | None = None
    rate: Frequency = 100.0

    @property
    def total_delay(self) -> float:
        """Return how late slow changes are recorded, s: delay, lag and the low-pass together."""
        filtering = 0.0 if self.low_pass is None else math.sqrt(2.0) / (math.tau * self.low_pass)
        return self.delay + self.lag + filtering


class AlphaVane(_Sensor):
    """Angle-of-attack vane; `noise` is the standard deviation, rad."""

    noise: Angle = 0.0
    bias: Angle = 0.0
    range: tuple[Angle, Angle] = (-45 * DEGREE, 45 * DEGREE)
    upwash: Ratio = 1.0


class BetaVane(AlphaVane):
    """Sideslip vane: ``fixed`` on the body's z axis (reads the flank angle), or ``swivel``."""

    kind: Literal["fixed", "swivel"] = "fixed"


class Accelerometer(_Sensor):
    """Three-axis accelerometer; `noise` is the standard deviation of each axis, m/s^2."""

    noise: Acceleration = 0.0
    bias: tuple[Acceleration, Acceleration, Acceleration] = (0.0, 0.0, 0.0)
    range: tuple[Acceleration, Acceleration] = (-16 * GRAVITY, 16 * GRAVITY)


class Gyro(_Sensor):
    """Three rate gyros; `noise` is the standard deviation of each, rad/s.

    `vibration` is the amplitude at the engines' full speed; without an anti-alias filter it
    folds into the samples.
    """

    noise: AngularRate = 0.0
    bias: tuple[AngularRate, AngularRate, AngularRate] = (0.0, 0.0, 0.0)
    range: tuple[AngularRate, AngularRate] = (-2000 * DEGREE, 2000 * DEGREE)
    vibration: AngularRate = 0.0


class AirData(_Sensor):
    """Pitot-static probe; noises are standard deviations, Pa."""

    noise: Pressure = 0.0
    static_noise: Pressure = 0.0
    range: tuple[Pressure, Pressure] = (0.0, 20000.0)
    static_range: tuple[Pressure, Pressure] = (0.0, 120000.0)


class SurfaceSensors(_Sensor):
    """Potentiometers on the surfaces; `noise` is the standard deviation, rad."""

    noise: Angle = 0.0


class Sensors(StrictModel):
    """The instruments; one that is not listed sits at the CG and is ideal."""

    alpha_vane: AlphaVane = Field(default_factory=AlphaVane)
    beta_vane: BetaVane = Field(default_factory=BetaVane)
    accelerometer: Accelerometer = Field(default_factory=Accelerometer)
    gyro: Gyro = Field(default_factory=Gyro)
    air_data: AirData = Field(default_factory=AirData)
    surfaces: SurfaceSensors = Field(default_factory=SurfaceSensors)

    @property
    def by_channel(self) -> dict[str, AlphaVane | Gyro | Accelerometer]:
        """Return the instrument behind each channel that answers to an input."""
        return {
            "alpha": self.alpha_vane,
            "beta": self.beta_vane,
            **dict.fromkeys(("p", "q", "r"), self.gyro),
            **dict.fromkeys(("ax", "ay", "an"), self.accelerometer),
        }

    @property
    def noise_in_flight(self) -> dict[str, float]:
        """Return the standard deviation that each of these channels shows with engines on, SI."""
        found = {name: one.noise for name, one in self.by_channel.items()}
        # A sine has an rms of its amplitude over the root of two.
        shaken = math.hypot(self.gyro.noise, self.gyro.vibration / math.sqrt(2.0))
        return {**found, **dict.fromkeys(("p", "q", "r"), shaken)}


class Control(StrictModel):
    """One control: how it is measured, how it moves, what the pilot's stick does to it."""

    kind: Literal["position", "servo", "command"] = "position"
    """Where the recorded signal is taken: on the surface, at the servo before the linkage, or as
    commanded."""
    travel: tuple[Angle, Angle] = (-25 * DEGREE, 25 * DEGREE)  # Lowest and highest deflection, rad.
    full_stick_high: Angle = 20 * DEGREE
    full_stick_low: Angle = 12 * DEGREE
    """Deflection at full positive stick with the rate switch high and low, rad. Pulled back, and to
    the right, is positive: the elevator's is negative."""
    lag: Time = 0.0
    delay: Time = 0.0
    """Of the servo, s."""
    rate_limit: AngularRate = 1e9  # rad/s.
    slop: Angle = 0.0  # Free play of the linkage, whole width, rad.

    @field_validator("travel")
    @classmethod
    def _low_before_high(cls, value: tuple[float, float]) -> tuple[float, float]:
        if not value[0] < value[1]:
            raise ValueError("the lower end of the travel must come first; swap the two")
        return value


class Limits(StrictModel):
    """Limits of the flight and of the linear model."""

    alpha_linear: tuple[Angle, Angle] = (-5 * DEGREE, 10 * DEGREE)
    """Where the aerodynamics are linear, rad."""
    alpha_stall: Angle = 14 * DEGREE  # rad.
    beta_linear: Angle = 12 * DEGREE  # Largest sideslip of the linear model, rad.
    load_factor: tuple[Acceleration, Acceleration] = (-2 * GRAVITY, 4 * GRAVITY)
    """Lowest and highest normal acceleration, m/s^2."""
    stall_speed: Speed = 0.0
    maximum_speed: Speed = 1e9
    """Calibrated airspeed, m/s."""
    bank: Angle = 75 * DEGREE  # rad.
    flight_time: Annotated[Time, _POSITIVE] | None = None
    """From take-off to landing, s; None where no time is agreed on."""
    battery_empty: Voltage | None = None
    """Where the recorder or the aircraft stops for want of it, V; None where that is not known."""


class Controls(StrictModel):
    """The three controls by their channel ids, and the flap."""

    de: Control = Field(
        default_factory=lambda: Control(full_stick_high="-20 deg", full_stick_low="-12 deg")
    )
    da: Control = Field(default_factory=Control)
    dr: Control = Field(
        default_factory=lambda: Control(full_stick_high="-20 deg", full_stick_low="-12 deg")
    )
    flap: Control = Field(default_factory=Control)


class Axles(StrictModel):
    """Centers of the wheels' axles, from the CG, m; None for those that there are not.

    Reads as a mapping of those that there are; `main` stands for the middle of left and right.
    """

    nose: Position | None = None
    tail: Position | None = None
    main: Position | None = None
    left: Position | None = None
    right: Position | None = None

    def keys(self) -> tuple[str, ...]:
        return tuple(name for name in type(self).model_fields if getattr(self, name) is not None)

    def __getitem__(self, name: str) -> Position:
        place: Position | None = getattr(self, name, None) if name in self.keys() else None
        if place is None:
            raise KeyError(name)
        return place


class Accuracy(StrictModel):
    """How well this file is known: standard deviations, for which bounds of derivatives allow.

    By default those of a small aircraft measured with tape, scale and protractor, without a
    calibration of its vanes in flight.
    """

    mass: Ratio = 0.01  # Share of the mass.
    position: Length = 0.02  # Of each instrument, each axis, m.
    delay: Time = 0.01  # Of each channel, s: filters, sampling, transmission.
    upwash: Ratio = 0.08  # Of each vane, share of its angle.
    accelerometer_bias: Acceleration = 0.01 * GRAVITY  # Of each axis, m/s^2: leveled to 0.5 deg.


class Aircraft(StrictModel):
    """An aircraft file, read."""

    name: str = "aircraft"  # For titles and reports.
    source: str = ""  # Where the numbers come from.
    geometry: Geometry
    mass: MassProperties
    propulsion: Propulsion = Field(default_factory=Propulsion)
    sensors: Sensors = Field(default_factory=Sensors)
    controls: Controls = Field(default_factory=Controls)
    limits: Limits = Field(default_factory=Limits)
    axles: Axles = Field(default_factory=Axles)
    accuracy: Accuracy = Field(default_factory=Accuracy)

    @property
    def states_thrust(self) -> bool:
        """Return whether the aircraft file says what the engines give, or that there are none."""
        return "max_thrust" in self.propulsion.model_fields_set

    @property
    def states_accuracy(self) -> bool:
        """Return whether the file itself says how well it is known."""
        return "accuracy" in self.model_fields_set

    def warnings(self) -> tuple[str, ...]:
        """Return sentences about values that are possible but suspicious."""
        found: list[str] = []
        height = self.mass.rms_mass_height
        if height > 0.1 * self.geometry.span:
            found.append(
                f"ixx + iyy - izz says that the mass lies {height:.2f} m (rms) above and below "
                "the CG, more than a fuselage allows: repeat the pendulum swings"
            )
        weight = self.mass.mass * GRAVITY
        if 0.0 < self.propulsion.max_thrust < 0.1 * weight:
            found.append("max_thrust is less than a tenth of the weight: it will not take off")
        return tuple(found)
