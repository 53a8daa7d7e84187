"""The aircraft in the pilot's hands: sticks in, motion out, on the runway and in the air.

The motion is that of `gsapp.dynamics.simulation.Simulator`; added here are the transmitter, the
wheels, the sensors' places, and what else a box on board takes note of.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.dynamics.atmosphere import SEA_LEVEL_DENSITY, Atmosphere, DrydenTurbulence, Wind
from gsapp.dynamics.equations import Loads, Matrix
from gsapp.dynamics.flight_model import FlightModel
from gsapp.dynamics.model import Model
from gsapp.dynamics.sensors import (
    Vector,
    accelerations_at,
    alpha_vane,
    beta_vane,
    pitot_airspeed,
    velocity_at,
)
from gsapp.dynamics.signal_terms import SignalPath, SignalTerm, channels_of_target
from gsapp.dynamics.simulation import ControlCommands, Simulator, Vector3
from gsapp.dynamics.terms import POSITIONED_INSTRUMENTS
from gsapp.quantities.constants import EARTH_RADIUS, GRAVITY
from gsapp.virtual.flight_plan import FlightPlan
from gsapp.virtual.human_pilot import AircraftHandling
from gsapp.virtual.mission import upwind_start
from gsapp.virtual.pilot_perception import AircraftState, RunwayFrame
from gsapp.virtual.settings import VIRTUAL
from gsapp.virtual.sticks import StickPositions

# Three wheels on the runway: springs, dampers, tires.
# The source gives no numbers of the gear but its layout, one nose wheel and two mains. Stiffness
# and damping are chosen so that the aircraft sits down 3 cm under its weight and does not bounce
# twice; they matter to the look of a landing, not to any derivative.


@dataclass(frozen=True, slots=True, kw_only=True)
class Wheel:
    """One wheel."""

    position: Vector3
    """Of the unloaded tire's lowest point from the CG, body axes, m."""
    steers: bool
    brakes: bool
    """Whether it turns with the rudder stick, and whether it has a brake."""


class LandingGear:
    """Forces of the wheels; length, span and mass of the aircraft give the size of the gear."""

    ROLLING_FRICTION = 0.03
    BRAKE_FRICTION = 0.9
    """At full brake, which stands for chocks as well."""
    SIDE_FRICTION = 0.7
    STEERING = math.radians(20.0)
    """Angle of the nose wheel at full stick, rad."""

    def __init__(self, aircraft: Aircraft) -> None:
        length = aircraft.geometry.length or aircraft.geometry.span
        half_track = 0.11 * aircraft.geometry.span
        self.height = 0.15 * length
        """Of the CG above the unloaded wheels, m."""
        self.wheels = (
            Wheel(position=(0.3 * length, 0.0, self.height), steers=True, brakes=False),
            Wheel(position=(-0.03 * length, -half_track, self.height), steers=False, brakes=True),
            Wheel(position=(-0.03 * length, half_track, self.height), steers=False, brakes=True),
        )
        weight = aircraft.mass.mass * GRAVITY
        self._stiffness = weight / 2.0 / 0.03
        self._damping = 1.3 * math.sqrt(self._stiffness * aircraft.mass.mass / 2.0)

    def loads(
        self,
        down: float,
        velocity: Vector3,
        rates: Vector3,
        matrix: Matrix,
        *,
        steer: float,
        brake: float,
    ) -> tuple[Loads, bool]:
        """Return the loads of the ground, and whether a main wheel carries weight.

        `down` is the CG's depth below the runway (negative above it), m; `velocity` is over the
        ground along the body axes, m/s; `rates` p, q, r, rad/s; `matrix` body to Earth, row by row;
        `steer` -1 to 1, positive right; `brake` 0 to 1.
        """
        u, v, w = velocity
        p, q, r = rates
        X = Y = Z = L = M = N = 0.0
        weight_on_wheels = False
        for wheel in self.wheels:
            x, y, z = wheel.position
            deep = down + matrix[6] * x + matrix[7] * y + matrix[8] * z
            if deep <= 0.0:
                continue
            along, side, vertical = u + q * z - r * y, v + r * x - p * z, w + p * y - q * x
            sinking = matrix[6] * along + matrix[7] * side + matrix[8] * vertical
            # The damper pulls no wheel into the ground, and bites as the tire flattens.
            bite = min(deep / 0.03, 1.0)
            push = max(self._stiffness * deep + bite * self._damping * sinking, 0.0)
            weight_on_wheels = weight_on_wheels or not wheel.steers
            angle = steer * self.STEERING if wheel.steers else 0.0
            ca, sa = math.cos(angle), math.sin(angle)
            rolling = along * ca + side * sa
            sliding = side * ca - along * sa
            friction = self.ROLLING_FRICTION + (self.BRAKE_FRICTION * brake if wheel.brakes else 0)
            drag = -friction * push * math.tanh(rolling / VIRTUAL.wheel_grip_speed)
            grip = -self.SIDE_FRICTION * push * math.tanh(sliding / max(0.2, 0.1 * abs(rolling)))
            fx, fy, fz = drag * ca - grip * sa, drag * sa + grip * ca, -push
            X += fx
            Y += fy
            Z += fz
            L += y * fz - z * fy
            M += z * fx - x * fz
            N += x * fy - y * fx
        return Loads(X, Y, Z, L, M, N), weight_on_wheels


TRUTH_CHANNELS = (
    "V", "alpha", "beta", "p", "q", "r", "phi", "theta", "psi", "ax", "ay", "an",
    "qbar", "Vc", "density", "static_pressure", "temperature", "altitude",
    "north", "east", "height", "climb_rate", "ground_speed", "track", "wind_north", "wind_east",
    "de", "da", "dr", "flap", "throttle", "rpm_left", "rpm_right", "thrust", "mass", "fuel",
    "de_command", "da_command", "dr_command",
    "stick_pitch", "stick_roll", "stick_yaw", "rate_switch",
)  # fmt: skip
"""Channels of the truth: at the CG, before any instrument."""

INSTRUMENT_INPUT_CHANNELS = (
    "elevator_left", "elevator_right", "aileron_left", "aileron_right", "rudder",
    "alpha", "beta", "p", "q", "r", "ax", "ay", "an", "static_pressure", "dynamic_pressure",
    "temperature", "throttle", "flap", "excitation", "battery", "rpm_left", "rpm_right",
)  # fmt: skip
"""What the instruments are exposed to, where they sit."""

ONBOARD_CHANNELS = (
    "phi", "theta", "psi", "p", "q", "r", "servo_aileron", "servo_elevator", "servo_rudder",
    "servo_flap", "throttle_command", "stick_roll", "stick_pitch", "stick_yaw", "rate_switch",
    "rc_rssi", "rpm_left", "rpm_right", "static_pressure", "dynamic_pressure", "temperature",
    "Vc", "ground_speed", "throttle", "altitude", "climb_rate", "latitude", "longitude", "height",
    "elevation", "velocity_north", "velocity_east", "cpu_load", "battery", "battery_current",
    "battery_remaining", "armed",
)  # fmt: skip
"""What the autopilot-like board in the box knows."""


_STATE_CHANNELS = ("phi", "theta", "psi", "p", "q", "r", "north", "east", "climb_rate")


class Airframe:
    """One aircraft, from standing on the runway to standing on it again.

    `turbulence` is the standard deviation of the gusts, m/s, `is_rotational` whether they turn the
    air as well; `dt` the step, s.
    """

    def __init__(
        self,
        plan: FlightPlan,
        aircraft: Aircraft,
        model: Model,
        *,
        turbulence: float,
        random: np.random.Generator,
        dt: float,
        is_rotational: bool = False,
    ) -> None:
        conditions = plan.conditions
        self._plan = plan
        self._aircraft = aircraft
        self._dt = dt
        self._gear = LandingGear(aircraft)
        seed = int(random.integers(2**31))
        span = aircraft.geometry.span if is_rotational else None
        self.simulator = Simulator(
            aircraft,
            model,
            atmosphere=Atmosphere(
                ground_altitude=conditions.elevation, ground_temperature=conditions.temperature
            ),
            wind=Wind(
                north=-conditions.wind_speed * math.cos(conditions.wind_from),
                east=-conditions.wind_speed * math.sin(conditions.wind_from),
            ),
            turbulence=(
                DrydenTurbulence(turbulence, seed=seed, span=span) if turbulence > 0.0 else None
            ),
            ground=self._gear,
            dt=dt,
        )
        rigging = VIRTUAL.rigging_std * random.standard_normal(2)
        self._rigging = (float(rigging[0]), float(rigging[1]))
        tilt = math.radians(0.4) * random.standard_normal(2)
        self._board_tilt = (float(tilt[0]), float(tilt[1]))
        self._rssi = float(random.uniform(0.9, 1.0))
        self._sensor_paths = _sensor_paths(self.simulator, dt)
        self._places = _instrument_positions(self.simulator.model, aircraft)
        self._sticks = StickPositions(brake=1.0)
        runway = RunwayFrame(conditions, plan.pattern.side)
        self.simulator.start_on_ground(
            heading=conditions.runway_heading,
            height=self._gear.height,
            position=runway.to_north_east(VIRTUAL.takeoff_start_along, 0.0),
            commands=self._commands(self._sticks),
        )
        for _ in range(round(VIRTUAL.settling_time / dt)):
            self.simulator.step(self._commands(self._sticks))
        self._resting_height = self.simulator.sample()["height"]
        self._time = 0.0
        self._note()

    def begin_in_air(self, feel: AircraftHandling) -> None:
        """Begin anew in level flight, as the pilot knows it, where the upwind leg begins."""
        conditions, pattern = self._plan.conditions, self._plan.pattern
        self._sticks = StickPositions(pitch=feel.trim, throttle=feel.throttle, engines=True)
        self.simulator.start_in_air(
            V=feel.speed,
            alpha=feel.pitch,
            attitude=(0.0, feel.pitch, conditions.runway_heading),
            height=self._resting_height + pattern.height,
            position=RunwayFrame(conditions, pattern.side).to_north_east(*upwind_start(pattern)),
            commands=self._commands(self._sticks),
        )
        self._note()

    # --- motion ---------------------------------------------------------------------------------

    def aircraft_state(self) -> AircraftState:
        now = self._now
        return AircraftState(
            time=self._time,
            **{name: now[name] for name in _STATE_CHANNELS},
            height=now["height"] - self._resting_height,
            velocity_north=now["ground_speed"] * math.cos(now["track"]),
            velocity_east=now["ground_speed"] * math.sin(now["track"]),
            airspeed=now["V"],
            on_ground=now["on_ground"] > 0.5,
        )

    @property
    def has_crashed(self) -> bool:
        """Return whether the aircraft lies on the runway in another way than on its wheels."""
        now, height = self._now, self._gear.height
        upset = abs(now["phi"]) > math.radians(35.0) or abs(now["theta"]) > math.radians(30.0)
        return now["height"] < 0.5 * height or (now["height"] < 1.2 * height and upset)

    def density(self, height: float) -> float:
        return float(self.simulator.atmosphere.density(self._plan.conditions.elevation + height))

    def advance(self, sticks: StickPositions) -> None:
        self._sticks = sticks
        self.simulator.step(self._commands(sticks))
        self._time += self._dt
        self._note()

    def _commands(self, sticks: StickPositions) -> ControlCommands:
        controls = self._aircraft.controls
        deflections = [
            stick * (control.full_stick_high if sticks.high_rate else control.full_stick_low)
            for stick, control in (
                (sticks.pitch, controls.de),
                (sticks.roll, controls.da),
                (sticks.yaw, controls.dr),
            )
        ]
        return ControlCommands(
            de=deflections[0],
            da=deflections[1],
            dr=deflections[2],
            flap=controls.flap.travel[1] * sticks.flap,
            throttle=sticks.throttle,
            steer=sticks.yaw,
            brake=sticks.brake,
            engines=sticks.engines,
        )

    def _note(self) -> None:
        now = self.simulator.sample()
        if now["V"] < VIRTUAL.vane_friction_speed:
            now["alpha"] = now["beta"] = 0.0
        # Unloaded by the air that comes in, and never two engines alike.
        unloaded = 1.0 + VIRTUAL.fan_speedup * min(now["V"] / VIRTUAL.fan_speedup_speed, 1.0)
        half = 0.5 * self._plan.engines.imbalance
        now["rpm_left"] *= unloaded * (1.0 + half)
        now["rpm_right"] *= unloaded * (1.0 - half)
        self._now = now

    # --- what is recorded -----------------------------------------------------------------------

    def truth(self) -> tuple[float, ...]:
        """Return the truth now, in the order of `TRUTH_CHANNELS`."""
        sticks = self._sticks
        extra = {
            "height": self._now["height"] - self._resting_height,
            "stick_pitch": sticks.pitch,
            "stick_roll": sticks.roll,
            "stick_yaw": sticks.yaw,
            "rate_switch": float(sticks.high_rate),
        }
        values = {**self._now, **extra}
        return tuple(values[name] for name in TRUTH_CHANNELS)

    def instrument_inputs(self) -> tuple[float, ...]:
        """Return the inputs of the instruments, in the order of `INSTRUMENT_INPUT_CHANNELS`."""
        now, sensors = self._now, self._aircraft.sensors
        rates: Vector = (now["p"], now["q"], now["r"])
        spin: Vector = (now["p_dot"], now["q_dot"], now["r_dot"])
        flow: Vector = (now["u"], now["v"], now["w"])
        force: Vector = (now["ax"], now["ay"], now["an"])
        vane, fin = sensors.alpha_vane, sensors.beta_vane
        ax, ay, an = accelerations_at(self._places["accelerometer"], force, rates, spin)
        # Air that turns moves past each place as if the aircraft turned the other way.
        through_air = tuple(now[name] - now[f"gust_{name}"] for name in "pqr")
        turning: Vector = (through_air[0], through_air[1], through_air[2])
        at_probe = velocity_at(self._places["air_data"], flow, turning)
        alpha = beta = 0.0
        if now["V"] > VIRTUAL.vane_friction_speed:
            at_vane = velocity_at(self._places["alpha_vane"], flow, turning)
            at_fin = velocity_at(self._places["beta_vane"], flow, turning)
            alpha = alpha_vane(at_vane, vane.upwash)
            beta = beta_vane(at_fin, fin.kind, fin.upwash)
        de, da, dr = (self._recorded(channel) for channel in ("de", "da", "dr"))
        elevator, aileron = self._rigging
        shown = {
            "V": float(pitot_airspeed(at_probe)),
            "alpha": alpha,
            "beta": beta,
            **dict(zip("pqr", rates, strict=True)),
            "ax": ax,
            "ay": ay,
            "an": an,
        }
        for one, other in self.simulator.model.swapped_channels:
            shown[one], shown[other] = shown[other], shown[one]
        speed = self._through("V", shown["V"])
        return (
            de + elevator,
            de - elevator,
            da + aileron,
            da - aileron,
            dr,
            *(
                self._through(name, shown[name])
                for name in ("alpha", "beta", "p", "q", "r", "ax", "ay", "an")
            ),
            now["static_pressure"],
            self._through("qbar", 0.5 * now["density"] * speed * speed),
            now["temperature"],
            self._sticks.throttle,
            self._through("flap", now["flap"]),
            VIRTUAL.pot_supply - 2e-5 * self._time,
            self._battery(),
            now["rpm_left"],
            now["rpm_right"],
        )

    def _recorded(self, channel: str) -> float:
        kind = getattr(self._aircraft.controls, channel).kind
        name = {"position": channel, "servo": f"{channel}_servo", "command": f"{channel}_command"}
        return self._through(channel, self._now[name[kind]])

    def _through(self, channel: str, value: float) -> float:
        path = self._sensor_paths.get(channel)
        return value if path is None else path.step(value)

    def onboard_values(self) -> tuple[float, ...]:
        """Return what the board knows now, in the order of `ONBOARD_CHANNELS`."""
        now, sticks, conditions = self._now, self._sticks, self._plan.conditions
        situation = self.aircraft_state()
        longitude = situation.east / (EARTH_RADIUS * math.cos(conditions.latitude))
        controls = self._aircraft.controls
        values = {
            **now,
            "phi": self._through("phi", now["phi"] + self._board_tilt[0]),
            "theta": self._through("theta", now["theta"] + self._board_tilt[1]),
            "servo_elevator": now["de_command"] / controls.de.travel[1],
            "servo_aileron": now["da_command"] / controls.da.travel[1],
            "servo_rudder": now["dr_command"] / controls.dr.travel[1],
            "servo_flap": sticks.flap,
            "throttle_command": sticks.throttle,
            "stick_roll": sticks.roll,
            "stick_pitch": sticks.pitch,
            "stick_yaw": sticks.yaw,
            "rate_switch": float(sticks.high_rate),
            "rc_rssi": self._rssi,
            "dynamic_pressure": now["qbar"],
            "latitude": conditions.latitude + situation.north / EARTH_RADIUS,
            "longitude": conditions.longitude + longitude,
            "height": situation.height,
            "elevation": conditions.elevation,
            "velocity_north": situation.velocity_north,
            "velocity_east": situation.velocity_east,
            "cpu_load": 0.31,
            "battery": self._battery(),
            "battery_current": 1.4,
            "battery_remaining": max(0.0, 0.98 - self._time / 5400.0),
            "armed": float(sticks.engines),
        }
        return tuple(values[name] for name in ONBOARD_CHANNELS)

    def _battery(self) -> float:
        return 12.6 - 6e-4 * self._time


def _instrument_positions(model: FlightModel, aircraft: Aircraft) -> dict[str, Vector]:
    """Return where the instruments sit from the CG, m; effects move both once and for all."""
    state = (30.0, *(0.0,) * 8)
    inputs = (*(0.0,) * 6, SEA_LEVEL_DENSITY, aircraft.mass.mass)
    totals = model.evaluate((*state, *model.steady_states(state, inputs)), inputs)
    found = {}
    for name in POSITIONED_INSTRUMENTS:
        position = getattr(aircraft.sensors, name).position
        off = totals.position_offsets.get(name, (0.0, 0.0, 0.0))
        x, y, z = (float(p + d - c) for p, d, c in zip(position, off, totals.cg, strict=True))
        found[name] = (x, y, z)
    return found


def _sensor_paths(simulator: Simulator, dt: float) -> dict[str, SignalPath]:
    """Return the hidden effects of the instruments, by channel."""
    paths = {}
    for channel, effects in simulator.model.sensor_terms.items():
        path = tuple(
            (term, values)
            for term, values in effects
            # What makes all air data late has made the speed late from which qbar follows.
            if not (channel == "qbar" and _of_speed_too(term))
        )
        paths[channel] = SignalPath(path, dt)
    return paths


def _of_speed_too(term: SignalTerm) -> bool:
    return "V" in channels_of_target(term.target.partition(".")[2])
