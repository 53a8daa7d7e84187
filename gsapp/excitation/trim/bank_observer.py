"""Bank without attitude: from rates, lateral acceleration and, where there is one, the beta vane.

The rate of roll tells how the bank changes, and the sideways motion where it stands: a wing that
hangs down pulls the aircraft to its side unless it turns that way,

    phi' = p + tan(theta) (q sin(phi) + r cos(phi))
    v'   = a_y + g cos(theta) sin(phi) - r V + p V tan(theta)

and v stays near zero, or near V times beta. In level flight theta is the mean of a_x over g.
"""

from __future__ import annotations

import math

from gsapp.excitation.settings import TRIM
from gsapp.quantities.constants import GRAVITY


class TwoStateKalmanFilter:
    """A Kalman filter of two states in plain floats: a step takes less than one of arrays would."""

    __slots__ = ("_p00", "_p01", "_p11", "first", "second")

    def __init__(self, states: tuple[float, float], spreads: tuple[float, float]) -> None:
        self.first, self.second = states
        self._p00, self._p01, self._p11 = spreads[0] ** 2, 0.0, spreads[1] ** 2

    @property
    def stds(self) -> tuple[float, float]:
        return math.sqrt(self._p00), math.sqrt(self._p11)

    def predict(
        self,
        states: tuple[float, float],
        cross: tuple[float, float],
        noise: tuple[float, float],
    ) -> None:
        """Go on by one step to states as the caller's equations have them.

        `cross` is how much the first state then depends on the second before, and the second on the
        first; `noise` the variances that the step adds.
        """
        self.first, self.second = states
        b, c = cross
        p00, p01, p11 = self._p00, self._p01, self._p11
        self._p00 = p00 + 2.0 * b * p01 + b * b * p11 + noise[0]
        self._p01 = c * p00 + (1.0 + b * c) * p01 + b * p11
        self._p11 = c * c * p00 + 2.0 * c * p01 + p11 + noise[1]

    def update_first(self, value: float, variance: float) -> None:
        """Take in a measurement of the first state."""
        total = self._p00 + variance
        k0, k1 = self._p00 / total, self._p01 / total
        miss = value - self.first
        self.first += k0 * miss
        self.second += k1 * miss
        self._p11 -= k1 * self._p01
        self._p01 -= k0 * self._p01
        self._p00 -= k0 * self._p00

    def update_second(self, value: float, variance: float) -> None:
        """Take in a measurement of the second state."""
        total = self._p11 + variance
        k0, k1 = self._p01 / total, self._p11 / total
        miss = value - self.second
        self.first += k0 * miss
        self.second += k1 * miss
        self._p00 -= k0 * self._p01
        self._p01 -= k1 * self._p01
        self._p11 -= k1 * self._p11


class BankObserver:
    """Follows the bank and its standard deviation tick by tick, NaN while no yaw rate is measured.

    `pitch` is the pitch attitude in level flight; `usual_speed` is taken where no airspeed is
    measured.
    """

    def __init__(self, dt: float, usual_speed: float) -> None:
        self._dt = dt
        self._usual_speed = usual_speed
        self.restart()

    def restart(self) -> None:
        self._filter = TwoStateKalmanFilter((0.0, 0.0), TRIM.initial_bank_std)
        self.pitch = TRIM.default_pitch
        self.bank, self.bank_std = math.nan, TRIM.initial_bank_std[0]

    def step(
        self,
        rates: tuple[float, float, float],
        ax: float,
        ay: float,
        speed: float,
        beta: float,
        gusts: float,
    ) -> None:
        """Go on by one tick: p, q, r, rad/s, and what follows NaN where missing; gusts in m/s."""
        p, q, r = rates
        if r != r:
            self.restart()
            return
        dt, state = self._dt, self._filter
        V = speed if speed > 0.5 * self._usual_speed else self._usual_speed
        roll_noise = TRIM.roll_process_noise if p == p else TRIM.roll_process_noise_unmeasured
        side_noise = TRIM.side_process_noise if ay == ay else TRIM.side_process_noise_unmeasured
        p, q = (p if p == p else 0.0), (q if q == q else 0.0)
        if ax == ax:
            seen = (ax - q * V * self.pitch) / GRAVITY
            self.pitch += (
                dt / TRIM.attitude_time_constant * (min(max(seen, -0.4), 0.4) - self.pitch)
            )
        phi, v = state.first, state.second
        sine, cosine = math.sin(phi), math.cos(phi)
        nose = math.tan(self.pitch)
        roll = p + nose * (q * sine + r * cosine)
        pull = GRAVITY * math.cos(self.pitch)
        side = (ay if ay == ay else 0.0) + pull * sine - r * V + p * V * nose
        state.predict(
            (phi + dt * roll, v + dt * side),
            (0.0, dt * pull * cosine),
            (dt * roll_noise, dt * side_noise),
        )
        # A gust lasts: each tick tells only a part of what independent ones would.
        expected = V * beta if beta == beta else 0.0
        apart = (
            math.hypot(TRIM.calm_air_std, gusts)
            if beta == beta
            else math.hypot(TRIM.sideslip_std, gusts)
        )
        state.update_second(expected, 2.0 * apart * apart * TRIM.gust_time / dt)
        self.bank = min(max(state.first, -1.5), 1.5)
        self.bank_std = state.stds[0]
