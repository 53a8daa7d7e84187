"""Maneuvers that are not flown yet: a card as this pilot will turn it out."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.dynamics.equations import POLAR_STATES
from gsapp.dynamics.flight_model import MODEL_INPUTS, FlightModel
from gsapp.dynamics.linearization import LinearModel
from gsapp.dynamics.model import Model
from gsapp.dynamics.propulsion import filter_first_order
from gsapp.dynamics.sensors import OutputModel
from gsapp.excitation.doublets.verdict import InputVerdict
from gsapp.excitation.settings import INFORMATION
from gsapp.excitation.test_points.perturbation_models import PerturbationModels
from gsapp.flight.cards import TestCard
from gsapp.identification.maneuver import Maneuver
from gsapp.quantities import Block, FloatArray
from gsapp.quantities.constants import FOOT
from gsapp.virtual.flight_plan import INPUT_SHAPES

_SHOWN: Final = ("alpha", "beta", "p", "q", "r", "ax", "ay", "an", "V", "phi", "theta")
_DRIVEN: Final = ("de", "da", "dr")


@dataclass(frozen=True, slots=True, kw_only=True)
class CardExecution:
    """How a card turns out once: factors on what it asks for."""

    sizes: Mapping[str, tuple[float, ...]]
    widths: Mapping[str, tuple[float, ...]]
    """Of each step, by surface."""
    stagger: float
    """On the time from one surface to the next."""
    speed_error: float
    """Off the test point, m/s."""
    hands_off: float
    """After the input, s."""


def simulate_maneuver(
    card: TestCard,
    execution: CardExecution,
    motions: PerturbationModels,
    *,
    aircraft: Aircraft,
    model: Model,
    mass: float,
    rate: float,
    channels: Collection[str],
) -> Maneuver:
    """Return a maneuver as it will be measured, but for the noise.

    The motions are those of the aircraft with this model and mass at the speed that it is flown at.
    """
    deflections = simulate_surfaces(card, execution, aircraft, 1.0 / rate)
    count = next(iter(deflections.values())).size
    if card.throttle_step:
        end = count / rate - execution.hands_off
        step = np.where(np.arange(count) / rate < end, 0.0, card.throttle_step)
        lag = max(aircraft.propulsion.lag, INFORMATION.hand_time_constant)
        deflections["throttle"] = filter_first_order(step, np.exp(-1.0 / (rate * lag)), 0.0)
    states = np.tile(np.array(motions.trim.state), (count, 1))
    inputs = np.tile(np.array(motions.trim.inputs), (count, 1))
    for name, moved in deflections.items():
        inputs[:, MODEL_INPUTS.index(name)] += moved
    for linear in (motions.longitudinal, motions.lateral):
        own = np.column_stack([deflections.get(name, np.zeros(count)) for name in linear.inputs])
        if own.any():
            moved = simulate_linear(linear, own, 1.0 / rate)
            for column, name in enumerate(linear.states):
                if name in POLAR_STATES:
                    states[:, POLAR_STATES.index(name)] += moved[:, column]
    flying = FlightModel(aircraft, model)
    shown = OutputModel(flying, _SHOWN).values(tuple(states.T), tuple(inputs.T))
    measured = {
        name: np.broadcast_to(row, (count,)) for name, row in zip(_SHOWN, shown, strict=True)
    }
    measured = {name: row for name, row in measured.items() if name in channels}
    for name in (*_DRIVEN, "throttle", "flap"):
        measured[name] = inputs[:, MODEL_INPUTS.index(name)]
    measured["density"] = inputs[:, MODEL_INPUTS.index("rho")]
    return Maneuver(
        id=card.id,
        flight="planned",
        aircraft=aircraft,
        block=Block(
            channels=tuple(measured),
            times=np.arange(count) / rate,
            values=np.column_stack([*measured.values()]),
        ),
        inputs=card.surfaces,
        mass=mass,
        kind=card.kind,
    )


def simulate_surfaces(
    card: TestCard, execution: CardExecution, aircraft: Aircraft, dt: float
) -> dict[str, FloatArray]:
    """Return the deflection of each surface of a card about trim, rad, shape (n,)."""
    histories: dict[str, FloatArray] = {}
    edges = {
        name: _step_times(
            card,
            name,
            execution,
            INFORMATION.pre_input_trim_time + index * execution.stagger * card.duration,
        )
        for index, name in enumerate(card.surfaces)
    }
    until = max(times[-1] for times, _ in edges.values()) + execution.hands_off
    grid = np.asarray(dt * np.arange(round(until / dt) + 1), dtype=np.float64)
    for name, (times, values) in edges.items():
        if card.kind == "sweep":
            asked = _sweep(grid - times[0], times[-1] - times[0])
        else:
            asked = np.array((0.0, *values, 0.0))[np.searchsorted(times, grid, side="right")]
        smooth = asked
        for lag in (INFORMATION.hand_time_constant, getattr(aircraft.controls, name).lag):
            keep = np.exp(-dt / lag) if lag > 0.0 else 0.0
            smooth = filter_first_order(smooth, keep, 0.0)
        # What counts as amplitude is half of what the surface went from end to end; of a pulse,
        # its height.
        full = np.ptp(smooth) if card.kind == "pulse" else 0.5 * np.ptp(smooth)
        wanted = card.amplitudes[name] * float(np.mean(execution.sizes[name]))
        histories[name] = smooth * (wanted / full)
    return histories


def _step_times(
    card: TestCard, name: str, execution: CardExecution, begin: float
) -> tuple[list[float], list[float]]:
    """Return when each step of a surface begins, with the end of the last, s, and its size."""
    units = INPUT_SHAPES.get(card.kind, INPUT_SHAPES["doublet"])
    if card.kind == "sweep":
        return [begin, begin + card.width * execution.widths[name][0]], [1.0]
    times, values = [begin], []
    for unit, size, width in zip(units, execution.sizes[name], execution.widths[name], strict=True):
        values.append(unit * size)
        times.append(times[-1] + card.width * width)
    return times, values


def _sweep(times: FloatArray, length: float) -> FloatArray:
    low, high = INFORMATION.sweep_band
    phase = 2.0 * np.pi * (low * times + 0.5 * (high - low) * times**2 / length)
    return np.where((times >= 0.0) & (times < length), np.sin(phase), 0.0)


def simulate_linear(linear: LinearModel, inputs: FloatArray, dt: float) -> FloatArray:
    """Return the states, shape (n, n_states), of a linear model from rest.

    Its inputs, shape (n, n_inputs), are straight between samples.
    """
    size, width = linear.B.shape
    matrix = np.zeros((size + 2 * width, size + 2 * width))
    matrix[:size, :size] = linear.A * dt
    matrix[:size, size : size + width] = linear.B * dt
    matrix[size : size + width, size + width :] = np.eye(width)
    from scipy.linalg import expm  # a tenth of a second

    forward = expm(matrix)
    Phi, level, ramp = (
        forward[:size, :size],
        forward[:size, size : size + width],
        forward[:size, size + width :],
    )
    found = np.zeros((len(inputs), size))
    found[1:] = inputs[:-1] @ (level - ramp).T + inputs[1:] @ ramp.T
    # Each push goes on by one step, then all that came together by two, by four ...
    reach = 1
    while reach < len(found):
        found[reach:] += found[:-reach] @ Phi.T
        Phi = Phi @ Phi
        reach *= 2
    return found


USABLE_RESULTS: Final = frozenset({"good", "too-small", "too-fast", "too-slow", "not-trimmed"})
"""Verdicts on maneuvers that say something of the derivatives all the same."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ErrorDistribution:
    """One number that maneuvers miss: mean and standard deviation, with what is usual in it."""

    mean: float
    std: float
    sample_count: int = 0

    def updated(self, values: Sequence[float]) -> ErrorDistribution:
        """Return the habit once another maneuver was seen, with all that it showed of it."""
        weight = INFORMATION.pilot_prior_weight + self.sample_count
        value = float(np.mean(values))
        miss = value - self.mean
        mean = self.mean + miss / (weight + 1.0)
        seen = miss * (value - mean) + float(np.var(values))
        variance = (weight * self.std**2 + seen) / (weight + 1.0)
        return ErrorDistribution(
            mean=mean, std=math.sqrt(variance), sample_count=self.sample_count + 1
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class PilotErrorModel:
    """All habits that matter for what a card brings."""

    size: ErrorDistribution = ErrorDistribution(mean=0.0, std=0.12)
    width: ErrorDistribution = ErrorDistribution(mean=0.0, std=0.12)
    """Logarithms of amplitude and of width over those asked for."""
    speed_error: ErrorDistribution = ErrorDistribution(mean=0.0, std=3.0 * FOOT)
    """Off the test point, m/s."""
    bound_ratio: ErrorDistribution = ErrorDistribution(mean=0.0, std=0.5)
    """Logarithm of the bound under the noise that there was over the one expected for the same
    input as it was flown: noise and gusts are never twice the same."""
    hands_off: ErrorDistribution = ErrorDistribution(mean=4.0, std=0.8)
    """Seconds after the input that belong to the maneuver."""
    maneuver_count: int = 0
    usable_count: int = 0
    """Maneuvers flown, and those that said something."""

    @property
    def usable_share(self) -> float:
        """Return the share of maneuvers that will be fit; four of five to begin with."""
        return (0.8 * INFORMATION.pilot_prior_weight + self.usable_count) / (
            INFORMATION.pilot_prior_weight + self.maneuver_count
        )

    def updated_by_verdict(self, verdict: InputVerdict, card: TestCard | None) -> PilotErrorModel:
        """Return the habits once another maneuver was judged."""
        fit = verdict.result in USABLE_RESULTS
        found = replace(
            self, maneuver_count=self.maneuver_count + 1, usable_count=self.usable_count + fit
        )
        if not fit:
            return found
        found = replace(
            found, hands_off=self.hands_off.updated([verdict.t_end - verdict.t_input_end])
        )
        if card is None or card.kind != verdict.kind or set(card.surfaces) != set(verdict.surfaces):
            return found
        asked = card.amplitudes
        sizes = [
            math.log(size / asked[name])
            for name, size in verdict.amplitudes.items()
            if name in asked and size > 0.0
        ]
        widths = [
            math.log(width / card.width)
            for name in card.surfaces
            for width in verdict.halves.get(name, ())
            if width > 0.0 and len(verdict.halves[name]) == len(INPUT_SHAPES.get(card.kind, ()))
        ]
        if sizes:
            found = replace(found, size=self.size.updated([float(np.mean(sizes))]))
        if widths and card.kind == "doublet":
            found = replace(found, width=self.width.updated([float(np.mean(widths))]))
        if verdict.V is not None:
            found = replace(found, speed_error=self.speed_error.updated([verdict.V - card.speed]))
        return found

    def updated_by_bounds(self, ratios: Sequence[float]) -> PilotErrorModel:
        """Return the habits once bounds were so many times as large as expected."""
        return replace(
            self, bound_ratio=self.bound_ratio.updated([math.log(one) for one in ratios])
        )


def draw_executions(
    card: TestCard, habits: PilotErrorModel, count: int
) -> tuple[CardExecution, ...]:
    """Return how a card may turn out: `count` draws, the same ones every time.

    Sizes and widths miss together over a maneuver, and by half as much again from step to step
    and from surface to surface. Draws come in pairs that miss to opposite sides.
    """
    random = np.random.default_rng(len(card.surfaces))
    steps = len(INPUT_SHAPES.get(card.kind, INPUT_SHAPES["doublet"]))
    width = 4 + 2 * len(card.surfaces) * steps
    half = random.standard_normal(((count + 1) // 2, width))
    draws = np.concatenate((half, -half))[:count]
    return tuple(_create_execution(card, habits, draw.tolist(), steps) for draw in draws)


def _create_execution(
    card: TestCard, habits: PilotErrorModel, draw: list[float], steps: int
) -> CardExecution:
    size, width, speed, hands_off, *rest = draw
    single = iter(rest)

    def factors(habit: ErrorDistribution, common: float) -> Mapping[str, tuple[float, ...]]:
        return {
            name: tuple(
                math.exp(habit.mean + habit.std * (common + 0.5 * next(single)))
                for _ in range(steps)
            )
            for name in card.surfaces
        }

    sizes, widths = factors(habits.size, size), factors(habits.width, width)
    return CardExecution(
        sizes=sizes,
        widths=widths,
        stagger=math.exp(habits.width.mean + habits.width.std * width),
        speed_error=habits.speed_error.mean + habits.speed_error.std * speed,
        hands_off=max(1.0, habits.hands_off.mean + habits.hands_off.std * hands_off),
    )
