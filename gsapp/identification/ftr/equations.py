"""The regression equations, sample by sample and without a look ahead.

With m, qbar, V, T measured at every sample, and accelerations moved to the center of gravity,

    qbar C_N = m a_n / S
    qbar C_A = (T - m a_x) / S
    qbar C_Y = m a_y / S
    qbar C_m = [Iyy q' + (Ixx - Izz) p r + Ixz (p^2 - r^2) - z_T T] / (S c)
    qbar C_l = [Ixx p' - Ixz r' - Ixz p q + (Izz - Iyy) q r] / (S b)
    qbar C_n = [Izz r' - Ixz p' + Ixz q r + (Iyy - Ixx) p q - N_T] / (S b)

((8.1.1)-(8.1.6), mended: total variables, products of inertia, thrust.) Each right side is

    static(t) + d/dt spun(t),

`spun` being what multiplies the angular accelerations (the lever arms of the accelerometers add
to it), so that no rate is differentiated in time. Each left side is the sum of derivatives times
``qbar x``. Multiplying by qbar(t), instead of dividing, keeps the derivative of 1/qbar out.
Since qbar(t) is the measured one, the terms in u of the source vanish.

In d(m x)/dt the rate of the mass is left out: 1e-4 of m x' at 1 rad/s.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
import numpy.typing as npt

from gsapp.aircraft import Aircraft
from gsapp.decoding.air_data import density, standard_density
from gsapp.dynamics.atmosphere import SEA_LEVEL_DENSITY
from gsapp.dynamics.propulsion import filter_first_order, thrust
from gsapp.dynamics.sensors import accelerations_at_cg, flow_at_cg
from gsapp.identification.axes import AXIS_COEFFICIENTS
from gsapp.identification.ftr.axis_dynamics import AxisDynamics, build_axis_dynamics
from gsapp.identification.ftr.channels import (
    AIRSPEED_CHANNELS,
    CHANNEL_INDEX,
    FORCE_ACCELEROMETER,
    FTR_CHANNELS,
    OPTIONAL_CHANNELS,
    REQUIRED_CHANNELS,
    ChannelAvailability,
    FTRAxis,
)
from gsapp.identification.ftr.regression_rows import RegressionRows
from gsapp.identification.ftr.settings import FTR_ALGORITHM, FTRSettings
from gsapp.identification.record_preparation import advance_samples, channel_delays
from gsapp.quantities import BoolArray, FloatArray
from gsapp.quantities.constants import GRAVITY


class ThrustAndMassModel:
    """Engines that follow their levers, and the fuel that they burn.

    Parameters
    ----------
    dt : float
        Sample time, s.
    mass : float
        At the start, kg, where there is no channel for it.
    burning : bool
        Whether that mass burns off as the throttle asks.
    """

    def __init__(self, aircraft: Aircraft, dt: float, *, mass: float, burning: bool) -> None:
        self._aircraft, self._dt = aircraft, dt
        self._mass, self._burning = mass, burning
        self.restart()

    def restart(self) -> None:
        self._levers = np.full(2, np.nan)  # throttle and difference, as the engines follow them
        self._burned = np.zeros(1)

    def thrust(
        self, held: FloatArray, rho: FloatArray, V: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return the thrust, and what left exceeds right by in thrust over two."""
        left, right = (
            held[:, CHANNEL_INDEX["throttle_left"]],
            held[:, CHANNEL_INDEX["throttle_right"]],
        )
        lever = np.where(
            np.isfinite(left + right), 0.5 * (left + right), held[:, CHANNEL_INDEX["throttle"]]
        )
        levers = np.stack((lever, 0.5 * (left - right)), axis=1)
        followed = self._follow(levers)
        force = np.asarray(thrust(self._aircraft, followed[:, 0], rho, V), dtype=np.float64)
        side = np.asarray(thrust(self._aircraft, followed[:, 1], rho, V), dtype=np.float64)
        measured = held[:, CHANNEL_INDEX["thrust"]]
        return np.where(np.isfinite(measured), measured, force), side

    def _follow(self, levers: FloatArray) -> FloatArray:
        """Return what the engines make of the levers: first order, settled at the start."""
        lag = self._aircraft.propulsion.lag
        if lag <= 0.0:
            return np.where(np.isfinite(levers), levers, 0.0)
        decay = float(np.exp(-self._dt / lag))
        followed = np.zeros_like(levers)
        for column in range(levers.shape[1]):
            one, state = levers[:, column], float(self._levers[column])
            first = 0
            if np.isnan(state):
                # Settled at the first known position; before that there is no thrust to speak of.
                known = np.flatnonzero(np.isfinite(one))
                if not known.size:
                    continue
                first = int(known[0])
                state = float(one[first])
            followed[first:, column] = filter_first_order(one[first:], decay, state)
            self._levers[column] = followed[-1, column]
        return followed

    def mass(self, held: FloatArray) -> FloatArray:
        """Return the mass at every sample, kg."""
        properties = self._aircraft.mass
        measured = held[:, CHANNEL_INDEX["mass"]]
        if self._burning:
            throttle = np.clip(np.nan_to_num(held[:, CHANNEL_INDEX["throttle"]]), 0.0, 1.0)
            idle, full = properties.fuel_flow_idle, properties.fuel_flow_full
            steps = self._dt * (idle + (full - idle) * throttle)
            burned = np.cumsum(np.concatenate((self._burned, steps)))
            self._burned = burned[-1:].copy()
            burning = self._mass - np.minimum(burned[1:], properties.fuel)
        else:
            burning = np.full(len(held), self._mass)
        return np.where(np.isfinite(measured), measured, burning)

    def state(self) -> dict[str, npt.NDArray[np.generic]]:
        return {"levers": self._levers, "burned": self._burned}

    def restore(self, state: Mapping[str, npt.NDArray[np.generic]]) -> None:
        self._levers = np.array(state["levers"], dtype=np.float64)
        self._burned = np.array(state["burned"], dtype=np.float64)


class AirDataComputer:
    """The air that the aircraft flies in, and its height above the last ground.

    Parameters
    ----------
    speed : float or None
        Airspeed that stands in where none is measured, m/s.
    dt : float
        Sample time, s.
    """

    def __init__(self, speed: float | None, dt: float) -> None:
        self._speed, self._dt = speed, dt
        self.restart()

    def restart(self) -> None:
        self._pressures = np.full(2, np.nan)  # static, smoothed: now, and on the ground

    def air(
        self, values: FloatArray, held: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return density, airspeed and dynamic pressure; NaN where there is none."""

        def one(name: str) -> FloatArray:
            return values[:, CHANNEL_INDEX[name]]

        def slow(name: str) -> FloatArray:
            return held[:, CHANNEL_INDEX[name]]

        with np.errstate(divide="ignore", invalid="ignore"):
            V, qbar = one("V"), one("qbar")
            qbar = np.where(np.isfinite(qbar), qbar, one("dynamic_pressure"))
            rho = slow("density")
            if not np.isfinite(rho).all():
                static = slow("static_pressure")
                rho = _first_finite(
                    rho,
                    density(static, slow("temperature")),
                    standard_density(static),
                    2.0 * qbar / (V * V),
                )
            # A density off by more than a factor of two is no air: take that of sea level.
            sound = (rho > 0.3) & (rho < 2.0)
            rho = np.where(sound, rho, SEA_LEVEL_DENSITY)
            if self._speed is not None:
                known = np.isfinite(V) | np.isfinite(qbar)
                V = np.where(known, V, self._speed)
            V = np.where(np.isfinite(V), V, np.sqrt(2.0 * np.maximum(qbar, 0.0) / rho))
            qbar = np.where(np.isfinite(qbar), qbar, 0.5 * rho * V * V)
        return rho, V, qbar

    def is_clear_of_ground(
        self, static: FloatArray, rho: FloatArray, standing: BoolArray
    ) -> BoolArray:
        """Return where the wheels are well above the place where the aircraft last stood.

        Everywhere if static pressure is not measured, or the aircraft was never seen on the
        ground.
        """
        smooth = self._smoothed(static, np.isfinite(static), 0)
        ground = self._smoothed(static, np.isfinite(static) & standing, 1)
        with np.errstate(invalid="ignore"):
            return np.asarray(
                ~(ground - smooth < FTR_ALGORITHM.min_ground_clearance * GRAVITY * rho)
            )

    def _smoothed(self, signal: FloatArray, chosen: BoolArray, place: int) -> FloatArray:
        """Return a first-order smoothing of chosen samples, held in between."""
        state = float(self._pressures[place])
        picked = signal[chosen]
        if not picked.size:
            return np.full(signal.size, state)
        first = float(picked[0]) if np.isnan(state) else state
        decay = float(np.exp(-self._dt / FTR_ALGORITHM.pressure_time_constant))
        smooth = filter_first_order(picked, decay, first)
        self._pressures[place] = smooth[-1]
        return np.concatenate(([state], smooth))[np.cumsum(chosen)]

    def state(self) -> dict[str, npt.NDArray[np.generic]]:
        return {"pressures": self._pressures}

    def restore(self, state: Mapping[str, npt.NDArray[np.generic]]) -> None:
        self._pressures = np.array(state["pressures"], dtype=np.float64)


def _first_finite(*candidates: FloatArray) -> FloatArray:
    found = candidates[0]
    for other in candidates[1:]:
        found = np.where(np.isfinite(found), found, other)
    return found


class RegressionEquations:
    """Turns rows of channels into rows of the regressions; keeps what must be remembered.

    Parameters
    ----------
    dt : float
        Sample time, s.
    measured : collection of str, optional
        Channels that are known to be measured; by default that shows as the flight goes on.
    mass : float, optional
        At the start, kg, where there is no channel for it; the aircraft file's by default.
    burning : bool
        Whether that mass burns off as the throttle asks.
    aligned : bool
        Whether late channels were brought to their right time already.

    Attributes
    ----------
    ahead : int
        Rows that are needed beyond the last one.
    """

    def __init__(
        self,
        aircraft: Aircraft,
        settings: FTRSettings,
        dt: float,
        axes: Iterable[FTRAxis],
        *,
        measured: Iterable[str] | None = None,
        mass: float | None = None,
        burning: bool = True,
        aligned: bool = False,
    ) -> None:
        self.aircraft, self.settings = aircraft, settings
        self.axes = tuple(axes)
        self._mass = aircraft.mass.mass if mass is None else mass
        self._hearing = ChannelAvailability(settings, dt, measured)
        self._air = AirDataComputer(settings.speed, dt)
        self._engines = ThrustAndMassModel(aircraft, dt, mass=self._mass, burning=burning)
        stall = aircraft.limits.stall_speed
        slow = settings.minimum_speed
        self._slowest = FTR_ALGORITHM.min_speed_ratio * stall if slow is None else slow
        positions = aircraft.propulsion.position
        count = max(len(positions), 1)
        self._height = sum(z for _, _, z in positions) / count
        self._sideways = sum(abs(y) for _, y, _ in positions) / count
        self._limits = _instrument_limits(aircraft)
        late = {} if aligned else channel_delays(aircraft)
        self._late = {name: late[name] / dt for name in FTR_CHANNELS if name in late}
        # Channels that are equally late go together.
        self._later: dict[float, list[int]] = {}
        for name, steps in self._late.items():
            self._later.setdefault(steps, []).append(CHANNEL_INDEX[name])
        # The interpolation reaches two samples beyond the time asked for.
        self.ahead = int(max(self._later, default=-2.0)) + 2

    def restart(self) -> None:
        for part in (self._hearing, self._air, self._engines):
            part.restart()

    # --- rows -----------------------------------------------------------------------------------

    def rows(self, values: FloatArray) -> dict[FTRAxis, RegressionRows]:
        """Return the regressions' rows of consecutive samples.

        `values`, shape (1 + n + ahead, number of `FTR_CHANNELS`): SI, NaN where missing; the row
        before the first comes first.
        """
        values = self._in_time(self._unclipped(values))
        finite = np.isfinite(values)
        alive = self._hearing.available(finite)
        held = self._hearing.hold(values, finite)
        known = np.where(finite.T, values.T, 0.0)

        def signal(name: str) -> FloatArray:
            return np.asarray(known[CHANNEL_INDEX[name]], dtype=np.float64)

        rho, V, qbar = self._air.air(values, held)
        flying = np.isfinite(V) & np.isfinite(qbar)
        V = np.where(flying, V, 30.0)
        qbar = np.where(flying, qbar, 1.0)
        calibrated = V * np.sqrt(rho / SEA_LEVEL_DENSITY)
        if self._slowest > 0.0:
            standing = flying & (calibrated < FTR_ALGORITHM.ground_speed_share * self._slowest)
            flying &= self._air.is_clear_of_ground(
                values[:, CHANNEL_INDEX["static_pressure"]], rho, standing
            )
        flying &= calibrated >= max(self._slowest, 1.0)
        V = np.where(flying, V, 30.0)
        p, q, r = rates = signal("p"), signal("q"), signal("r")
        shown = V
        V, alpha, beta = (
            np.asarray(one, dtype=np.float64)
            for one in flow_at_cg(self.aircraft, V, signal("alpha"), signal("beta"), rates)
        )
        qbar = qbar * (V / shown) ** 2
        force, side = self._engines.thrust(held, rho, V)
        mass = self._engines.mass(held)

        geometry, body = self.aircraft.geometry, self.aircraft.mass
        place = self.aircraft.sensors.accelerometer.position
        still = (0.0, 0.0, 0.0)
        measured = (signal("ax"), signal("ay"), signal("an"))
        ax, ay, an = accelerations_at_cg(place, measured, rates, still)
        ax_spun, ay_spun, an_spun = accelerations_at_cg(place, still, still, rates)
        weight = mass / geometry.wing_area
        out: dict[FTRAxis, RegressionRows] = {}
        if "lon" in self.axes:
            moment = 1.0 / (geometry.wing_area * geometry.chord)
            pitch = (body.ixx - body.izz) * p * r + body.ixz * (p * p - r * r)
            longitudinal: tuple[FloatArray, ...] = (
                qbar * alpha,
                qbar * q * (0.5 * geometry.chord) / V,
                qbar * signal("de"),
                weight * an,
                force / geometry.wing_area - weight * ax,
                moment * (pitch - self._height * force),
                qbar,
                weight * an_spun,
                -weight * ax_spun,
                moment * body.iyy * q,
                qbar * (0.5 * geometry.chord) / V,
                qbar * signal("alpha") / self.aircraft.sensors.alpha_vane.upwash,
            )
            out["lon"] = self._pack("lon", longitudinal, finite, alive, flying)
        if "lat" in self.axes:
            moment = 1.0 / (geometry.wing_area * geometry.span)
            turn = 0.5 * geometry.span / V
            roll = (body.izz - body.iyy) * q * r - body.ixz * p * q
            yaw = body.ixz * q * r + (body.iyy - body.ixx) * p * q
            lateral: tuple[FloatArray, ...] = (
                qbar * beta,
                qbar * p * turn,
                qbar * r * turn,
                qbar * signal("da"),
                qbar * signal("dr"),
                weight * ay,
                moment * roll,
                moment * (yaw - self._sideways * side),
                qbar,
                weight * ay_spun,
                moment * (body.ixx * p - body.ixz * r),
                moment * (body.izz * r - body.ixz * p),
                qbar * turn,
                qbar * signal("beta") / self.aircraft.sensors.beta_vane.upwash,
            )
            out["lat"] = self._pack("lat", lateral, finite, alive, flying)
        return out

    def _pack(
        self,
        axis: FTRAxis,
        columns: tuple[FloatArray, ...],
        finite: BoolArray,
        alive: BoolArray,
        flying: BoolArray,
    ) -> RegressionRows:
        valid, ever = flying.copy(), self._hearing.ever_measured
        speaks = np.full(valid.size, self.settings.speed is not None)
        for name in AIRSPEED_CHANNELS:
            speaks |= alive[:, CHANNEL_INDEX[name]]
        for name in REQUIRED_CHANNELS[axis]:
            place = CHANNEL_INDEX[name]
            # A surface that stands still may do without an instrument.
            spared = ~ever[:, place] if name in self.settings.still else False
            valid &= finite[:, place] | spared
            speaks &= alive[:, place] | spared
        # What may be missing altogether still interrupts while it only pauses.
        own = [FORCE_ACCELEROMETER.get(name) for name in AXIS_COEFFICIENTS[axis]]
        for name in (*OPTIONAL_CHANNELS[axis], *(one for one in own if one is not None)):
            valid &= finite[:, CHANNEL_INDEX[name]] | ~alive[:, CHANNEL_INDEX[name]]
        running = np.empty((valid.size, 3), dtype=bool)
        for index, one in enumerate(own):
            running[:, index] = speaks if one is None else speaks & alive[:, CHANNEL_INDEX[one]]
        stacked = np.stack(columns, axis=1)
        stacked[~valid] = 0.0
        return RegressionRows(valid=valid, columns=stacked, running=running)

    def _unclipped(self, values: FloatArray) -> FloatArray:
        low, high = self._limits
        with np.errstate(invalid="ignore"):
            return np.where((values <= low) | (values >= high), np.nan, values)

    def _in_time(self, values: FloatArray) -> FloatArray:
        """Return the n rows with late channels as they were at each row's time."""
        own = values[1 : len(values) - self.ahead].copy()
        for steps, places in self._later.items():
            own[:, places] = advance_samples(values[:, places], steps)[1 : 1 + len(own)]
        return own

    def axis_dynamics(self, axis: FTRAxis) -> AxisDynamics:
        """Return how the rates of an axis answer to its moments."""
        return build_axis_dynamics(
            self.aircraft,
            axis,
            mass=self._mass,
            accelerometer_offset=self.settings.accelerometer_offset,
            late=self._late,
        )

    def missing_reasons(self, axis: FTRAxis) -> dict[str, str]:
        """Return, for each coefficient that cannot be had now, why, in words."""
        return self._hearing.missing_reasons(axis)

    def remarks(self) -> tuple[str, ...]:
        """Return what stands in for what, in words."""
        return self._hearing.remarks(self.aircraft, self.axes)

    def state(self) -> dict[str, npt.NDArray[np.generic]]:
        return {**self._hearing.state(), **self._air.state(), **self._engines.state()}

    def restore(self, state: Mapping[str, npt.NDArray[np.generic]]) -> None:
        for part in (self._hearing, self._air, self._engines):
            part.restore(state)


def _instrument_limits(aircraft: Aircraft) -> tuple[FloatArray, FloatArray]:
    """Return, by channel, where an instrument counts as clipped (1 % from the ends)."""
    low = np.full(len(FTR_CHANNELS), -np.inf)
    high = np.full(len(FTR_CHANNELS), np.inf)
    for name, instrument in aircraft.sensors.by_channel.items():
        bottom, top = instrument.range
        margin = 0.01 * (top - bottom)
        low[CHANNEL_INDEX[name]], high[CHANNEL_INDEX[name]] = bottom + margin, top - margin
    return low, high
