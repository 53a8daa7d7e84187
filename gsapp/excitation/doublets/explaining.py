"""How much of an answer the input explains: what is left over is the air's.

The aircraft's small motions at the speed flown, driven by the surfaces as measured, with whatever
it was doing before, are fitted to the answer. A gain for each surface is free, so that a model
that is off in its control derivatives does not look like gusts.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from typing import Final

import numpy as np
from scipy.linalg import expm

from gsapp.aircraft import Aircraft
from gsapp.dynamics.linearization import LinearModel
from gsapp.dynamics.model import Model
from gsapp.excitation.points.small_motions import SmallMotions, small_motions
from gsapp.flight.maneuvers.noise import NoiseFloor
from gsapp.foundation import FlightError
from gsapp.quantities import FloatArray

ANSWERS: Final = {"longitudinal": ("alpha", "q", "an"), "lateral": ("beta", "p", "r", "ay")}
"""Channels whose answer is explained."""

_SPEED_STEP: Final = 1.0
"""Small motions are found once for each so many m/s."""
_DENSITY_STEP: Final = 0.02
_LEAST_SAMPLES: Final = 50


class Explainer:
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
        self._known: dict[tuple[int, int], SmallMotions | None] = {}

    def left_over(
        self,
        inputs: Mapping[str, FloatArray],
        answers: Mapping[str, FloatArray],
        main: Collection[str],
        *,
        speed: float,
        density: float,
        noise: NoiseFloor,
    ) -> float | None:
        """Return what the inputs do not explain, as a share of what they do.

        Parameters
        ----------
        inputs : mapping of str to ndarray, shape (n,)
            Surfaces that moved, on purpose or not, from the beginning of the input on, rad.
        main : collection of str
            Those whose answer counts.
        answers : mapping of str to ndarray, shape (n,)
            Channels of `ANSWERS` at the same times, SI.
        speed, density : float
            m/s and kg/m^3.
        noise : NoiseFloor
            What no input can explain, and no gust either.

        Returns
        -------
        float or None
            Root mean square over the channels of the larger of both axes; None where too little
            was measured, or the model does not fly so.
        """
        motions = self._motions(speed, density)
        if motions is None:
            return None
        longitudinal = [name for name in inputs if name == "de"]
        lateral = [name for name in inputs if name != "de"]
        shares = [
            self._share(linear, moved, names, inputs, answers, noise)
            for linear, moved, names in (
                (motions.longitudinal, longitudinal, ANSWERS["longitudinal"]),
                (motions.lateral, lateral, ANSWERS["lateral"]),
            )
            if set(moved) & set(main)
        ]
        known = [share for share in shares if share is not None]
        return max(known) if known else None

    def _motions(self, speed: float, density: float) -> SmallMotions | None:
        key = (round(speed / _SPEED_STEP), round(density / _DENSITY_STEP))
        if key not in self._known:
            try:
                self._known[key] = small_motions(
                    self._aircraft,
                    self._model,
                    speed=key[0] * _SPEED_STEP,
                    density=key[1] * _DENSITY_STEP,
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
    ) -> float | None:
        driven = {name: inputs[name] - inputs[name][0] for name in moved}
        basis = _responses(linear, driven, 1.0 / self._rate)
        measured, columns = [], []
        for name in names:
            samples = answers.get(name)
            if samples is None or np.isfinite(samples).sum() < _LEAST_SAMPLES:
                continue
            measured.append((name, samples))
            columns.append(basis[:, linear.outputs.index(name), :])
        if not measured:
            return None
        fitted = _fit([samples for _, samples in measured], columns)
        squares = []
        for (name, samples), explained in zip(measured, fitted, strict=True):
            there = np.isfinite(samples)
            rest = float(np.var(samples[there] - explained[there])) - noise.of(name) ** 2
            squares.append(max(rest, 0.0) / max(float(np.var(explained)), 1e-12))
        return math.sqrt(sum(squares) / len(squares))


def _responses(linear: LinearModel, driven: Mapping[str, FloatArray], dt: float) -> FloatArray:
    """Return the outputs to each input, and to each state's beginning at one.

    Returns
    -------
    ndarray, shape (n, n_outputs, n_inputs + n_states)
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
    state = np.hstack((np.zeros((size, len(columns))), np.eye(size)))
    found = np.empty((count, size, state.shape[1]))
    found[0] = state
    for row in range(1, count):
        state = step @ state
        state[:, : len(columns)] += push * means[row - 1]
        found[row] = state
    outputs = np.einsum("os,nsb->nob", linear.C, found)
    outputs[:, :, : len(columns)] += np.einsum("oi,ni->noi", linear.D[:, columns], inputs)
    return np.asarray(outputs)


def _fit(measured: list[FloatArray], columns: list[FloatArray]) -> list[FloatArray]:
    """Fit all channels with the same coefficients, and an offset for each; return the fits."""
    weights = [1.0 / max(float(np.nanstd(samples)), 1e-9) for samples in measured]
    count = len(measured)
    rows, sides = [], []
    for place, (samples, own, weight) in enumerate(zip(measured, columns, weights, strict=True)):
        there = np.isfinite(samples)
        offset = np.zeros((int(there.sum()), count))
        offset[:, place] = 1.0
        rows.append(weight * np.hstack((own[there], offset)))
        sides.append(weight * samples[there])
    matrix = np.vstack(rows)
    scale = np.maximum(np.abs(matrix).max(axis=0), 1e-12)
    found = np.linalg.lstsq(matrix / scale, np.concatenate(sides), rcond=1e-6)[0] / scale
    size = columns[0].shape[1]
    return [own @ found[:size] + found[size + place] for place, own in enumerate(columns)]
