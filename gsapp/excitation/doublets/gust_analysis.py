"""How much of an answer is the air's and not the input's.

The aircraft's small motions at the speed flown, driven by the surfaces as measured, with whatever
it was doing before, and by gusts, are fitted to the answer. A gain for each surface is free, so
that a model that is off in its control derivatives does not look like gusts.

The answer without gusts, ``X theta``, follows from the surfaces as measured, from sticks held, from
the state in which it began and from each channel's zero error. Gusts are pushes ``w`` of unknown
size on the angle of attack or of sideslip, one every `DOUBLETS.gust_step`: the vanes show them at
once, and the aircraft answers as it does to any such angle. Both are found together, with what is
known of them beforehand:

    y = X theta + H w + e

How strong the gusts are, and how noisy each channel is, follows from the answer itself: expectation
maximization. What an instrument alone shows and no gust makes, as vibration does that the sampling
folds down, stays noise.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.linalg import expm, toeplitz

from gsapp.aircraft import Aircraft
from gsapp.dynamics.linearization import LinearModel
from gsapp.dynamics.model import Model
from gsapp.excitation.settings import DOUBLETS
from gsapp.excitation.test_points.perturbation_models import (
    PerturbationModels,
    linearize_level_flight,
)
from gsapp.flight.maneuvers.input_measures import RESPONSE_CHANNELS
from gsapp.flight.maneuvers.noise_floor import NoiseFloor
from gsapp.foundation import FlightError
from gsapp.quantities import FloatArray
from gsapp.quantities.constants import DEGREE


@dataclass(frozen=True, slots=True, kw_only=True)
class ResponseParts:
    """Standard deviations of the parts of one channel's answer, SI."""

    without_gusts: float
    """Without gusts."""
    gusts: float
    """Of what gusts added."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ResponseChannel:
    """One channel's answer and what it may consist of."""

    samples: FloatArray
    """SI; NaN where missing."""
    responses: FloatArray
    """To everything but gusts."""
    gust_response: FloatArray
    """Response to a push of the air at the first sample, SI per rad."""
    noise: float
    """Standard deviation of a sample where nothing happens, SI."""


def separate_gusts(
    channels: Sequence[ResponseChannel], known: tuple[FloatArray, FloatArray], rate: float
) -> list[ResponseParts]:
    """Part the answer of all channels of one axis.

    Parameters
    ----------
    known : tuple of ndarray, shape (m, n_unknown) and (m,)
        What is known beforehand of the unknowns that are no gusts, each row in its own standard
        deviations.

    Returns
    -------
    list of Parts
        In the order of the channels. The gusts' part counts what is not known of the pushes as
        well: an estimate alone would always be too small.
    """
    step = max(round(DOUBLETS.gust_step * rate), 1)
    blocks = [_average(one, step) for one in channels]
    size = known[0].shape[1]
    pushes = blocks[0].pushes.shape[1]
    push = DOUBLETS.initial_gust
    noise = [block.least for block in blocks]
    for _ in range(DOUBLETS.gust_iterations):
        found, spread = _solve(blocks, noise, push, known)
        gusts = found[size:]
        unknown = float(np.trace(spread[size:, size:]))
        push = max(math.sqrt((float(gusts @ gusts) + unknown) / pushes), DOUBLETS.min_gust)
        noise = [block.noise(found, spread) for block in blocks]
    return [block.parts(found, spread, size) for block in blocks]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Block:
    """Means over `DOUBLETS.gust_step` of a channel, its responses and its gust responses."""

    samples: FloatArray
    responses: FloatArray
    pushes: FloatArray
    least: float

    @property
    def columns(self) -> FloatArray:
        return np.hstack((self.responses, self.pushes))

    def noise(self, found: FloatArray, spread: FloatArray) -> float:
        """Return the noise that leaves so much over."""
        columns = self.columns
        rest = self.samples - columns @ found
        square = float(rest @ rest) + float(((columns @ spread) * columns).sum())
        return max(math.sqrt(square / max(rest.size, 1)), self.least)

    def parts(self, found: FloatArray, spread: FloatArray, size: int) -> ResponseParts:
        """Return how large both parts are."""
        pushed = self.pushes - self.pushes.mean(axis=0)
        unknown = float(((pushed @ spread[size:, size:]) * pushed).sum()) / len(pushed)
        gusts = float(np.var(self.pushes @ found[size:]))
        calm = float(np.std(self.responses @ found[:size]))
        return ResponseParts(without_gusts=calm, gusts=math.sqrt(gusts + unknown))


def _average(one: ResponseChannel, step: int) -> _Block:
    count = one.samples.size // step
    there = np.isfinite(one.samples)
    place = np.arange(one.samples.size)
    whole = np.interp(place, place[there], one.samples[there])

    def means(values: FloatArray) -> FloatArray:
        blocks = values[: count * step].reshape(count, step, *values.shape[1:])
        return np.asarray(blocks.mean(axis=1))

    kept = means(there.astype(np.float64)) > 0.5
    after = means(one.gust_response)
    samples = means(whole)[kept]
    return _Block(
        samples=samples,
        responses=means(one.responses)[kept],
        pushes=toeplitz(after, np.zeros(count))[kept],
        least=max(
            one.noise / math.sqrt(step), DOUBLETS.min_noise_share * float(samples.std()), 1e-9
        ),
    )


def _solve(
    blocks: Sequence[_Block],
    noise: Sequence[float],
    push: float,
    known: tuple[FloatArray, FloatArray],
) -> tuple[FloatArray, FloatArray]:
    """Return the unknowns, pushes last, and their covariance."""
    rows, sides = known
    size, pushes = rows.shape[1], blocks[0].pushes.shape[1]
    normal = np.zeros((size + pushes, size + pushes))
    normal[:size, :size] = rows.T @ rows
    normal[range(size, size + pushes), range(size, size + pushes)] = 1.0 / push**2
    side = np.concatenate((rows.T @ sides, np.zeros(pushes)))
    for block, deviation in zip(blocks, noise, strict=True):
        columns = block.columns / deviation
        normal += columns.T @ columns
        side += columns.T @ (block.samples / deviation)
    # Angles beside accelerations: of one scale they are told apart to the last digit.
    scale = 1.0 / np.sqrt(np.diag(normal) + 1e-30)
    scaled = normal * np.outer(scale, scale) + 1e-12 * np.eye(scale.size)
    spread = np.linalg.inv(scaled) * np.outer(scale, scale)
    return spread @ side, spread


GUST_ANALYSIS_CHANNELS: Final = {
    "longitudinal": ("alpha", "q", "an"),
    "lateral": ("beta", "p", "r", "ay"),
}
"""Channels whose answer is explained."""

_OFFSET: Final = ("alpha",)
"""States that are not zero in level flight: the second before tells them."""
_STATE_SPREADS: Final = {
    **dict.fromkeys(("alpha", "beta"), (0.25 * DEGREE, 0.6 * DEGREE)),
    **dict.fromkeys(("p", "q", "r"), (0.8 * DEGREE, 0.7 * DEGREE)),
    **dict.fromkeys(("phi", "theta"), (2.0 * DEGREE, 2.0 * DEGREE)),
    "V": (0.3, 0.3),
}
"""Of a state as the input begins, as measured, and of its trim in level flight; SI."""

_PUSHED: Final = ("alpha", "beta")
"""States that a gust from below or from the side pushes."""


class GustAnalyzer:
    """Explains answers by an aircraft's model."""

    def __init__(self, aircraft: Aircraft, model: Model, rate: float) -> None:
        self._aircraft = aircraft
        self._model = model
        self._rate = rate
        self._known: dict[tuple[int, int], PerturbationModels | None] = {}

    def gust_fraction(
        self,
        inputs: Mapping[str, FloatArray],
        answers: Mapping[str, FloatArray],
        main: Collection[str],
        *,
        trim: Mapping[str, tuple[float, float]],
        speed: float,
        density: float,
        noise: NoiseFloor,
    ) -> float | None:
        """Return what gusts did, as a share of what the answer is without them.

        Parameters
        ----------
        inputs : mapping of str to ndarray, shape (n,)
            Surfaces that moved, on purpose or not, from the beginning of the input on, rad.
        main : collection of str
            Those whose answer counts.
        answers : mapping of str to ndarray, shape (n,)
            Channels of `GUST_ANALYSIS_CHANNELS` at the same times, SI.
        trim : mapping of str to tuple of float
            Of each channel: its mean over the second before the input, and at its beginning.
        speed, density : float
            m/s and kg/m^3.
        noise : NoiseFloor
            What no input explains, and no gust either.

        Returns
        -------
        float or None
            Root mean square over what answers to these surfaces, the larger of both axes; None
            where too little was measured, or the model does not fly so.
        """
        motions = self._motions(speed, density)
        if motions is None:
            return None
        longitudinal = [name for name in inputs if name == "de"]
        lateral = [name for name in inputs if name != "de"]
        counted = {name for surface in main for name in RESPONSE_CHANNELS[surface]}
        shares = [
            self._share(linear, moved, names, inputs, answers, noise, trim, counted)
            for linear, moved, names in (
                (motions.longitudinal, longitudinal, GUST_ANALYSIS_CHANNELS["longitudinal"]),
                (motions.lateral, lateral, GUST_ANALYSIS_CHANNELS["lateral"]),
            )
            if set(moved) & set(main)
        ]
        known = [share for share in shares if share is not None]
        return max(known) if known else None

    def _motions(self, speed: float, density: float) -> PerturbationModels | None:
        key = (round(speed / DOUBLETS.speed_step), round(density / DOUBLETS.density_step))
        if key not in self._known:
            try:
                self._known[key] = linearize_level_flight(
                    self._aircraft,
                    self._model,
                    speed=key[0] * DOUBLETS.speed_step,
                    density=key[1] * DOUBLETS.density_step,
                )
            except FlightError:
                self._known[key] = None
        return self._known[key]

    def _share(
        self,
        linear: LinearModel,
        moved: list[str],
        names: tuple[str, ...],
        inputs: Mapping[str, FloatArray],
        answers: Mapping[str, FloatArray],
        noise: NoiseFloor,
        trim: Mapping[str, tuple[float, float]],
        counted: set[str],
    ) -> float | None:
        driven = {name: inputs[name] - inputs[name][0] for name in moved}
        basis = _simulate_responses(linear, driven, 1.0 / self._rate)
        pushed = next(index for index, name in enumerate(linear.states) if name in _PUSHED)
        heard = {
            name: samples
            for name in names
            if (samples := answers.get(name)) is not None
            and np.isfinite(samples).sum() >= DOUBLETS.min_response_samples
        }
        if not counted & set(heard):
            return None
        offsets = np.eye(len(heard))
        channels = []
        for name, offset in zip(heard, offsets, strict=True):
            own = basis[:, linear.outputs.index(name), :]
            channels.append(
                ResponseChannel(
                    samples=heard[name],
                    responses=np.hstack((own, np.tile(offset, (len(own), 1)))),
                    gust_response=own[:, 2 * len(moved) + pushed],
                    noise=noise.std_of(name),
                )
            )
        known = _prior_rows(linear, list(heard), basis.shape[2], trim)
        parts = separate_gusts(channels, known, self._rate)
        squares = [
            (part.gusts / max(part.without_gusts, 1e-6)) ** 2
            for name, part in zip(heard, parts, strict=True)
            if name in counted
        ]
        return math.sqrt(sum(squares) / len(squares))


def _simulate_responses(
    linear: LinearModel, driven: Mapping[str, FloatArray], dt: float
) -> FloatArray:
    """Return the outputs to each input, to each held at one throughout, to each state's beginning.

    Shape (n, n_outputs, 2 n_inputs + n_states).
    """
    size, count = len(linear.states), len(next(iter(driven.values())))
    columns = [linear.inputs.index(name) for name in driven]
    inputs = np.column_stack([np.nan_to_num(samples) for samples in driven.values()])
    matrix = np.zeros((size + len(columns), size + len(columns)))
    matrix[:size, :size], matrix[:size, size:] = linear.A, linear.B[:, columns]
    forward = expm(dt * matrix)
    step, push = forward[:size, :size], forward[:size, size:]
    # Straight lines between the samples, to the first order: their means drive.
    means = 0.5 * (inputs[1:] + inputs[:-1])
    moved, held = slice(0, len(columns)), slice(len(columns), 2 * len(columns))
    state = np.hstack((np.zeros((size, held.stop)), np.eye(size)))
    found = np.empty((count, size, state.shape[1]))
    found[0] = state
    for row in range(1, count):
        state = step @ state
        state[:, moved] += push * means[row - 1]
        state[:, held] += push
        found[row] = state
    outputs = np.einsum("os,nsb->nob", linear.C, found)
    outputs[:, :, moved] += np.einsum("oi,ni->noi", linear.D[:, columns], inputs)
    outputs[:, :, held] += linear.D[:, columns]
    return np.asarray(outputs)


def _prior_rows(
    linear: LinearModel,
    measured: Sequence[str],
    size: int,
    trim: Mapping[str, tuple[float, float]],
) -> tuple[FloatArray, FloatArray]:
    """Return what is known of gains, states and offsets as rows of the regression.

    It keeps gusts from being taken for a start out of trim: gains are about one, and state and
    offset together are what was measured as the input began.
    """
    states = size - len(linear.states)
    rows: list[FloatArray] = []
    sides: list[float] = []

    def known(places: Sequence[int], value: float, spread: float) -> None:
        row = np.zeros(size + len(measured))
        row[list(places)] = 1.0 / spread
        rows.append(row)
        sides.append(value / spread)

    for place in range(states // 2):
        known([place], 1.0, DOUBLETS.gain_std)
        known([states // 2 + place], 0.0, DOUBLETS.max_trim_offset)
    seen = {name: size + place for place, name in enumerate(measured) if name in trim}
    for place, name in enumerate(linear.states):
        small, wide = _STATE_SPREADS.get(
            name, (DOUBLETS.effect_state_std, DOUBLETS.effect_state_std)
        )
        if name in seen:
            mean, start = trim[name]
            known([states + place, seen[name]], start, small)
            known([seen[name]], mean if name in _OFFSET else 0.0, wide)
        else:
            known([states + place], 0.0, wide)
    return np.array(rows), np.array(sides)
