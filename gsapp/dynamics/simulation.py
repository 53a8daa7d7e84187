"""Simulation in time: the whole aircraft, step by step.

`Simulator` integrates the body-axis form with a quaternion and Runge-Kutta steps of fixed length
in plain floats: over the ground, in wind and gusts, on its wheels, with fuel burning off. Servos,
engines and gusts are stepped exactly once per sample and taken as straight lines in between.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from gsapp.aircraft import Aircraft
from gsapp.dynamics.actuators import ControlPosition, create_actuators
from gsapp.dynamics.arithmetic import Value
from gsapp.dynamics.atmosphere import (
    SEA_LEVEL_DENSITY,
    Atmosphere,
    DrydenTurbulence,
    Wind,
    pressure_altitude,
)
from gsapp.dynamics.effect_terms import StallDepartureTerm
from gsapp.dynamics.equations import (
    Loads,
    Matrix,
    angular_accelerations,
    body_from_polar,
    body_rates,
    body_to_earth_matrix,
    euler_from_quaternion,
    quaternion_from_euler,
    quaternion_rates,
)
from gsapp.dynamics.flight_model import FlightModel, ModelEvaluation
from gsapp.dynamics.model import Model
from gsapp.dynamics.propulsion import Engines, EngineState
from gsapp.dynamics.settings import SIMULATION
from gsapp.dynamics.terms import Parameter, Term
from gsapp.foundation import FlightError
from gsapp.quantities.constants import GRAVITY

Vector3 = tuple[float, float, float]
_NO_LOADS = Loads(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class ControlCommands:
    """What the receiver asks of the aircraft during one sample."""

    de: float = 0.0
    da: float = 0.0
    dr: float = 0.0
    flap: float = 0.0
    """Deflections asked for, rad."""
    throttle: float = 0.0  # Of both engines, 0 to 1.
    throttle_left: float | None = None
    throttle_right: float | None = None
    """Of one engine, where they differ."""
    steer: float = 0.0  # Nose wheel, -1 to 1, positive right.
    brake: float = 0.0  # 0 to 1.
    engines: bool = True  # Whether the engines run.


class GroundContact(Protocol):
    """Whatever pushes back from below, such as a landing gear."""

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
        """Return the loads on the aircraft about its CG, and whether weight is on the wheels.

        `down` is the depth of the CG below the runway (negative above it), m; `velocity` is over
        the ground along the body axes, m/s; `rates` p, q, r, rad/s; `matrix` body to Earth, row by
        row; `steer` and `brake` as commanded.
        """


def stall_terms(aircraft: Aircraft, model: Model) -> tuple[Term, ...]:
    """Return what the virtual aircraft does beyond the linear range; exactly zero within it.

    The lift departs with a slope a little steeper than that of the linear model, so that the
    normal force levels off and falls slowly: 61 ft/s for the shipped B777. A model whose lift
    stalls by itself needs nothing: its flow does not separate twice.
    """
    present = {effect.id for effect in model.effects}
    if "aero.CN.stall" in present:
        return ()
    low, high = aircraft.limits.alpha_linear
    limit = (-math.pi / 2.0, math.pi / 2.0)

    def departure(target: str, slope: float, *, even: bool = False) -> Term:
        values = {"slope": slope, "width": 0.06, "alpha_low": low, "alpha_high": high}
        return StallDepartureTerm(
            id=f"aero.{target}.stall",
            title="Stall",
            equation=f"{target} += slope e^2/(|e| + width), e = alpha beyond the linear range",
            target=target,
            reads=("alpha",),
            even=even,
            parameters=tuple(
                Parameter(name, "", value, limit, name) for name, value in values.items()
            ),
        )

    found = (
        departure("CN", -1.04 * model.derivative("CN_alpha")),
        departure("CA", 1.6, even=True),
        departure("Cm", -0.6),
    )
    return tuple(one for one in found if one.id not in present)


@dataclass(slots=True)
class _Excitation:
    """What acts on the aircraft at one instant beside its own motion."""

    surfaces: tuple[float, ...]
    throttle: float
    difference: float
    gust: tuple[float, ...]
    rotation: tuple[float, ...]  # Of the air, p, q, r.

    def halfway(self, other: _Excitation) -> _Excitation:
        return _Excitation(
            _mean(self.surfaces, other.surfaces),
            0.5 * (self.throttle + other.throttle),
            0.5 * (self.difference + other.difference),
            _mean(self.gust, other.gust),
            _mean(self.rotation, other.rotation),
        )


def _mean(one: tuple[float, ...], two: tuple[float, ...]) -> tuple[float, ...]:
    return tuple([0.5 * (x + y) for x, y in zip(one, two, strict=True)])


@dataclass(slots=True)
class _Instant:
    """Everything computed at one instant; `slope` is the rate of the state."""

    slope: list[float]
    totals: ModelEvaluation
    air: Vector3
    polar: tuple[float, ...]
    matrix: Matrix
    force: Vector3
    ground: Loads
    on_ground: bool
    scale: float


class Simulator:
    """One aircraft in the air or on the ground.

    Call `start_in_air` or `start_on_ground`, then `step` for every sample and `sample` for the
    truth at that instant.

    Parameters
    ----------
    model : Model
        The truth: derivatives and effects, those of control paths included. Effects of
        instruments are applied by whoever measures (`gsapp.dynamics.sensors`).
    atmosphere : Atmosphere
        Of the day; its ground is the runway.
    ground : GroundContact or None
        None lets the aircraft fall through.
    stall : bool
        Whether it stalls beyond the linear range; within it, nothing changes.
    dt : float
        Step, s.
    """

    def __init__(
        self,
        aircraft: Aircraft,
        model: Model,
        *,
        atmosphere: Atmosphere | None = None,
        wind: Wind | None = None,
        turbulence: DrydenTurbulence | None = None,
        ground: GroundContact | None = None,
        stall: bool = True,
        dt: float = 0.01,
    ) -> None:
        self.aircraft = aircraft
        self.atmosphere = atmosphere or Atmosphere()
        self.wind = wind or Wind()
        self.turbulence = turbulence
        self.ground = ground
        self.dt = dt
        self._widest = SIMULATION.max_flow_angles if stall else (math.pi, math.pi)
        extra = stall_terms(aircraft, model) if stall else ()
        self.model = FlightModel(aircraft, model, extra=extra)
        self.time = 0.0
        self.start_in_air(V=30.0)

    # --- starting -------------------------------------------------------------------------------

    def start_in_air(
        self,
        *,
        V: float,
        alpha: float = 0.0,
        beta: float = 0.0,
        rates: Vector3 = (0.0, 0.0, 0.0),
        attitude: Vector3 = (0.0, 0.0, 0.0),
        height: float = 100.0,
        position: tuple[float, float] = (0.0, 0.0),
        commands: ControlCommands | None = None,
        fuel: float | None = None,
    ) -> None:
        """Begin in flight, with servos and engines settled at `commands`, all zero by default.

        V, alpha, beta are relative to the air, m/s and rad; `rates` p, q, r, rad/s; `attitude` phi,
        theta, psi, rad; `height` of the CG above the runway, `position` north and east, m; `fuel`
        on board, kg, the aircraft file's by default.
        """
        quaternion = quaternion_from_euler(*(float(angle) for angle in attitude))
        u, v, w = (float(x) for x in body_from_polar(float(V), float(alpha), float(beta)))
        wind = _to_body(body_to_earth_matrix(quaternion), self.wind.at(height))
        velocity = (u + wind[0], v + wind[1], w + wind[2])
        self._begin(velocity, rates, quaternion, (*position, -height), commands, fuel)

    def start_on_ground(
        self,
        *,
        heading: float = 0.0,
        height: float = 0.5,
        position: tuple[float, float] = (0.0, 0.0),
        commands: ControlCommands | None = None,
    ) -> None:
        """Begin at rest on the wheels, with the CG at `height` (m) above the runway."""
        quaternion = quaternion_from_euler(0.0, 0.0, float(heading))
        zero = (0.0, 0.0, 0.0)
        self._begin(zero, zero, quaternion, (*position, -height), commands, None)

    def _begin(
        self,
        velocity: Vector3,
        rates: Vector3,
        quaternion: tuple[float, float, float, float],
        position: Vector3,
        commands: ControlCommands | None,
        fuel: float | None,
    ) -> None:
        commands = commands or ControlCommands()
        self.time = 0.0
        self.commands = commands
        self.fuel = self.aircraft.mass.fuel if fuel is None else fuel
        self._actuators = create_actuators(self.model, self.dt)
        self._controls = self._move(commands)
        mean = _throttle_levers(commands)
        self._engines = Engines(
            self.aircraft, self.dt, throttle=0.5 * sum(mean), running=commands.engines
        )
        self._engine: EngineState = self._engines.state
        self._drive = self._driven()
        self._state: list[float] = [float(x) for x in (*velocity, *rates, *quaternion, *position)]
        self._instant: _Instant | None = None
        if len(self.model.state_names) > 9:
            polar = self._polar(velocity, self._state, self._drive.rotation)
            settled = self.model.steady_states(polar, self._inputs(self._drive))
            self._state += [float(x) for x in settled]

    # --- stepping -------------------------------------------------------------------------------

    def step(self, commands: ControlCommands) -> None:
        """Go on by one step under these commands.

        Raise FlightError if the motion has grown beyond all bounds.
        """
        now = self._at_this_instant()
        dt, state = self.dt, self._state
        self.commands = commands
        self._controls = self._move(commands)
        running = commands.engines and (self.fuel > 0.0 or self.aircraft.mass.fuel == 0.0)
        self._engine = self._engines.step(*_throttle_levers(commands), running=running)
        speed = math.sqrt(sum(x * x for x in now.air))
        if self.turbulence:
            self.turbulence.advance(dt, speed)
        before, after = self._drive, self._driven()
        middle = before.halfway(after)
        k1 = now.slope
        k2 = self._slope([x + 0.5 * dt * k for x, k in zip(state, k1, strict=True)], middle)
        k3 = self._slope([x + 0.5 * dt * k for x, k in zip(state, k2, strict=True)], middle)
        k4 = self._slope([x + dt * k for x, k in zip(state, k3, strict=True)], after)
        sixth = dt / 6.0
        moved = [
            x + sixth * (a + 2.0 * (b + c) + d)
            for x, a, b, c, d in zip(state, k1, k2, k3, k4, strict=True)
        ]
        length = math.sqrt(moved[6] ** 2 + moved[7] ** 2 + moved[8] ** 2 + moved[9] ** 2)
        moved[6:10] = [x / length for x in moved[6:10]] if length > 0.0 else [math.nan] * 4
        if not all(map(math.isfinite, moved)) or abs(moved[0]) > 1e4:
            raise FlightError(
                f"the simulated motion diverged at {self.time:.2f} s; the model "
                f"'{self.model.model.name}' is unstable there: check the signs of its "
                "derivatives"
            )
        self._state = moved
        self._drive = after
        self.fuel = max(self.fuel - self._engine.fuel_flow * dt, 0.0)
        self.time += dt
        self._instant = None

    def _move(self, commands: ControlCommands) -> dict[str, ControlPosition]:
        return {
            name: actuator.step(getattr(commands, name))
            for name, actuator in self._actuators.items()
        }

    def _driven(self) -> _Excitation:
        still = (0.0, 0.0, 0.0)
        return _Excitation(
            tuple(position.surface for position in self._controls.values()),
            self._engine.throttle,
            self._engine.difference,
            self.turbulence.gust if self.turbulence else still,
            self.turbulence.rotation if self.turbulence else still,
        )

    @property
    def mass(self) -> float:
        return self.aircraft.mass.mass - self.aircraft.mass.fuel + self.fuel

    def _inputs(self, drive: _Excitation) -> tuple[float, ...]:
        altitude = self.atmosphere.ground_altitude - self._state[12]
        rho = float(self.atmosphere.density(altitude))
        return (*drive.surfaces, drive.throttle, drive.difference, rho, self.mass)

    def _polar(
        self, air: Sequence[float], state: Sequence[float], rotation: Sequence[float]
    ) -> tuple[float, ...]:
        """Return the state as the air acts on it: relative to the air, its rotation included."""
        u, v, w = air
        forward = math.sqrt(u * u + w * w)
        V = math.sqrt(forward * forward + v * v)
        quaternion = (state[6], state[7], state[8], state[9])
        return (
            max(V, SIMULATION.min_speed),
            math.atan2(w, u) if V > 0.0 else 0.0,
            math.atan2(v, forward) if V > 0.0 else 0.0,
            state[3] - rotation[0],
            state[4] - rotation[1],
            state[5] - rotation[2],
            *euler_from_quaternion(quaternion),
            *state[13:],
        )

    def _within(self, polar: tuple[float, ...]) -> tuple[float, ...]:
        """Return the polar state with flow angles at which coefficients mean something."""
        alpha, beta = self._widest
        if abs(polar[1]) <= alpha and abs(polar[2]) <= beta:
            return polar
        held = (min(max(polar[1], -alpha), alpha), min(max(polar[2], -beta), beta))
        return (polar[0], *held, *polar[3:])

    def _slope(self, state: list[float], drive: _Excitation) -> list[float]:
        return self._evaluate(state, drive).slope

    def _evaluate(self, state: list[float], drive: _Excitation) -> _Instant:
        u, v, w, p, q, r, e0, e1, e2, e3, _, _, down = state[:13]
        attitude = (e0, e1, e2, e3)
        matrix = body_to_earth_matrix(attitude)
        wind = _to_body(matrix, self.wind.at(-down))
        gust = drive.gust
        air = (u - wind[0] - gust[0], v - wind[1] - gust[1], w - wind[2] - gust[2])
        polar = self._polar(air, state, drive.rotation)
        totals = self.model.evaluate(self._within(polar), self._inputs(drive))
        loads, body = totals.loads, totals.body
        scale = 1.0
        speed2 = air[0] ** 2 + air[1] ** 2 + air[2] ** 2
        if speed2 < SIMULATION.min_speed * SIMULATION.min_speed:
            scale = speed2 / (SIMULATION.min_speed * SIMULATION.min_speed)
            loads = _fade_loads(loads, totals.thrust, scale)
        ground, on_ground = _NO_LOADS, False
        if self.ground is not None:
            ground, on_ground = self.ground.loads(
                down, (u, v, w), (p, q, r), matrix,
                steer=self.commands.steer, brake=self.commands.brake,
            )  # fmt: skip
        fx, fy, fz = loads.X + ground.X, loads.Y + ground.Y, loads.Z + ground.Z
        spin = angular_accelerations(
            p, q, r, loads.L + ground.L, loads.M + ground.M, loads.N + ground.N, body
        )
        gravity = (GRAVITY * matrix[6], GRAVITY * matrix[7], GRAVITY * matrix[8])
        slope = [
            *body_rates((u, v, w), (p, q, r), (fx, fy, fz), gravity, body.mass),
            *spin,
            *quaternion_rates(attitude, p, q, r),
            matrix[0] * u + matrix[1] * v + matrix[2] * w,
            matrix[3] * u + matrix[4] * v + matrix[5] * w,
            matrix[6] * u + matrix[7] * v + matrix[8] * w,
            *totals.term_rates,
        ]
        return _Instant(
            slope,  # type: ignore[arg-type]
            totals, air, polar, matrix, (fx, fy, fz),  # type: ignore[arg-type]
            ground, on_ground, scale,
        )  # fmt: skip

    def _at_this_instant(self) -> _Instant:
        if self._instant is None:
            self._instant = self._evaluate(self._state, self._drive)
        return self._instant

    # --- truth ----------------------------------------------------------------------------------

    @property
    def on_ground(self) -> bool:
        return self._at_this_instant().on_ground

    def sample(self) -> dict[str, float]:
        """Return the truth at this instant, SI and radians.

        Channels of the vocabulary keep their ids (at the CG, without any instrument). Beside
        them: ``V_dot alpha_dot beta_dot p_dot q_dot r_dot``; loads ``X Y Z L M N`` without those
        of the ground; coefficients ``CN CA CY Cl Cm Cn``; ``de_servo da_servo dr_servo``; gusts
        ``gust_u gust_v gust_w`` and rotation of the air ``gust_p gust_q gust_r``; ``u v w``
        relative to the air; ``cg_x cg_y cg_z``, where the CG lies from the aircraft file's (an
        effect may move it: positions of instruments count from there); ``on_ground`` (0 or 1).
        """
        now = self._at_this_instant()
        state, drive = self._state, self._drive
        u, v, w = now.air
        V = math.sqrt(u * u + v * v + w * w)
        mass = float(now.totals.body.mass)
        height = -state[12]
        air = self.atmosphere.at(self.atmosphere.ground_altitude + height)
        rho = float(air.density)
        north, east, down = now.slope[10:13]
        # Steady wind: the rates of the air-relative velocity are those of the inertial one.
        wind = self.wind.at(height)
        u_dot, v_dot, w_dot = _air_acceleration(now, state)
        V_safe, flat2 = max(V, 1e-6), max(u * u + w * w, 1e-12)
        flat = math.sqrt(flat2)
        V_dot = (u * u_dot + v * v_dot + w * w_dot) / V_safe
        pressure = float(air.pressure)
        loads = now.totals.loads
        controls, engine = self._controls, self._engine
        values = {
            "time": self.time,
            "V": V,
            "Vc": V * math.sqrt(rho / SEA_LEVEL_DENSITY),
            "alpha": now.polar[1],
            "beta": now.polar[2],
            "p": state[3],
            "q": state[4],
            "r": state[5],
            "phi": now.polar[6],
            "theta": now.polar[7],
            "psi": now.polar[8],
            "ax": now.force[0] / mass,
            "ay": now.force[1] / mass,
            "an": -now.force[2] / mass,
            "qbar": 0.5 * rho * V * V,
            "density": rho,
            "static_pressure": pressure,
            "temperature": float(air.temperature),
            "height": height,
            "altitude": float(pressure_altitude(pressure)),
            "climb_rate": -down,
            "north": state[10],
            "east": state[11],
            "ground_speed": math.hypot(north, east),
            "track": math.atan2(east, north),
            "wind_north": wind[0],
            "wind_east": wind[1],
            "throttle": engine.throttle,
            "throttle_left": engine.left,
            "throttle_right": engine.right,
            "rpm_left": engine.rpm_left,
            "rpm_right": engine.rpm_right,
            "thrust": float(now.totals.thrust),
            "fuel": self.fuel,
            "mass": mass,
            "flap": drive.surfaces[3],
            "u": u,
            "v": v,
            "w": w,
            "V_dot": V_dot,
            "alpha_dot": (u * w_dot - w * u_dot) / flat2,
            "beta_dot": (v_dot * V - v * V_dot) / (V_safe * flat),
            "p_dot": now.slope[3],
            "q_dot": now.slope[4],
            "r_dot": now.slope[5],
            "gust_u": drive.gust[0],
            "gust_v": drive.gust[1],
            "gust_w": drive.gust[2],
            "gust_p": drive.rotation[0],
            "gust_q": drive.rotation[1],
            "gust_r": drive.rotation[2],
            "cg_x": float(now.totals.cg[0]),
            "cg_y": float(now.totals.cg[1]),
            "cg_z": float(now.totals.cg[2]),
            "on_ground": 1.0 if now.on_ground else 0.0,
        }
        for name in ("de", "da", "dr"):
            position = controls[name]
            values[name] = position.surface
            values[f"{name}_servo"] = position.servo
            values[f"{name}_command"] = position.command
        values.update(zip(loads._fields, (float(x) for x in loads), strict=True))
        values.update({name: float(x) for name, x in now.totals.coefficients.items()})
        return values


def _throttle_levers(commands: ControlCommands) -> tuple[float, float]:
    left, right = commands.throttle_left, commands.throttle_right
    return (
        commands.throttle if left is None else left,
        commands.throttle if right is None else right,
    )


def _to_body(matrix: Matrix, earth: Vector3) -> Vector3:
    north, east, down = earth
    return (
        matrix[0] * north + matrix[3] * east + matrix[6] * down,
        matrix[1] * north + matrix[4] * east + matrix[7] * down,
        matrix[2] * north + matrix[5] * east + matrix[8] * down,
    )


def _fade_loads(loads: Loads, thrust: Value, scale: float) -> Loads:
    """Return the loads with all but the thrust faded out at hardly any airspeed."""
    return Loads(
        thrust + scale * (loads.X - thrust),
        scale * loads.Y,
        scale * loads.Z,
        scale * loads.L,
        scale * loads.M,
        scale * loads.N,
    )


def _air_acceleration(now: _Instant, state: Sequence[float]) -> Vector3:
    """Return the rates of u, v, w relative to air that moves steadily."""
    u, v, w = now.air
    ground = state[:3]
    p, q, r = state[3:6]
    wind = (ground[0] - u, ground[1] - v, ground[2] - w)
    # The steady wind turns in body axes as the body turns.
    return (
        now.slope[0] - (r * wind[1] - q * wind[2]),
        now.slope[1] - (p * wind[2] - r * wind[0]),
        now.slope[2] - (q * wind[0] - p * wind[1]),
    )
