"""Maximum likelihood the plain way: the measure for the fast engine.

Nothing is shared with the fast engine but the equations of motion: every trajectory is integrated
from sample to sample with scalar numbers, sensitivities are central differences, the normal
equations are summed sample by sample, and the correction for colored residuals is the double sum
as the notes print it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from gsapp.dynamics.equations import POLAR_STATES
from gsapp.dynamics.flight_model import FlightModel
from gsapp.dynamics.model import Model
from gsapp.dynamics.sensors import OutputModel
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.motion import measured_motion
from gsapp.quantities import FloatArray


def cubic(samples: FloatArray, place: float) -> float:
    base = math.floor(place)
    u = place - base
    a, b, c, d = (float(samples[min(max(base + k, 0), len(samples) - 1)]) for k in (-1, 0, 1, 2))
    return 0.5 * (
        2.0 * b
        + (c - a) * u
        + (2.0 * a - 5.0 * b + 4.0 * c - d) * u * u
        + (3.0 * b - a - 3.0 * c + d) * u**3
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class Segment:
    maneuver: int
    number: int
    dt: float
    states: FloatArray
    inputs: FloatArray
    measured: FloatArray
    model: FlightModel
    outputs: OutputModel


@dataclass(kw_only=True, eq=False)
class Reference:
    """One fit.

    Fixed weights are scaled so that the weighted residuals have a mean square of 1: the estimates
    do not feel it, bounds and a-priori values do.

    Attributes
    ----------
    free : sequence of str
        Derivatives and effect parameters.
    weights : mapping of str to float, optional
        Fixed weights; by default the noise variances of each maneuver are estimated.
    full : bool
        Estimate the covariances between responses, too.
    needed : sequence of str
        Measured inputs without which a sample does not count.
    """

    maneuvers: Sequence[Maneuver]
    model: Model
    states: Sequence[str]
    responses: Sequence[str]
    free: Sequence[str]
    biases: Sequence[str] = ()
    scale_factors: Sequence[str] = ()
    time_shifts: Sequence[str] = ()
    held: Mapping[str, float] = field(default_factory=dict)
    priors: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    weights: Mapping[str, float] | None = None
    full: bool = False
    needed: Sequence[str] = ("de", "da", "dr")
    euler: bool = False
    lags: int = 50

    def __post_init__(self) -> None:
        self.segments = [
            segment
            for index, maneuver in enumerate(self.maneuvers)
            for segment in self._cut(index, maneuver)
        ]
        self.names: list[str] = list(self.free)
        for segment in self.segments:
            self.names += [
                f"initial.{segment.maneuver}.{segment.number}.{name}" for name in self.states
            ]
        for index in range(len(self.maneuvers)):
            self.names += [f"bias.{index}.{name}" for name in self.biases]
            self.names += [f"scale.{index}.{name}" for name in self.scale_factors]
            self.names += [f"shift.{index}.{name}" for name in self.time_shifts]

    def _cut(self, index: int, maneuver: Maneuver) -> list[Segment]:
        """Cut a maneuver where its time leaps."""
        motion = measured_motion(maneuver)
        times, dt = motion.times, maneuver.dt
        model = FlightModel(maneuver.aircraft, self.model)
        outputs = OutputModel(model, self.responses)
        measured = np.column_stack([maneuver.samples(name) for name in self.responses])
        for name in self.needed:
            if name in motion.interpolated:
                # The input was missing: nobody knows what the responses should be.
                measured[motion.interpolated[name]] = np.nan
        leaps = [k for k in range(1, len(times)) if times[k] - times[k - 1] > 2.5 * dt]
        return [
            Segment(
                maneuver=index,
                number=number,
                dt=dt,
                states=motion.states[first:last],
                inputs=motion.inputs[first:last],
                measured=measured[first:last],
                model=model,
                outputs=outputs,
            )
            for number, (first, last) in enumerate(pairwise([0, *leaps, len(times)]))
        ]

    # --- one trajectory -------------------------------------------------------------------------

    def respond(self, segment: Segment, theta: Mapping[str, float]) -> FloatArray:
        """Return the computed responses of a segment, shape (n, n_responses)."""
        model, dt = segment.model, segment.dt
        given = {**self.held, **{name: theta[name] for name in self.free}}
        parameters = tuple(
            given.get(name, value)
            for name, value in zip(model.parameter_names, model.defaults, strict=True)
        )
        active = [POLAR_STATES.index(name) for name in self.states]
        active += range(9, len(model.state_names))
        label = f"{segment.maneuver}.{segment.number}"
        measured = [[float(x) for x in row] for row in segment.states]
        inputs = [[float(x) for x in row] for row in segment.inputs]

        def mixed(row: Sequence[float], moving: Sequence[float]) -> list[float]:
            whole = [*row, *([0.0] * (len(model.state_names) - 9))]
            for place, value in zip(active, moving, strict=True):
                whole[place] = value
            return whole

        def slope(row: Sequence[float], moving: Sequence[float], u: Sequence[float]) -> list[float]:
            rates = model.rates(mixed(row, moving), u, parameters)
            return [float(rates[place]) for place in active]

        now = [theta[f"initial.{label}.{name}"] for name in self.states]
        first = mixed(measured[0], [*now, *([0.0] * (len(active) - len(now)))])[:9]
        now += [float(x) for x in model.steady_states(first, inputs[0])]
        computed = []
        for k in range(len(measured)):
            computed.append(segment.outputs.values(mixed(measured[k], now), inputs[k], parameters))
            if k + 1 == len(measured):
                break
            row, after = measured[k], measured[k + 1]
            middle = [0.5 * (a + b) for a, b in zip(row, after, strict=True)]
            u_middle = [0.5 * (a + b) for a, b in zip(inputs[k], inputs[k + 1], strict=True)]
            k1 = slope(row, now, inputs[k])
            if self.euler:
                now = [x + dt * a for x, a in zip(now, k1, strict=True)]
                continue
            k2 = slope(middle, [x + 0.5 * dt * a for x, a in zip(now, k1, strict=True)], u_middle)
            k3 = slope(middle, [x + 0.5 * dt * a for x, a in zip(now, k2, strict=True)], u_middle)
            k4 = slope(after, [x + dt * a for x, a in zip(now, k3, strict=True)], inputs[k + 1])
            now = [
                x + dt / 6.0 * (a + 2.0 * b + 2.0 * c + d)
                for x, a, b, c, d in zip(now, k1, k2, k3, k4, strict=True)
            ]
        return self._as_shown(np.array(computed, dtype=float), segment, theta)

    def _as_shown(
        self, computed: FloatArray, segment: Segment, theta: Mapping[str, float]
    ) -> FloatArray:
        shown = computed.copy()
        times = segment.dt * np.arange(len(computed))
        for column, name in enumerate(self.responses):
            key = f"{segment.maneuver}.{name}"
            if name in self.time_shifts:
                late = theta[f"shift.{key}"] / segment.dt
                shown[:, column] = [cubic(computed[:, column], k - late) for k in range(len(times))]
            shown[:, column] *= theta.get(f"scale.{key}", 1.0)
            shown[:, column] += theta.get(f"bias.{key}", 0.0)
        return shown

    # --- all of them ----------------------------------------------------------------------------

    def residuals(self, theta: Mapping[str, float]) -> list[FloatArray]:
        return [one.measured - self.respond(one, theta) for one in self.segments]

    def sensitivities(
        self, theta: Mapping[str, float], steps: Mapping[str, float]
    ) -> list[FloatArray]:
        found = [np.zeros((*one.measured.shape, len(self.names))) for one in self.segments]
        for column, name in enumerate(self.names):
            step = steps[name]
            for index, one in enumerate(self.segments):
                kind, _, rest = name.partition(".")
                if kind == "initial" and not rest.startswith(f"{one.maneuver}.{one.number}."):
                    continue
                if kind in ("bias", "scale", "shift") and not rest.startswith(f"{one.maneuver}."):
                    continue
                above = self.respond(one, {**theta, name: theta[name] + step})
                below = self.respond(one, {**theta, name: theta[name] - step})
                found[index][:, :, column] = (above - below) / (2.0 * step)
        return found

    def weight_matrices(self, v: Sequence[FloatArray]) -> list[FloatArray]:
        """Return W of each maneuver: given and scaled, or the inverse of its noise covariance."""
        if self.weights is not None:
            given = np.array([self.weights[name] for name in self.responses])
            squares = np.concatenate([(given * x * x).ravel() for x in v])
            fixed = np.diag(given / squares[np.isfinite(squares)].mean())
            return [fixed for _ in self.maneuvers]
        found = []
        for index in range(len(self.maneuvers)):
            own = np.concatenate([v[k] for k in self._mine(index)])
            count = own.shape[1]
            R = np.zeros((count, count))
            for a in range(count):
                for b in range(count):
                    product = own[:, a] * own[:, b]
                    if a == b or self.full:
                        R[a, b] = product[np.isfinite(product)].mean()
            found.append(np.linalg.inv(R))
        return found

    def normal_equations(
        self, S: Sequence[FloatArray], v: Sequence[FloatArray], W: Sequence[FloatArray]
    ) -> tuple[FloatArray, FloatArray]:
        size = len(self.names)
        H, gradient = np.zeros((size, size)), np.zeros(size)
        for one, sensitivity, residual in zip(self.segments, S, v, strict=True):
            weight = W[one.maneuver]
            for s, e in zip(sensitivity, residual, strict=True):
                counted = np.isfinite(e)
                kept = s * counted[:, None]
                H += kept.T @ weight @ kept
                gradient += kept.T @ weight @ np.where(counted, e, 0.0)
        return H, gradient

    def fit(
        self,
        start: Mapping[str, float],
        *,
        bounds: Mapping[str, float] | None = None,
        iterations: int = 12,
    ) -> Fit:
        """Return the fit.

        Parameters
        ----------
        start : mapping of str to float
            By parameter name; initial states that are left out start from measurement.
        bounds : mapping of str to float, optional
            About the bounds: small parts of them are the steps of the differences. Without, a
            first guess is made and an iteration more is needed.
        iterations : int
            At most; a step below 1e-6 of all bounds is the last.
        """
        theta = dict.fromkeys(self.names, 0.0)
        theta.update({name: 1.0 for name in self.names if name.startswith("scale.")})
        for one in self.segments:
            for name in self.states:
                column = one.states[:, POLAR_STATES.index(name)]
                theta[f"initial.{one.maneuver}.{one.number}.{name}"] = float(column[0])
        theta.update(start)
        # A small part of the bound leaves neither curvature nor rounding.
        steps = {name: 1e-5 * max(abs(value), 0.1) for name, value in theta.items()}
        if bounds is not None:
            steps = {name: 0.005 * bounds[name] for name in self.names}
        prior = np.zeros((len(self.names), len(self.names)))
        for name, (_, std) in self.priors.items():
            prior[self.names.index(name), self.names.index(name)] = 1.0 / std**2
        for _ in range(iterations):
            v = self.residuals(theta)
            W = self.weight_matrices(v)
            S = self.sensitivities(theta, steps)
            H, gradient = self.normal_equations(S, v, W)
            for name, (value, std) in self.priors.items():
                gradient[self.names.index(name)] += (value - theta[name]) / std**2
            bread = np.linalg.inv(H + prior)
            move = bread @ gradient
            plain = np.sqrt(bread.diagonal())
            theta = {n: theta[n] + float(m) for n, m in zip(self.names, move, strict=True)}
            change = float(np.max(np.abs(move) / plain))
            if change < 1e-6:
                break
            steps = {name: 0.005 * float(b) for name, b in zip(self.names, plain, strict=True)}
        honest = self._colored(S, v, W, bread, prior)
        return Fit(
            theta=theta,
            cramer_rao=dict(zip(self.names, plain.tolist(), strict=True)),
            std=dict(zip(self.names, np.sqrt(honest.diagonal()).tolist(), strict=True)),
            change=change,
        )

    def _colored(
        self,
        S: Sequence[FloatArray],
        v: Sequence[FloatArray],
        W: Sequence[FloatArray],
        bread: FloatArray,
        prior: FloatArray,
    ) -> FloatArray:
        """Return the covariance of the notes, section 7, "Any W, colored".

        A second time with what the fit took away added to the autocovariance of the residuals:
        E v_k v_l' = E n_k n_l' - Y_k S_l' - S_k Y_l', Y = (C * WS) H^-1 - S cov/2.
        """
        shapes = range(len(self.maneuvers))
        added = [np.zeros((self.lags + 1, v[0].shape[1], v[0].shape[1])) for _ in shapes]
        covariance = bread
        for _ in range(2):
            B, autocovariances = prior.copy(), []
            for index in shapes:
                own, C = self._gradient_covariance(index, S, v, W[index], added[index])
                B += own
                autocovariances.append(C)
            covariance = bread @ B @ bread
            for index in shapes:
                added[index] = self._taken(
                    index, S, v, W[index], autocovariances[index], bread, covariance
                )
        return covariance

    def _mine(self, index: int) -> list[int]:
        return [k for k, one in enumerate(self.segments) if one.maneuver == index]

    def _pairs(self, index: int, v: Sequence[FloatArray], j: int) -> FloatArray:
        found = np.zeros((v[0].shape[1], v[0].shape[1]))
        for k in self._mine(index):
            counted = np.isfinite(v[k]).astype(float)
            last = max(len(counted) - j, 0)
            found += counted[:last].T @ counted[j : j + last]
        return np.maximum(found, 1.0)

    def _total(self, index: int, v: Sequence[FloatArray]) -> int:
        return sum(len(v[k]) for k in self._mine(index))

    def _gradient_covariance(
        self,
        index: int,
        S: Sequence[FloatArray],
        v: Sequence[FloatArray],
        W: FloatArray,
        added: FloatArray,
    ) -> tuple[FloatArray, FloatArray]:
        """Return B of one maneuver and its tapered C_j, j = 0 ... lags."""
        size = len(self.names)
        B = np.zeros((size, size))
        C = np.zeros_like(added)
        for j in range(self.lags + 1):
            for k in self._mine(index):
                clean = np.where(np.isfinite(v[k]), v[k], 0.0)
                last = max(len(clean) - j, 0)
                C[j] += clean[:last].T @ clean[j : j + last]
            C[j] = C[j] / self._pairs(index, v, j) * (1.0 - j / self._total(index, v)) + added[j]
            C[j] *= 1.0 - j / (self.lags + 1.0)
            for k in self._mine(index):
                G = W @ (S[k] * np.isfinite(v[k])[:, :, None])
                term = np.einsum("kap,ab,kbq->pq", G[: len(G) - j], C[j], G[j:], optimize=True)
                B += term if j == 0 else term + term.T
        return B, C

    def _taken(
        self,
        index: int,
        S: Sequence[FloatArray],
        v: Sequence[FloatArray],
        W: FloatArray,
        C: FloatArray,
        bread: FloatArray,
        covariance: FloatArray,
    ) -> FloatArray:
        """Return what the fit took from the autocovariance, j = 0 ... lags."""
        taken = np.zeros_like(C)
        for k in self._mine(index):
            counted = np.isfinite(v[k])[:, :, None]
            known = S[k] * counted
            G = W @ known
            filtered = np.zeros_like(G)
            for i in range(len(G)):
                for j in range(-self.lags, self.lags + 1):
                    if 0 <= i + j < len(G):
                        filtered[i] += (C[j] if j >= 0 else C[-j].T) @ G[i + j]
            Y = (filtered @ bread - S[k] @ (0.5 * covariance)) * counted
            for j in range(self.lags + 1):
                last = len(G) - j
                taken[j] += np.einsum("kap,kbp->ab", Y[:last], known[j:])
                taken[j] += np.einsum("kap,kbp->ab", known[:last], Y[j:])
        for j in range(self.lags + 1):
            taken[j] *= (1.0 - j / self._total(index, v)) / self._pairs(index, v, j)
        return taken


@dataclass(frozen=True, kw_only=True, eq=False)
class Fit:
    theta: Mapping[str, float]
    cramer_rao: Mapping[str, float]
    std: Mapping[str, float]
    change: float
