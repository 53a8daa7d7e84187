"""Maximum likelihood the plain way: the measure for the fast engine.

Nothing is shared with the fast engine but the equations of motion: every trajectory is integrated
from sample to sample with scalar numbers, sensitivities are central differences, the normal
equations are summed sample by sample, and the correction for colored residuals is the double sum
as the notes print it.
"""

from __future__ import annotations

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


@dataclass(frozen=True, kw_only=True, eq=False)
class Segment:
    """Contiguous samples of one maneuver."""

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

    Attributes
    ----------
    free : sequence of str
        Derivatives and effect parameters.
    weights : mapping of str to float, optional
        Fixed weights; by default the noise covariance of each maneuver is estimated.
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
    diagonal: bool = False
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
        parameters = model.parameters_with(
            {**self.held, **{name: theta[name] for name in self.free}}
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
        now += [float(x) for x in model.resting_states(first, inputs[0])]
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
        """Return the responses as the instruments show them: late, scaled, biased."""
        shown = computed.copy()
        times = segment.dt * np.arange(len(computed))
        for column, name in enumerate(self.responses):
            key = f"{segment.maneuver}.{name}"
            if name in self.time_shifts:
                late = times - theta[f"shift.{key}"]
                shown[:, column] = np.interp(late, times, computed[:, column])
            shown[:, column] *= theta.get(f"scale.{key}", 1.0)
            shown[:, column] += theta.get(f"bias.{key}", 0.0)
        return shown

    # --- all of them ----------------------------------------------------------------------------

    def residuals(self, theta: Mapping[str, float]) -> list[FloatArray]:
        """Return measured minus computed by segment, NaN where a sample does not count."""
        return [one.measured - self.respond(one, theta) for one in self.segments]

    def sensitivities(
        self, theta: Mapping[str, float], steps: Mapping[str, float]
    ) -> list[FloatArray]:
        """Return dy/dtheta by segment, shape (n, n_responses, n_parameters)."""
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
        """Return W of each maneuver: given, or the inverse of its residuals' covariance."""
        if self.weights is not None:
            fixed = np.diag([self.weights[name] for name in self.responses])
            return [fixed for _ in self.maneuvers]
        found = []
        for index in range(len(self.maneuvers)):
            rows = [x for one, x in zip(self.segments, v, strict=True) if one.maneuver == index]
            own = np.concatenate(rows)
            count = own.shape[1]
            R = np.zeros((count, count))
            for a in range(count):
                for b in range(count):
                    product = own[:, a] * own[:, b]
                    if a == b or not self.diagonal:
                        R[a, b] = product[np.isfinite(product)].mean()
            found.append(np.linalg.inv(R))
        return found

    def normal_equations(
        self, S: Sequence[FloatArray], v: Sequence[FloatArray], W: Sequence[FloatArray]
    ) -> tuple[FloatArray, FloatArray]:
        """Return sum S'WS and sum S'Wv over the samples that count."""
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

    def fit(self, start: Mapping[str, float], *, iterations: int = 12) -> Fit:
        """Return the fit.

        Parameters
        ----------
        start : mapping of str to float
            For the free derivatives. Initial states start from measurement.
        """
        theta = dict.fromkeys(self.names, 0.0)
        theta.update({name: start[name] for name in self.free})
        theta.update({name: 1.0 for name in self.names if name.startswith("scale.")})
        for one in self.segments:
            for name in self.states:
                column = one.states[:, POLAR_STATES.index(name)]
                theta[f"initial.{one.maneuver}.{one.number}.{name}"] = float(column[0])
        steps = {name: 1e-5 * max(abs(theta[name]), 0.1) for name in self.names}
        prior = np.zeros((len(self.names), len(self.names)))
        for name, (_, std) in self.priors.items():
            prior[self.names.index(name), self.names.index(name)] = 1.0 / std**2
        change = np.inf
        for _ in range(iterations):
            v = self.residuals(theta)
            W = self.weight_matrices(v)
            S = self.sensitivities(theta, steps)
            H, gradient = self.normal_equations(S, v, W)
            for name, (value, std) in self.priors.items():
                gradient[self.names.index(name)] += (value - theta[name]) / std**2
            H = H + prior
            move = np.linalg.solve(H, gradient)
            bounds = np.sqrt(np.linalg.inv(H).diagonal())
            # From one iteration to the next where the step suits the parameter: a small part of
            # its bound leaves neither curvature nor rounding.
            steps = {name: 0.02 * float(b) for name, b in zip(self.names, bounds, strict=True)}
            theta = {n: theta[n] + float(m) for n, m in zip(self.names, move, strict=True)}
            change = float(np.max(np.abs(move) / bounds))
            if change < 1e-8:
                break
        v = self.residuals(theta)
        W = self.weight_matrices(v)
        S = self.sensitivities(theta, steps)
        H, _ = self.normal_equations(S, v, W)
        bread = np.linalg.inv(H + prior)
        meat = self._gradient_covariance(S, v, W) + prior
        return Fit(
            theta=theta,
            cramer_rao=dict(zip(self.names, np.sqrt(bread.diagonal()), strict=True)),
            std=dict(zip(self.names, np.sqrt((bread @ meat @ bread).diagonal()), strict=True)),
            change=change,
        )

    def _gradient_covariance(
        self, S: Sequence[FloatArray], v: Sequence[FloatArray], W: Sequence[FloatArray]
    ) -> FloatArray:
        """Return the double sum of the notes, section 7, "Any W, colored"."""
        size = len(self.names)
        B = np.zeros((size, size))
        for index in range(len(self.maneuvers)):
            mine = [k for k, one in enumerate(self.segments) if one.maneuver == index]
            total = sum(len(v[k]) for k in mine)
            counts = [np.isfinite(v[k]) for k in mine]
            clean = [np.where(c, v[k], 0.0) for c, k in zip(counts, mine, strict=True)]
            weighted = [
                np.einsum("ab,kbp->kap", W[index], S[k] * c[:, :, None])
                for c, k in zip(counts, mine, strict=True)
            ]
            for j in range(self.lags + 1):
                C = np.zeros((v[0].shape[1], v[0].shape[1]))
                pairs = np.zeros_like(C)
                for c, x in zip(counts, clean, strict=True):
                    last = max(len(x) - j, 0)
                    C += x[:last].T @ x[j : j + last]
                    pairs += c[:last].T.astype(float) @ c[j : j + last]
                C = C / np.maximum(pairs, 1.0) * (1.0 - j / total)
                taper = 1.0 - j / (self.lags + 1.0)
                term = np.zeros((size, size))
                for G in weighted:
                    for k in range(len(G) - j):
                        term += G[k].T @ C @ G[k + j]
                B += taper * (term if j == 0 else term + term.T)
        return B


@dataclass(frozen=True, kw_only=True, eq=False)
class Fit:
    """What came out, by parameter name; `change` is the last step over the bounds."""

    theta: Mapping[str, float]
    cramer_rao: Mapping[str, float]
    std: Mapping[str, float]
    change: float
