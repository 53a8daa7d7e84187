"""How much of an answer is the air's and not the input's.

The aircraft's small motions at the speed flown, driven by the surfaces as measured, with whatever
it was doing before, and by gusts, are fitted to the answer. A gain for each surface is free, so
that a model that is off in its control derivatives does not look like gusts.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from typing import Final

import numpy as np
from scipy.linalg import expm

from gsapp.aircraft import Aircraft
from gsapp.dynamics.linearization import LinearModel
from gsapp.dynamics.model import Model
from gsapp.excitation.doublets.gust_separation import ResponseChannel, separate_gusts
from gsapp.excitation.doublets.settings import DOUBLETS
from gsapp.excitation.test_points.perturbation_models import (
    PerturbationModels,
    linearize_level_flight,
)
from gsapp.flight.maneuvers.input_measures import RESPONSE_CHANNELS
from gsapp.flight.maneuvers.noise_floor import NoiseFloor
from gsapp.foundation import FlightError
from gsapp.quantities import FloatArray
from gsapp.quantities.constants import DEGREE

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
    """Explains answers by an aircraft's model.

    Parameters
    ----------
    aircraft : Aircraft
    model : Model
    rate : float
        Of the rows, Hz.
    """

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
        pushed = next(place for place, name in enumerate(linear.states) if name in _PUSHED)
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

    Returns
    -------
    ndarray, shape (n, n_outputs, 2 n_inputs + n_states)
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
