"""The aircraft in the pilot's hands: sticks in, motion out, on the runway and in the air.

The equations are those of `gsapp.dynamics.equations` in body axes, the loads those of
`gsapp.dynamics.flight_model`; added here are what a whole flight needs besides: transmitter,
servos, engines, fuel, wheels and wind.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.dynamics.atmosphere import GRAVITY, Atmosphere, Turbulence, pressure_altitude
from gsapp.dynamics.equations import (
    Quaternion,
    angular_accelerations,
    body_rates,
    euler_from_quaternion,
    quaternion_from_euler,
    quaternion_rates,
    rotation,
)
from gsapp.dynamics.flight_model import FlightModel
from gsapp.dynamics.pilot.exposure import (
    Vector,
    accelerations_at,
    alpha_vane,
    beta_vane,
    flow_angles,
    velocity_at,
)
from gsapp.dynamics.pilot.gear import LandingGear
from gsapp.dynamics.pilot.hands import Sticks
from gsapp.dynamics.pilot.mission import START_ALONG
from gsapp.dynamics.pilot.plan import FlightPlan
from gsapp.dynamics.pilot.powerplant import Powerplant
from gsapp.dynamics.pilot.sight import Runway, Situation
from gsapp.dynamics.pilot.surfaces import Surfaces

TRUTH = (
    "V", "alpha", "beta", "p", "q", "r", "phi", "theta", "psi", "ax", "ay", "an",
    "qbar", "Vc", "density", "static_pressure", "temperature", "altitude",
    "north", "east", "height", "climb_rate", "ground_speed", "track", "wind_north", "wind_east",
    "de", "da", "dr", "flap", "throttle", "rpm_left", "rpm_right", "thrust", "mass", "fuel",
    "de_command", "da_command", "dr_command",
    "stick_pitch", "stick_roll", "stick_yaw", "rate_switch",
)  # fmt: skip
"""Channels of the truth: at the CG, before any instrument."""

EXPOSED = (
    "elevator_left", "elevator_right", "aileron_left", "aileron_right", "rudder",
    "alpha", "beta", "p", "q", "r", "ax", "ay", "an", "static_pressure", "dynamic_pressure",
    "temperature", "throttle", "flap", "excitation", "battery", "rpm_left", "rpm_right",
)  # fmt: skip
"""What the instruments are exposed to, where they sit."""

BOARD = (
    "phi", "theta", "psi", "p", "q", "r", "servo_aileron", "servo_elevator", "servo_rudder",
    "servo_flap", "throttle_command", "stick_roll", "stick_pitch", "stick_yaw", "rate_switch",
    "rc_rssi", "rpm_left", "rpm_right", "static_pressure", "dynamic_pressure", "temperature",
    "Vc", "ground_speed", "throttle", "altitude", "climb_rate", "latitude", "longitude", "height",
    "elevation", "velocity_north", "velocity_east", "cpu_load", "battery", "battery_current",
    "battery_remaining", "armed",
)  # fmt: skip
"""What the autopilot-like board in the box knows."""

_EARTH_RADIUS = 6_371_000.0
_SLOWEST = 1.0
"""Airspeed below which the aerodynamics are not followed any further down, m/s."""
_SUPPLY = 4.96
"""Of the potentiometers on the day, V; the certificates were taken at 5 V."""


class Airframe:
    """One aircraft, from standing on the runway to standing on it again.

    Parameters
    ----------
    plan : FlightPlan
        Field and engines.
    flight_model : FlightModel
        Aircraft, aerodynamics and hidden effects.
    turbulence : float
        Standard deviation of the gusts, m/s.
    random : numpy.random.Generator
    dt : float
        Step, s.
    """

    def __init__(
        self,
        plan: FlightPlan,
        flight_model: FlightModel,
        *,
        turbulence: float,
        random: np.random.Generator,
        dt: float,
    ) -> None:
        conditions = plan.conditions
        aircraft = flight_model.aircraft
        self._plan = plan
        self._aircraft = aircraft
        self._model = flight_model
        self._dt = dt
        self._atmosphere = Atmosphere(
            ground_altitude=conditions.elevation, ground_temperature=conditions.temperature
        )
        self._wind = (
            -conditions.wind_speed * math.cos(conditions.wind_from),
            -conditions.wind_speed * math.sin(conditions.wind_from),
        )
        seed = int(random.integers(2**31))
        self._turbulence = Turbulence(turbulence, seed=seed) if turbulence > 0.0 else None
        self._gust: Vector = (0.0, 0.0, 0.0)
        self._gear = LandingGear(aircraft)
        self._surfaces = Surfaces(flight_model, random, dt)
        self._powerplant = Powerplant(aircraft, plan.engines.imbalance, dt)
        tilt = random.standard_normal(2) * math.radians(0.4)
        self._board_tilt = (float(tilt[0]), float(tilt[1]))
        self._rssi = random.uniform(0.9, 1.0)
        runway = Runway(conditions, plan.pattern.side)
        north, east = runway.north_east(START_ALONG, 0.0)
        height = self._gear.height - 0.02
        attitude = quaternion_from_euler(0.0, 0.0, conditions.runway_heading)
        # u v w, p q r, quaternion, north east down, then the states of the model's terms.
        self._state: list[float] = [
            *(0.0,) * 6, *attitude, north, east, -height, *self._resting_terms()
        ]  # fmt: skip
        self._steer, self._brake = 0.0, 1.0
        self._sticks = Sticks()
        self._time = 0.0
        self._parked: tuple[float, float] | None = (north, east)
        self._settle()
        self._note()

    # --- motion ---------------------------------------------------------------------------------

    def situation(self) -> Situation:
        """Return where the aircraft is and how it moves."""
        u, v, w, p, q, r, *_ = self._state
        north, east, down = self._state[10:13]
        ground = self._ground_velocity(self._state)
        phi, theta, psi = euler_from_quaternion(self._attitude(self._state))
        return Situation(
            time=self._time,
            phi=phi,
            theta=theta,
            psi=psi,
            p=p,
            q=q,
            r=r,
            north=north,
            east=east,
            height=-down - self._gear.height,
            velocity_north=ground[0],
            velocity_east=ground[1],
            climb_rate=-ground[2],
            airspeed=self._flow_speed,
            on_ground=self._on_wheels,
        )

    @property
    def broken(self) -> bool:
        """Return whether the aircraft lies on the runway in another way than on its wheels."""
        height = -self._state[12]
        phi, theta, _ = euler_from_quaternion(self._attitude(self._state))
        upset = abs(phi) > math.radians(35.0) or abs(theta) > math.radians(30.0)
        return height < 0.5 * self._gear.height or (height < 1.2 * self._gear.height and upset)

    @property
    def model(self) -> FlightModel:
        """Return the equations of the aircraft."""
        return self._model

    def density(self, height: float) -> float:
        """Return the density of the air at a height above the field, kg/m^3."""
        return float(self._atmosphere.density(self._plan.conditions.elevation + height))

    def advance(self, sticks: Sticks) -> None:
        """Go on by one step with the sticks where they are."""
        dt = self._dt
        self._sticks = sticks
        self._surfaces.advance(sticks)
        self._powerplant.advance(sticks.throttle, running=sticks.engines, speed=self._flow_speed)
        self._steer, self._brake = sticks.yaw, sticks.brake
        self._park(sticks)
        if self._turbulence is not None:
            gust = self._turbulence.advance(dt, max(self._flow_speed, 5.0))
            # Near the ground the eddies have no room.
            share = min(1.0, 0.2 + max(-self._state[12], 0.0) / 15.0)
            self._gust = (share * gust[0], share * gust[1], share * gust[2])
        x = self._state
        k1 = self._rates(x)
        k2 = self._rates([a + 0.5 * dt * b for a, b in zip(x, k1, strict=True)])
        k3 = self._rates([a + 0.5 * dt * b for a, b in zip(x, k2, strict=True)])
        k4 = self._rates([a + dt * b for a, b in zip(x, k3, strict=True)])
        x = [
            a + dt / 6.0 * (b1 + 2.0 * b2 + 2.0 * b3 + b4)
            for a, b1, b2, b3, b4 in zip(x, k1, k2, k3, k4, strict=True)
        ]
        norm = math.sqrt(sum(e * e for e in x[6:10]))
        x[6:10] = [e / norm for e in x[6:10]]
        self._state = x
        self._time += dt
        self._note()

    def _park(self, sticks: Sticks) -> None:
        """While the brakes are full on and it stands, somebody holds the aircraft in place."""
        u, v, *_ = self._state
        if sticks.brake < 1.0:
            self._parked = None
        elif self._parked is None and math.hypot(u, v) < 0.5:
            self._parked = (self._state[10], self._state[11])

    def _settle(self) -> None:
        """Let the wheels take the weight before the box is switched on."""
        for _ in range(round(2.0 / self._dt)):
            self._note()
            self.advance(Sticks(brake=1.0))
        self._time = 0.0

    def _rates(self, x: Sequence[float]) -> list[float]:
        matrix = rotation(self._attitude(x))
        velocity, rates = (x[0], x[1], x[2]), (x[3], x[4], x[5])
        flow = self._flow(velocity, matrix)
        V, alpha, beta = flow_angles(flow)
        density = self.density(-x[12])
        state = (max(V, _SLOWEST), alpha, beta, *rates, 0.0, 0.0, 0.0, *x[13:])
        totals = self._model.totals(state, self._inputs(density))
        loads, mass = totals.loads, totals.body.mass
        ground, self._on_wheels = self._gear.loads(
            x[12], velocity, rates, matrix, steer=self._steer, brake=self._brake
        )
        hold = self._held(x, matrix)
        force = (
            loads.X + ground.X + hold[0],
            loads.Y + ground.Y + hold[1],
            loads.Z + ground.Z + hold[2],
        )
        gravity = (GRAVITY * matrix[6], GRAVITY * matrix[7], GRAVITY * matrix[8])
        self._force = (force[0] / mass, force[1] / mass, force[2] / mass)
        self._spin = angular_accelerations(
            *rates, loads.L + ground.L, loads.M + ground.M, loads.N + ground.N, totals.body
        )
        self._thrust = totals.thrust
        return [
            *body_rates(velocity, rates, force, gravity, mass),
            *self._spin,
            *quaternion_rates(self._attitude(x), *rates),
            *_to_earth(matrix, velocity),
            *totals.term_rates,
        ]

    def _held(self, x: Sequence[float], matrix: Sequence[float]) -> Vector:
        """Return the force of whoever holds the aircraft before the start, body axes, N."""
        if self._parked is None:
            return 0.0, 0.0, 0.0
        mass = self._aircraft.mass.mass
        velocity = _to_earth(matrix, (x[0], x[1], x[2]))
        stiffness, damping = 400.0 * mass, 30.0 * mass
        north = stiffness * (self._parked[0] - x[10]) - damping * velocity[0]
        east = stiffness * (self._parked[1] - x[11]) - damping * velocity[1]
        return _to_body(matrix, (north, east, 0.0))

    def _inputs(self, density: float) -> tuple[float, ...]:
        de, da, dr, flap = self._surfaces.positions
        plant = self._powerplant
        mass = self._aircraft.mass.mass - plant.burned
        return (de, da, dr, flap, plant.throttle, 0.0, density, mass)

    def _resting_terms(self) -> tuple[float, ...]:
        state = (_SLOWEST, *(0.0,) * 8)
        settled = self._model.resting_states(state, self._inputs(1.225))
        return tuple(float(value) for value in settled)

    def _flow(self, velocity: Vector, matrix: Sequence[float]) -> Vector:
        """Return the velocity through the air, body axes, m/s."""
        wind = _to_body(matrix, (self._wind[0], self._wind[1], 0.0))
        gust = self._gust
        return (
            velocity[0] - wind[0] - gust[0],
            velocity[1] - wind[1] - gust[1],
            velocity[2] - wind[2] - gust[2],
        )

    @staticmethod
    def _attitude(x: Sequence[float]) -> Quaternion:
        return (x[6], x[7], x[8], x[9])

    def _ground_velocity(self, x: Sequence[float]) -> Vector:
        return _to_earth(rotation(self._attitude(x)), (x[0], x[1], x[2]))

    def _note(self) -> None:
        """Keep what the situation at this moment adds to the state."""
        matrix = rotation(self._attitude(self._state))
        u, v, w = self._state[:3]
        self._flow_now = self._flow((u, v, w), matrix)
        self._flow_speed = flow_angles(self._flow_now)[0]
        self._rates(self._state)

    # --- what is recorded -----------------------------------------------------------------------

    def truth(self) -> tuple[float, ...]:
        """Return the truth now, in the order of `TRUTH`."""
        p, q, r = self._state[3:6]
        north, east, down = self._state[10:13]
        phi, theta, psi = euler_from_quaternion(self._attitude(self._state))
        V, alpha, beta = flow_angles(self._flow_now)
        air = self._atmosphere.at(self._plan.conditions.elevation - down)
        ground = self._ground_velocity(self._state)
        qbar = 0.5 * air.density * V * V
        de, da, dr, flap = self._surfaces.positions
        plant, sticks = self._powerplant, self._sticks
        fx, fy, fz = self._force
        return (
            V, alpha, beta, p, q, r, phi, theta, psi, fx, fy, -fz,
            qbar, math.sqrt(2.0 * qbar / 1.225), air.density, air.pressure, air.temperature,
            float(pressure_altitude(air.pressure)),
            north, east, -down - self._gear.height, -ground[2],
            math.hypot(ground[0], ground[1]), math.atan2(ground[1], ground[0]), *self._wind,
            de, da, dr, flap, plant.throttle, *plant.speeds, self._thrust,
            self._aircraft.mass.mass - plant.burned,
            max(self._aircraft.mass.fuel - plant.burned, 0.0),
            *self._surfaces.commands,
            sticks.pitch, sticks.roll, sticks.yaw, float(sticks.high_rate),
        )  # fmt: skip

    def exposed(self) -> tuple[float, ...]:
        """Return what the instruments are exposed to now, in the order of `EXPOSED`."""
        sensors = self._aircraft.sensors
        rates: Vector = (self._state[3], self._state[4], self._state[5])
        flow = self._flow_now
        vane, fin = sensors.alpha_vane, sensors.beta_vane
        at_vane = velocity_at(vane.position, flow, rates)
        at_fin = velocity_at(fin.position, flow, rates)
        at_probe = velocity_at(sensors.air_data.position, flow, rates)
        air = self._atmosphere.at(self._plan.conditions.elevation - self._state[12])
        speed = math.sqrt(sum(part * part for part in at_probe))
        return (
            *self._surfaces.shown,
            alpha_vane(at_vane, vane.upwash),
            beta_vane(at_fin, fin.kind, fin.upwash),
            *rates,
            *accelerations_at(sensors.accelerometer.position, self._force, rates, self._spin),
            air.pressure,
            0.5 * air.density * speed * speed,
            air.temperature,
            self._powerplant.lever,
            self._surfaces.positions[3],
            _SUPPLY - 2e-5 * self._time,
            self._battery(),
            *self._powerplant.speeds,
        )

    def board(self) -> tuple[float, ...]:
        """Return what the board knows now, in the order of `BOARD`."""
        situation = self.situation()
        conditions, sticks = self._plan.conditions, self._sticks
        air = self._atmosphere.at(conditions.elevation - self._state[12])
        qbar = 0.5 * air.density * self._flow_speed**2
        latitude = conditions.latitude + situation.north / _EARTH_RADIUS
        longitude = conditions.longitude + situation.east / (
            _EARTH_RADIUS * math.cos(conditions.latitude)
        )
        servos = self._surfaces.servo_shares
        return (
            situation.phi + self._board_tilt[0],
            situation.theta + self._board_tilt[1],
            situation.psi,
            situation.p, situation.q, situation.r,
            servos[1], servos[0], servos[2], servos[3],
            sticks.throttle, sticks.roll, sticks.pitch, sticks.yaw, float(sticks.high_rate),
            self._rssi,
            *self._powerplant.speeds,
            air.pressure, qbar, air.temperature,
            math.sqrt(2.0 * qbar / 1.225),
            math.hypot(situation.velocity_north, situation.velocity_east),
            self._powerplant.throttle,
            conditions.elevation + situation.height,
            situation.climb_rate,
            latitude, longitude, situation.height, conditions.elevation,
            situation.velocity_north, situation.velocity_east,
            0.31, self._battery(), 1.4, max(0.0, 0.98 - self._time / 5400.0),
            float(sticks.engines),
        )  # fmt: skip

    def _battery(self) -> float:
        return 12.6 - 6e-4 * self._time


def _to_earth(matrix: Sequence[float], vector: Vector) -> Vector:
    x, y, z = vector
    return (
        matrix[0] * x + matrix[1] * y + matrix[2] * z,
        matrix[3] * x + matrix[4] * y + matrix[5] * z,
        matrix[6] * x + matrix[7] * y + matrix[8] * z,
    )


def _to_body(matrix: Sequence[float], vector: Vector) -> Vector:
    n, e, d = vector
    return (
        matrix[0] * n + matrix[3] * e + matrix[6] * d,
        matrix[1] * n + matrix[4] * e + matrix[7] * d,
        matrix[2] * n + matrix[5] * e + matrix[8] * d,
    )
