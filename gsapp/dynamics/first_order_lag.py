"""What follows its input with a first-order lag: an engine its lever, a hand what it was asked."""

from __future__ import annotations

from itertools import accumulate

import numpy as np

from gsapp.quantities import FloatArray


def filter_first_order(inputs: FloatArray, decay: float, before: float) -> FloatArray:
    """Return what follows inputs that are held between the samples.

    Number by number: a filter by SciPy would load a package that takes a third of a second, which
    a window waits for before its charts stand.

    Parameters
    ----------
    inputs : ndarray, shape (n,)
    decay : float
        exp(-dt / tau), what is left of a step after one sample.
    before : float
        The output one sample before the first.

    Returns
    -------
    ndarray, shape (n,)
        ``(1 - decay) * input + decay * output before`` at every sample.
    """
    steps = ((1.0 - decay) * inputs).tolist()
    outputs = accumulate(steps, lambda output, step: step + decay * output, initial=before)
    next(outputs)
    return np.fromiter(outputs, np.float64, len(steps))
