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

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt
from scipy.signal import lfilter

from gsapp.aircraft import Aircraft
from gsapp.decoding.air_data import density, standard_density
from gsapp.dynamics.atmosphere import SEA_LEVEL_DENSITY
from gsapp.dynamics.buildup import reads_of
from gsapp.dynamics.propulsion import thrust
from gsapp.dynamics.sensors import accelerations_at_cg, flow_at_cg
from gsapp.identification.alignment import advanced, lateness
from gsapp.identification.axes import COEFFICIENTS, SURFACES
from gsapp.identification.ftr.settings import FTRSettings
from gsapp.quantities import BoolArray, FloatArray
from gsapp.quantities.constants import GRAVITY

FTRAxis = Literal["lon", "lat"]

NEEDED_CHANNELS = (
    "V", "qbar", "dynamic_pressure", "alpha", "beta", "p", "q", "r", "ax", "ay", "an",
    "de", "da", "dr", "throttle", "throttle_left", "throttle_right", "thrust",
    "density", "static_pressure", "temperature", "mass",
)  # fmt: skip
"""Channels that the equations may use."""
_PLACE = {name: place for place, name in enumerate(NEEDED_CHANNELS)}

RUNWAY = 1.25
"""Speed over the stall speed below which wheels may touch the ground."""
CLEARANCE = 5.0
"""Height above the place of take-off below which wheels may touch the ground, m."""
STANDING = 0.5
"""Share of the lowest speed that counts, below which the aircraft stands or rolls."""
SMOOTHING = 0.5
"""Time constant of the smoothing of static pressure, s."""
SILENCE = 0.5
"""Seconds without a sample after which a channel counts as not measured."""

_REQUIRED: Mapping[FTRAxis, tuple[str, ...]] = {
    "lon": ("alpha", "q", "de"),
    "lat": ("beta", "p", "r", "da", "dr"),
}
_OPTIONAL: Mapping[FTRAxis, tuple[str, ...]] = {"lon": ("p", "r", "beta"), "lat": ("q", "alpha")}
_OWN = {"CN": "an", "CA": "ax", "CY": "ay"}
_PITOT = ("V", "qbar", "dynamic_pressure")


def axis_regressors(axis: FTRAxis) -> tuple[str, ...]:
    """Return the suffixes of the derivatives of one axis: ``alpha q de`` or ``beta p r da dr``."""
    return tuple(reads_of(COEFFICIENTS[axis][0]))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class AxisRows:
    """What one axis needs of some consecutive samples.

    Attributes
    ----------
    valid : ndarray of bool, shape (n,)
        Samples that count.
    columns : ndarray, shape (n, p + 1 + 3 + 3 + 2)
        qbar x for every regressor; qbar; the three static parts; the three spun parts; what makes
        qbar x of a rate (qbar c/2V or qbar b/2V); the first of qbar x as the vane shows it, not
        moved to the CG. Zero where not valid.
    running : ndarray of bool, shape (n, 3)
        Equations all of whose instruments spoke of late.
    """

    valid: BoolArray
    columns: FloatArray
    running: BoolArray

    def part(self, place: int) -> AxisRows:
        """Return one of the blocks that the rows are cut into."""
        one = slice(place, place + 1)
        return AxisRows(valid=self.valid[one], columns=self.columns[one], running=self.running[one])

    def first_blocks(self, count: int) -> AxisRows:
        """Return the first of the blocks that the rows are cut into."""
        few = slice(0, max(count, 0))
        return AxisRows(valid=self.valid[few], columns=self.columns[few], running=self.running[few])

    @staticmethod
    def joined(parts: Sequence[AxisRows]) -> AxisRows:
        """Return rows one after the other."""
        return AxisRows(
            valid=np.concatenate([part.valid for part in parts]),
            columns=np.concatenate([part.columns for part in parts]),
            running=np.concatenate([part.running for part in parts]),
        )

    def state(self) -> dict[str, npt.NDArray[np.generic]]:
        """Return the arrays by name."""
        return {"valid": self.valid, "columns": self.columns, "running": self.running}

    @staticmethod
    def from_state(state: Mapping[str, npt.NDArray[np.generic]]) -> AxisRows:
        """Return what `state` was made from."""
        return AxisRows(
            valid=np.array(state["valid"], dtype=bool),
            columns=np.array(state["columns"], dtype=np.float64),
            running=np.array(state["running"], dtype=bool),
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class AxisBody:
    """What the regressions of an axis know of the body.

    The rates, the moments that turn them, and the inertia between; and the accelerometers.

    Attributes
    ----------
    inertia : ndarray, shape (n, n)
        Over S c or S b.
    regressors, equations : tuple of int
        Places of the rates among the regressors, of the moments among the equations.
    reach : ndarray, shape (p, n)
        What an error of the rates makes of the regressors, as a multiple of what it makes of its
        own: flow angles are moved to the CG by the rates.
    sharpness : ndarray, shape (p,)
        Variance of white noise in the band over that from second differences: bringing late
        channels to their time smoothes the latter, not the former.
    noise : ndarray, shape (p,)
        Variance of the regressors' own instruments, rad^2, by the aircraft file: what is seen
        beyond it is air that really moves. Zero for the rates.
    turns : ndarray of bool, shape (p,)
        Whether a regressor is a rate.
    trust : ndarray, shape (3,)
        Share of what the residuals of an equation have in common with the errors of the rates
        that is put down to these: all in the moments; half in the forces, whose residuals go
        with those of the moments through noise of a vane, too, and nothing tells the two apart.
    offset : ndarray, shape (3,)
        What the accelerometers' uncertain zero makes of qbar C, Pa.
    """

    inertia: FloatArray
    reach: FloatArray
    sharpness: FloatArray
    noise: FloatArray
    turns: BoolArray
    trust: FloatArray
    offset: FloatArray
    regressors: tuple[int, ...]
    equations: tuple[int, ...]


class Equations:
    """Turns rows of channels into rows of the regressions; keeps what must be remembered.

    Parameters
    ----------
    aircraft : Aircraft
    settings : FTRSettings
    dt : float
        Sample time, s.
    axes : sequence of {"lon", "lat"}
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
        self.aircraft, self.settings, self.dt = aircraft, settings, dt
        self.axes = tuple(axes)
        self._known = (
            None
            if measured is None
            else np.array([name in set(measured) for name in NEEDED_CHANNELS])
        )
        self._mass = aircraft.mass.mass if mass is None else mass
        self._burning = burning
        stall = aircraft.limits.stall_speed
        slow = settings.minimum_speed
        self._slowest = RUNWAY * stall if slow is None else slow
        positions = aircraft.propulsion.position
        count = max(len(positions), 1)
        self._height = sum(z for _, _, z in positions) / count
        self._sideways = sum(abs(y) for _, y, _ in positions) / count
        self._limits = _instrument_limits(aircraft)
        late = {} if aligned else lateness(aircraft)
        self._late = [(_PLACE[name], late[name] / dt) for name in NEEDED_CHANNELS if name in late]
        # The interpolation reaches two samples beyond the time asked for.
        self.ahead = int(max((steps for _, steps in self._late), default=-2.0)) + 2
        self.restart()

    def restart(self) -> None:
        """Forget what was measured so far."""
        count = len(NEEDED_CHANNELS)
        # Rows since the last sample of each channel; at first all get the benefit of the doubt.
        self.silence = np.zeros(count)
        self.heard = np.zeros(count, dtype=bool)
        self._ever = np.zeros((1, count), dtype=bool)  # up to each row
        self.held = np.full(count, np.nan)
        self.levers = np.full(2, np.nan)  # throttle and difference, as the engines follow them
        self.burned = np.zeros(1)
        self.pressures = np.full(2, np.nan)  # static, smoothed: now, and on the ground

    # --- rows -----------------------------------------------------------------------------------

    def rows(self, values: FloatArray) -> dict[FTRAxis, AxisRows]:
        """Return the regressions' rows of consecutive samples.

        Parameters
        ----------
        values : ndarray, shape (1 + n + ahead, len(NEEDED_CHANNELS))
            SI, NaN where missing; the row before the first comes first.
        """
        values = self._in_time(self._unclipped(values))
        alive = self._alive(values)
        held = self._hold(values)
        finite = np.isfinite(values)

        def signal(name: str) -> FloatArray:
            place = _PLACE[name]
            return np.where(finite[:, place], values[:, place], 0.0)

        rho, V, qbar = self._air(values, held)
        flying = np.isfinite(V) & np.isfinite(qbar)
        V = np.where(flying, V, 30.0)
        qbar = np.where(flying, qbar, 1.0)
        calibrated = V * np.sqrt(rho / SEA_LEVEL_DENSITY)
        if self._slowest > 0.0:
            standing = flying & (calibrated < STANDING * self._slowest)
            flying &= self._clear_of_ground(values[:, _PLACE["static_pressure"]], rho, standing)
        flying &= calibrated >= max(self._slowest, 1.0)
        V = np.where(flying, V, 30.0)
        p, q, r = rates = signal("p"), signal("q"), signal("r")
        shown = V
        V, alpha, beta = (
            np.asarray(one, dtype=np.float64)
            for one in flow_at_cg(self.aircraft, V, signal("alpha"), signal("beta"), rates)
        )
        qbar = qbar * (V / shown) ** 2
        force, side, zero = self._engines(values, held, rho, V)
        mass = self._masses(held)

        geometry, body = self.aircraft.geometry, self.aircraft.mass
        place = self.aircraft.sensors.accelerometer.position
        still = (zero, zero, zero)
        measured = (signal("ax"), signal("ay"), signal("an"))
        ax, ay, an = accelerations_at_cg(place, measured, rates, still)
        ax_spun, ay_spun, an_spun = accelerations_at_cg(place, still, still, rates)
        weight = mass / geometry.wing_area
        out: dict[FTRAxis, AxisRows] = {}
        if "lon" in self.axes:
            moment = 1.0 / (geometry.wing_area * geometry.chord)
            pitch = (body.ixx - body.izz) * p * r + body.ixz * (p * p - r * r)
            longitudinal: tuple[FloatArray, ...] = (
                qbar * alpha,
                qbar * q * (0.5 * geometry.chord) / V,
                qbar * signal("de"),
                qbar,
                weight * an,
                force / geometry.wing_area - weight * ax,
                moment * (pitch - self._height * force),
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
                qbar,
                weight * ay,
                moment * roll,
                moment * (yaw - self._sideways * side),
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
    ) -> AxisRows:
        valid = flying.copy()
        speaks = np.full(valid.size, self.settings.speed is not None)
        for name in _PITOT:
            speaks |= alive[:, _PLACE[name]]
        for name in _REQUIRED[axis]:
            place = _PLACE[name]
            # A surface that stands still may do without an instrument.
            spared = ~self._ever[:, place] if name in self.settings.still else False
            valid &= finite[:, place] | spared
            speaks &= alive[:, place] | spared
        # What may be missing altogether still interrupts while it only pauses.
        own = [_OWN.get(name) for name in COEFFICIENTS[axis]]
        for name in (*_OPTIONAL[axis], *(one for one in own if one is not None)):
            valid &= finite[:, _PLACE[name]] | ~alive[:, _PLACE[name]]
        running = np.empty((valid.size, 3), dtype=bool)
        for index, one in enumerate(own):
            running[:, index] = speaks if one is None else speaks & alive[:, _PLACE[one]]
        stacked = np.stack(columns, axis=1)
        stacked[~valid] = 0.0
        return AxisRows(valid=valid, columns=stacked, running=running)

    def _unclipped(self, values: FloatArray) -> FloatArray:
        """Return the values with samples at the end of an instrument's range missing."""
        low, high = self._limits
        with np.errstate(invalid="ignore"):
            return np.where((values <= low) | (values >= high), np.nan, values)

    def _in_time(self, values: FloatArray) -> FloatArray:
        """Return the n rows with late channels as they were at each row's time."""
        own = values[1 : len(values) - self.ahead].copy()
        for place, steps in self._late:
            own[:, place] = advanced(values[:, place], steps)[1 : 1 + len(own)]
        return own

    def _alive(self, values: FloatArray) -> BoolArray:
        """Return which channels spoke within the last moments, shape (n, n_channels)."""
        finite = np.isfinite(values)
        ever = np.logical_or.accumulate(
            np.concatenate((self.heard[np.newaxis], finite)), axis=0, dtype=bool
        )
        self._ever, self.heard = ever[1:], ever[-1].copy()
        if self._known is not None:
            return np.broadcast_to(self._known, finite.shape)
        count = len(values)
        rows = np.arange(1.0, count + 1.0)[:, np.newaxis]
        last = np.maximum.accumulate(np.where(finite, rows, -self.silence), axis=0)
        silence = rows - last
        self.silence = silence[-1].copy()
        return np.asarray(silence <= SILENCE / self.dt)

    def _hold(self, values: FloatArray) -> FloatArray:
        """Return the values with missing ones replaced by the last measured."""
        full = np.concatenate((self.held[np.newaxis], values))
        rows = np.where(np.isfinite(full), np.arange(len(full))[:, np.newaxis], 0)
        np.maximum.accumulate(rows, axis=0, out=rows)
        held = np.take_along_axis(full, rows, axis=0)
        self.held = held[-1].copy()
        return held[1:]

    def _heard(self, name: str) -> bool:
        place = _PLACE[name]
        return bool(self.heard[place] if self._known is None else self._known[place])

    def _air(
        self, values: FloatArray, held: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return density, airspeed and dynamic pressure; NaN where there is none."""

        def one(name: str) -> FloatArray:
            return values[:, _PLACE[name]]

        def slow(name: str) -> FloatArray:
            return held[:, _PLACE[name]]

        with np.errstate(divide="ignore", invalid="ignore"):
            V, qbar = one("V"), one("qbar")
            qbar = np.where(np.isfinite(qbar), qbar, one("dynamic_pressure"))
            rho = slow("density")
            if not np.isfinite(rho).all():
                static = slow("static_pressure")
                rho = _first(
                    rho,
                    density(static, slow("temperature")),
                    standard_density(static),
                    2.0 * qbar / (V * V),
                )
            # A density off by more than a factor of two is no air: take that of sea level.
            sound = (rho > 0.3) & (rho < 2.0)
            rho = np.where(sound, rho, SEA_LEVEL_DENSITY)
            if self.settings.speed is not None:
                known = np.isfinite(V) | np.isfinite(qbar)
                V = np.where(known, V, self.settings.speed)
            V = np.where(np.isfinite(V), V, np.sqrt(2.0 * np.maximum(qbar, 0.0) / rho))
            qbar = np.where(np.isfinite(qbar), qbar, 0.5 * rho * V * V)
        return rho, V, qbar

    def _clear_of_ground(
        self, static: FloatArray, rho: FloatArray, standing: BoolArray
    ) -> BoolArray:
        """Return where the wheels are well above the place where the aircraft last stood.

        Everywhere if static pressure is not measured, or the aircraft was never seen on the
        ground.
        """
        smooth = self._smoothed(static, np.isfinite(static), 0)
        ground = self._smoothed(static, np.isfinite(static) & standing, 1)
        with np.errstate(invalid="ignore"):
            return np.asarray(~(ground - smooth < CLEARANCE * GRAVITY * rho))

    def _smoothed(self, signal: FloatArray, chosen: BoolArray, place: int) -> FloatArray:
        """Return a first-order smoothing of chosen samples, held in between."""
        state = float(self.pressures[place])
        picked = signal[chosen]
        if not picked.size:
            return np.full(signal.size, state)
        first = float(picked[0]) if np.isnan(state) else state
        decay = float(np.exp(-self.dt / SMOOTHING))
        smooth, _ = lfilter([1.0 - decay], [1.0, -decay], picked, zi=np.array([decay * first]))
        self.pressures[place] = smooth[-1]
        return np.concatenate(([state], smooth))[np.cumsum(chosen)]

    def _engines(
        self, values: FloatArray, held: FloatArray, rho: FloatArray, V: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the thrust, what left exceeds right by in thrust over two, and zeros."""
        zero = np.zeros(len(values))
        left, right = held[:, _PLACE["throttle_left"]], held[:, _PLACE["throttle_right"]]
        lever = np.where(
            np.isfinite(left + right), 0.5 * (left + right), held[:, _PLACE["throttle"]]
        )
        levers = np.stack((lever, 0.5 * (left - right)), axis=1)
        followed = self._follow(levers)
        force = np.asarray(thrust(self.aircraft, followed[:, 0], rho, V), dtype=np.float64)
        side = np.asarray(thrust(self.aircraft, followed[:, 1], rho, V), dtype=np.float64)
        measured = held[:, _PLACE["thrust"]]
        return np.where(np.isfinite(measured), measured, force), side, zero

    def _follow(self, levers: FloatArray) -> FloatArray:
        """Return what the engines make of the levers: first order, settled at the start."""
        lag = self.aircraft.propulsion.lag
        if lag <= 0.0:
            return np.where(np.isfinite(levers), levers, 0.0)
        decay = float(np.exp(-self.dt / lag))
        followed = np.zeros_like(levers)
        for column in range(levers.shape[1]):
            one, state = levers[:, column], float(self.levers[column])
            first = 0
            if np.isnan(state):
                # Settled at the first known position; before that there is no thrust to speak of.
                known = np.flatnonzero(np.isfinite(one))
                if not known.size:
                    continue
                first = int(known[0])
                state = float(one[first])
            moved, _ = lfilter(
                [1.0 - decay], [1.0, -decay], one[first:], zi=np.array([decay * state])
            )
            followed[first:, column] = moved
            self.levers[column] = moved[-1]
        return followed

    def _masses(self, held: FloatArray) -> FloatArray:
        """Return the mass at every sample, kg."""
        properties = self.aircraft.mass
        measured = held[:, _PLACE["mass"]]
        if self._burning:
            throttle = np.clip(np.nan_to_num(held[:, _PLACE["throttle"]]), 0.0, 1.0)
            idle, full = properties.fuel_flow_idle, properties.fuel_flow_full
            steps = self.dt * (idle + (full - idle) * throttle)
            burned = np.cumsum(np.concatenate((self.burned, steps)))
            self.burned = burned[-1:].copy()
            burning = self._mass - np.minimum(burned[1:], properties.fuel)
        else:
            burning = np.full(len(held), self._mass)
        return np.where(np.isfinite(measured), measured, burning)

    def body(self, axis: FTRAxis) -> AxisBody:
        """Return how the rates of an axis answer to its moments."""
        geometry, body = self.aircraft.geometry, self.aircraft.mass
        zero = self.settings.accelerometer_offset * self._mass / geometry.wing_area
        offset = np.array([zero if name in _OWN else 0.0 for name in COEFFICIENTS[axis]])
        sharpness = self._sharpness(axis)
        sensors = self.aircraft.sensors
        own = {
            "alpha": sensors.alpha_vane.noise / sensors.alpha_vane.upwash,
            "beta": sensors.beta_vane.noise / sensors.beta_vane.upwash,
            **dict.fromkeys(("p", "q", "r"), 0.0),
        }
        names = axis_regressors(axis)
        noise = np.array([own.get(name, sensors.surfaces.noise) ** 2 for name in names])
        trust = np.array([0.5 if name in _OWN else 1.0 for name in COEFFICIENTS[axis]])
        turns = np.array([name in ("p", "q", "r") for name in names])
        if axis == "lon":
            inertia = np.array([[body.iyy]]) / (geometry.wing_area * geometry.chord)
            x, _, _ = self.aircraft.sensors.alpha_vane.position
            return AxisBody(
                inertia=inertia,
                reach=np.array([[2.0 * x / geometry.chord], [1.0], [0.0]]),
                sharpness=sharpness,
                noise=noise,
                turns=turns,
                trust=trust,
                offset=offset,
                regressors=(1,),
                equations=(2,),
            )
        inertia = np.array([[body.ixx, -body.ixz], [-body.ixz, body.izz]])
        inertia = inertia / (geometry.wing_area * geometry.span)
        x, _, z = self.aircraft.sensors.beta_vane.position
        reach = np.zeros((5, 2))
        reach[0] = 2.0 * z / geometry.span, -2.0 * x / geometry.span
        reach[1, 0] = reach[2, 1] = 1.0
        return AxisBody(
            inertia=inertia,
            reach=reach,
            sharpness=sharpness,
            noise=noise,
            turns=turns,
            trust=trust,
            offset=offset,
            regressors=(1, 2),
            equations=(1, 2),
        )

    def _sharpness(self, axis: FTRAxis) -> FloatArray:
        """Return `AxisBody.sharpness`."""
        late = dict(self._late)
        found = []
        for name in axis_regressors(axis):
            pulse = np.zeros(32)
            pulse[20] = 1.0
            steps = late.get(_PLACE[name], 0.0) % 1.0
            found.append(6.0 / float((np.diff(advanced(pulse, steps)[:30], n=2) ** 2).sum()))
        return np.array(found)

    # --- saved state ----------------------------------------------------------------------------

    def state(self) -> dict[str, npt.NDArray[np.generic]]:
        """Return all that is remembered, for `restore`."""
        return {
            "silence": self.silence,
            "heard": self.heard,
            "held": self.held,
            "levers": self.levers,
            "burned": self.burned,
            "pressures": self.pressures,
        }

    def restore(self, state: Mapping[str, npt.NDArray[np.generic]]) -> None:
        """Go on from what `state` gave."""
        self.silence = np.array(state["silence"], dtype=np.float64)
        self.heard = np.array(state["heard"], dtype=bool)
        self.held = np.array(state["held"], dtype=np.float64)
        self.levers = np.array(state["levers"], dtype=np.float64)
        self.burned = np.array(state["burned"], dtype=np.float64)
        self.pressures = np.array(state["pressures"], dtype=np.float64)

    # --- words ----------------------------------------------------------------------------------

    def why_not(self, axis: FTRAxis) -> dict[str, str]:
        """Return, for each coefficient that cannot be had now, why, in words."""
        spoken = (
            (self.heard & (self.silence <= SILENCE / self.dt))
            if self._known is None
            else self._known
        )

        def there(name: str) -> bool:
            return bool(spoken[_PLACE[name]])

        missing = [
            name
            for name in _REQUIRED[axis]
            if not there(name) and not (name in self.settings.still and not self._heard(name))
        ]
        if not any(there(name) for name in _PITOT) and self.settings.speed is None:
            missing.insert(0, "airspeed")
        found: dict[str, str] = {}
        for name in COEFFICIENTS[axis]:
            own = _OWN.get(name)
            lacking = missing + ([own] if own is not None and not there(own) else [])
            if lacking:
                verb = "is" if len(lacking) == 1 else "are"
                found[name] = f"{' and '.join(lacking)} {verb} not measured"
        return found

    def remarks(self) -> tuple[str, ...]:
        """Return what stands in for what, in words."""
        found: list[str] = []
        for axis in self.axes:
            silent = [name for name in _OPTIONAL[axis] if not self._heard(name)]
            if silent:
                what = "longitudinal" if axis == "lon" else "lateral"
                found.append(
                    f"{', '.join(silent)} not measured: taken as zero in the {what} equations"
                )
        still = [
            name
            for axis in self.axes
            for name in SURFACES[axis]
            if name in self.settings.still and not self._heard(name)
        ]
        if still:
            found.append(f"{', '.join(still)} not measured: taken as standing still")
        if not any(self._heard(name) for name in _PITOT) and self.settings.speed is not None:
            found.append(
                f"airspeed was not measured; the constant {self.settings.speed:.1f} m/s stands in"
            )
        engine = ("throttle", "throttle_left", "thrust")
        if (
            "lon" in self.axes
            and self.aircraft.propulsion.max_thrust > 0.0
            and not any(self._heard(name) for name in engine)
        ):
            found.append("neither throttle nor thrust was measured: CA_0 then holds the thrust")
        return tuple(found)


def _first(*candidates: FloatArray) -> FloatArray:
    """Return the first of several values that is a number, sample by sample."""
    found = candidates[0]
    for other in candidates[1:]:
        found = np.where(np.isfinite(found), found, other)
    return found


def _instrument_limits(aircraft: Aircraft) -> tuple[FloatArray, FloatArray]:
    """Return, by channel, where an instrument counts as clipped (1 % from the ends)."""
    sensors = aircraft.sensors
    ranges = {
        "alpha": sensors.alpha_vane.range,
        "beta": sensors.beta_vane.range,
        **dict.fromkeys(("p", "q", "r"), sensors.gyro.range),
        **dict.fromkeys(("ax", "ay", "an"), sensors.accelerometer.range),
    }
    low = np.full(len(NEEDED_CHANNELS), -np.inf)
    high = np.full(len(NEEDED_CHANNELS), np.inf)
    for name, (bottom, top) in ranges.items():
        margin = 0.01 * (top - bottom)
        low[_PLACE[name]], high[_PLACE[name]] = bottom + margin, top - margin
    return low, high
