"""The measured motion of a maneuver, completed to what the equations need.

Estimation needs all nine polar states and all inputs at every sample: those that the fit does not
integrate come from measurement. Flow angles and speed are moved from the instruments to the
center of gravity; air data follow from whichever pressures, speed and temperature there are; what
no instrument measured gets a stand-in, which is said.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.integrate import cumulative_trapezoid

from gsapp.dynamics.atmosphere import SEA_LEVEL_DENSITY
from gsapp.dynamics.equations import POLAR_STATES, quaternion_from_euler
from gsapp.dynamics.flight_model import MODEL_INPUTS
from gsapp.dynamics.propulsion import throttle_for
from gsapp.dynamics.sensors import flow_at_cg
from gsapp.dynamics.signal_terms import apply_lag
from gsapp.flight.air_data_histories import air_density, airspeed_history
from gsapp.foundation import FlightError
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.preparation_settings import PREPARATION
from gsapp.quantities import BoolArray, FloatArray
from gsapp.quantities.constants import GRAVITY


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MeasuredMotion:
    """States and inputs at every sample of a maneuver, none missing."""

    times: FloatArray  # Shape (n,). s.
    states: FloatArray
    """Shape (n, 9). `gsapp.dynamics.equations.POLAR_STATES`, at the center of gravity."""
    inputs: FloatArray  # Shape (n, 8). `gsapp.dynamics.flight_model.MODEL_INPUTS`.
    measured: frozenset[str]
    """Names of states and inputs that come from an instrument; the others are stand-ins."""
    interpolated: Mapping[str, BoolArray]
    """Shape (n,). Samples that were missing or clipped and are interpolated here, by state or
    input. They must not count in any cost."""
    remarks: tuple[str, ...]  # What stands in for what, in words.

    def state(self, name: str) -> FloatArray:
        return self.states[:, POLAR_STATES.index(name)]

    def input(self, name: str) -> FloatArray:
        """Return one input, shape (n,)."""
        return self.inputs[:, MODEL_INPUTS.index(name)]

    @property
    def qbar(self) -> FloatArray:
        """Return the dynamic pressure, Pa, shape (n,)."""
        V = self.state("V")
        return np.asarray(0.5 * self.input("rho") * V * V, dtype=np.float64)


def measured_motion(
    maneuver: Maneuver, *, stand_ins: Mapping[str, float] | None = None
) -> MeasuredMotion:
    """Complete the measured motion of a maneuver.

    `stand_ins`: constants (SI) for states and inputs that were not measured: ``{"V": 30.0}``.

    Raises `FlightError` if nothing can stand in for a missing speed, or the aircraft did not fly.
    """
    return _MotionBuilder(maneuver, dict(stand_ins or {})).finish()


class _MotionBuilder:
    """Collects the signals of one maneuver, noting what was measured, filled or stood in."""

    def __init__(self, maneuver: Maneuver, stand_ins: Mapping[str, float]) -> None:
        self.maneuver, self.stand_ins = maneuver, stand_ins
        self.count = len(maneuver.block)
        self.measured: set[str] = set()
        self.filled: dict[str, BoolArray] = {}
        self.remarks: list[str] = []

    def finish(self) -> MeasuredMotion:
        rho = self._density()
        speed = self._speed(rho)
        rates = tuple(self._signal(name, 0.0) for name in ("p", "q", "r"))
        shown = (speed, self._signal("alpha", 0.0), self._signal("beta", 0.0))
        at_cg = flow_at_cg(self.maneuver.aircraft, *shown, (rates[0], rates[1], rates[2]))
        # What no vane or pitot showed is a stand-in at the CG already.
        V, alpha, beta = (
            np.asarray(moved if name in self.measured else stand_in, dtype=np.float64)
            for name, moved, stand_in in zip(("V", "alpha", "beta"), at_cg, shown, strict=True)
        )
        states = np.column_stack((V, alpha, beta, *rates, *self._attitude(V, alpha, beta, rates)))
        inputs = np.column_stack(
            [
                *(self._signal(name, 0.0) for name in ("de", "da", "dr", "flap")),
                *self._throttles(rho, V),
                rho,
                np.full(self.count, self.maneuver.mass),
            ]
        )
        return MeasuredMotion(
            times=self.maneuver.block.times,
            states=states,
            inputs=inputs,
            measured=frozenset(self.measured),
            interpolated=self.filled,
            remarks=tuple(self.remarks),
        )

    # --- one signal -----------------------------------------------------------------------------

    def _fill(self, name: str, samples: FloatArray) -> FloatArray:
        """Interpolate over missing samples, noting which."""
        missing = ~np.isfinite(samples)
        self.measured.add(name)
        if not missing.any():
            return samples
        self.filled[name] = missing
        times = self.maneuver.block.times
        return np.interp(times, times[~missing], samples[~missing])

    def _signal(self, name: str, otherwise: float) -> FloatArray:
        samples = self.maneuver.samples(name)
        if np.isfinite(samples).any():
            return self._fill(name, samples)
        constant = self.stand_ins.get(name, otherwise)
        if name in ("alpha", "beta", "p", "q", "r", "de", "da", "dr") or constant != otherwise:
            self.remarks.append(
                f"{name} was not measured; the constant {constant:.4g} is used and assumed exact"
            )
        return np.full(self.count, constant)

    # --- air data -------------------------------------------------------------------------------

    def _density(self) -> FloatArray:
        rho = air_density(self.maneuver.samples)
        if np.isfinite(rho).any():
            return self._fill("rho", rho)
        constant = self.stand_ins.get("rho", SEA_LEVEL_DENSITY)
        self.remarks.append(f"air density was not measured; {constant:.3f} kg/m^3 is used")
        return np.full(self.count, constant)

    def _speed(self, rho: FloatArray) -> FloatArray:
        samples = airspeed_history(self.maneuver.samples, rho)
        stall = self.maneuver.aircraft.limits.stall_speed
        if np.isfinite(samples).any() and float(np.nanmax(samples)) > 0.0:
            usual = float(np.nanmedian(samples))
            if usual < max(PREPARATION.min_speed_ratio * stall, 1.0):
                raise FlightError(
                    f"maneuver {self.maneuver.id} of '{self.maneuver.flight}' was not flown: "
                    f"its airspeed of {usual:.1f} m/s is far below the stall speed; if the "
                    "pitot is faulty, drop its channels (gsapp cut --without) to use a constant"
                )
            return np.maximum(self._fill("V", samples), 1.0)
        constant = self.stand_ins.get("V", PREPARATION.cruise_speed_ratio * stall)
        if constant <= 0.0:
            raise FlightError(
                f"maneuver {self.maneuver.id} of '{self.maneuver.flight}' has no airspeed, and "
                "the aircraft file no stall_speed to guess one from; give a constant for V"
            )
        self.remarks.append(
            f"airspeed was not measured; the constant {constant:.1f} m/s is used and assumed "
            "exact: coefficients scale with its square"
        )
        return np.full(self.count, constant)

    # --- attitude and engines -------------------------------------------------------------------

    def _attitude(
        self,
        V: FloatArray,
        alpha: FloatArray,
        beta: FloatArray,
        rates: tuple[FloatArray, ...],
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return phi, theta, psi; where not measured, the rates integrated from `_start`."""
        missing = [name for name in ("phi", "theta") if not self.maneuver.has(name)]
        given = {name: self._signal(name, 0.0) for name in ("phi", "theta") if name not in missing}
        psi = self._signal("psi", 0.0)
        if not missing:
            return given["phi"], given["theta"], psi
        phi, theta = self._start((V, alpha, beta), rates)
        phi, theta = self.stand_ins.get("phi", phi), self.stand_ins.get("theta", theta)
        rolled, pitched = integrate_attitude(self.maneuver.block.times, rates, phi, theta)
        rolled, pitched = given.get("phi", rolled), given.get("theta", pitched)
        self.remarks.append(
            f"{' and '.join(missing)} not measured; gravity at the start and integrated rates "
            "are used"
        )
        return rolled, pitched, psi

    def _start(
        self, flow: tuple[FloatArray, ...], rates: tuple[FloatArray, ...]
    ) -> tuple[float, float]:
        """Return bank and pitch angle (rad) at the first sample, from what gravity does there.

        a_x = u' + q w - r v + g sin(theta) and a_y = v' + r u - p w - g sin(phi) cos(theta), over
        the first moments; their means belong to the middle, and rates lead back to the start.
        Without a_x the flight counts as level, without a_y as a turn without sideslip.
        """
        first = slice(
            0, max(2, min(self.count, round(PREPARATION.attitude_time / self.maneuver.dt)))
        )
        times = self.maneuver.block.times[first]
        V, alpha, beta = (one[first] for one in flow)
        p, q, r = (rate[first] for rate in rates)
        u = V * np.cos(alpha) * np.cos(beta)
        v, w = V * np.sin(beta), V * np.sin(alpha) * np.cos(beta)
        turned = [float(np.mean(cumulative_trapezoid(rate, times, initial=0.0))) for rate in (p, q)]

        def shown(name: str, growing: FloatArray) -> float | None:
            """Return an acceleration less the change of speed along its axis."""
            samples = self.maneuver.samples(name)[first]
            if "V" not in self.measured or not np.isfinite(samples).any():
                return None
            return float(np.nanmean(samples) - np.polyfit(times, growing, 1)[0])

        pull, push = shown("ax", u), shown("ay", v)
        theta = float(alpha.mean())
        if pull is not None:
            theta = _arcsin((pull - float(np.mean(q * w - r * v))) / GRAVITY)
        turning = float(np.mean(r * u - p * w)) - (push or 0.0)
        phi = _arcsin(turning / (GRAVITY * np.cos(theta)))
        return phi - turned[0], theta - (turned[1] if pull is not None else 0.0)

    def _throttles(self, rho: FloatArray, V: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return throttle as the engines follow it, and half of left minus right."""
        aircraft = self.maneuver.aircraft
        if self.maneuver.has("thrust") and aircraft.propulsion.max_thrust > 0.0:
            thrust = self._fill("throttle", self.maneuver.samples("thrust"))
            followed = throttle_for(aircraft, thrust, rho, V)
            return np.asarray(followed, dtype=np.float64), np.zeros(self.count)
        levers = [
            self.maneuver.samples(name)
            for name in ("throttle_left", "throttle_right")
            if self.maneuver.has(name)
        ]
        difference = np.zeros(self.count)
        if len(levers) == 2:
            lever = self._fill("throttle", 0.5 * (levers[0] + levers[1]))
            difference = self._fill("throttle_difference", 0.5 * (levers[0] - levers[1]))
        elif self.maneuver.has("throttle"):
            lever = self._fill("throttle", self.maneuver.samples("throttle"))
        else:
            constant = self.stand_ins.get("throttle", 0.0)
            if aircraft.propulsion.max_thrust > 0.0:
                self.remarks.append(
                    f"neither throttle nor thrust was measured; throttle {constant:g} is used: "
                    "CA_0 then includes the thrust"
                )
            lever = np.full(self.count, constant)
        lag = aircraft.propulsion.lag
        return self._lagged(lever, lag), self._lagged(difference, lag)

    def _lagged(self, lever: FloatArray, lag: float) -> FloatArray:
        """Return what the engines make of a lever: first order, settled at the start."""
        if lag <= 0.0 or not np.ptp(lever):
            return lever
        return apply_lag(lever, lag, self.maneuver.dt)


def integrate_attitude(
    times: FloatArray, rates: tuple[FloatArray, ...], phi: float, theta: float
) -> tuple[FloatArray, FloatArray]:
    """Return bank and pitch angle (rad), shape (n,), that body rates turn a first attitude to.

    Each step turns by the mean of the rates at its ends; the turns are exact (quaternions).

    Parameters
    ----------
    times : ndarray, shape (n,)
        s.
    rates : tuple of ndarray, shape (n,)
        p, q, r, rad/s.
    phi, theta : float
        At the first sample, rad.
    """
    half = 0.25 * np.diff(times) * np.stack([rate[1:] + rate[:-1] for rate in rates])
    angle = np.sqrt((half * half).sum(axis=0))
    share = np.sinc(angle / np.pi)
    turns = zip(np.cos(angle).tolist(), *(share * half).tolist(), strict=True)
    w, x, y, z = quaternion_from_euler(phi, theta, 0.0)
    found = [(w, x, y, z)]
    for a, b, c, d in turns:
        w, x, y, z = (
            w * a - x * b - y * c - z * d,
            w * b + x * a + y * d - z * c,
            w * c - x * d + y * a + z * b,
            w * d + x * c - y * b + z * a,
        )
        found.append((w, x, y, z))
    w_all, x_all, y_all, z_all = np.array(found).T
    sine = np.clip(2.0 * (w_all * y_all - z_all * x_all), -1.0, 1.0)
    bank = np.arctan2(
        2.0 * (w_all * x_all + y_all * z_all), 1.0 - 2.0 * (x_all * x_all + y_all * y_all)
    )
    return bank, np.arcsin(sine)


def _arcsin(share: float) -> float:
    return float(np.arcsin(np.clip(share, -0.9, 0.9)))
