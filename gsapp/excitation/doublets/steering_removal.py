"""An input that was made while its stick was still steering: where the input itself begins."""

from __future__ import annotations

from typing import Final

import numpy as np

from gsapp.flight.maneuvers.input_shape import LOOK_BACK, SurfaceInput, measure_surface_input
from gsapp.quantities import FloatArray

_APART: Final = 0.05
"""Seconds without a quick move between two steps."""
_SHARE: Final = 0.5
"""Of what went before it that an input reaches at least: a part of a larger one is none."""


def remove_steering(
    one: SurfaceInput,
    kind: str,
    times: FloatArray,
    samples: FloatArray,
    span: tuple[float, float],
    threshold: float,
    noise: float,
) -> SurfaceInput:
    """Return the input that was expected, where steering ran into it; else what was measured.

    Parameters
    ----------
    one : SurfaceInput
        Measured from the first quick move on, and of another shape than expected.
    kind : str
        Shape expected.
    times, samples : ndarray, shape (n,)
        Of its surface, s and rad.
    span : tuple of float
        First and last quick move of the surface, s.
    threshold : float
        Of a quick move, rad.
    noise : float
        Standard deviation of the surface's signal, rad.
    """
    for begin in _steps(times, samples, span, threshold):
        later = measure_surface_input(one.surface, times, samples, begin, span[1], noise)
        if later is None or later.kind != kind or later.max_step < threshold:
            continue
        if later.amplitude > max(_SHARE * one.amplitude, later.motion_before):
            return later
    return one


def _steps(
    times: FloatArray, samples: FloatArray, span: tuple[float, float], threshold: float
) -> list[float]:
    """Return when each quick move after the first one began, s."""
    dt = float(np.median(np.diff(times)))
    lag = max(round(LOOK_BACK / dt), 1)
    moves = np.zeros(times.size)
    moves[lag:] = np.abs(samples[lag:] - samples[:-lag])
    inside = (times >= span[0]) & (times <= span[1])
    quick = times[inside & (np.nan_to_num(moves) > threshold)]
    return [float(at) for at in quick[1:][np.diff(quick) > _APART]]
