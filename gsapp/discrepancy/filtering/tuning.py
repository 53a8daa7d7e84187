"""Noise found from the innovations themselves: the filter that makes them whitest.

All intensities and variances are components of one covariance that is linear in them. Each is
multiplied by the ratio of what the innovations hold of it to what they should: the fixed point is
the maximum of the likelihood (H. Zhou et al., MM algorithms for variance components models, J.
Comput. Graph. Stat. 28, 2019). One filter and one smoother pass serve all of them.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gsapp.discrepancy.filtering.fitting import Fit, ManeuverState
from gsapp.discrepancy.filtering.kalman import filter_of
from gsapp.discrepancy.filtering.noise import GUST_ROWS, GUSTS, NoiseModel

_LARGEST_STEP = 6.0
_ABSENT = 0.6
_BOUNDS = (1e-9, 100.0)
_SKIPPED = 5
"""Blocks at the start, which the initial state has used up."""


def tune(fit: Fit, rounds: int = 4) -> None:
    """Tune the noise of every flight of a fit, in place, and filter with it.

    The fit must have been linearized.
    """
    for flight in fit.noise:
        own = [one for one in fit.maneuvers if one.record.flight == flight]
        if own:
            noise = fit.noise[flight]
            for _ in range(rounds):
                noise = _round(fit, own, noise)
            fit.noise[flight] = noise
    fit.refilter()


def _round(fit: Fit, chosen: Sequence[ManeuverState], noise: NoiseModel) -> NoiseModel:
    held: dict[str, float] = {}
    expected: dict[str, float] = {}

    def add(name: str, found: float, usual: float) -> None:
        held[name] = held.get(name, 0.0) + found
        expected[name] = expected.get(name, 0.0) + usual

    for one in chosen:
        assert one.filter is not None
        one.filter = filter_of(one.filter.linearization, noise, one.motion)
        process, measurement = one.filter.adjoints(fit.residual_innovations(one))
        by_process, by_measurement = one.filter.expected()
        steps = slice(_SKIPPED, None)
        n_states = len(one.motion.states)
        V = float(np.mean(one.motion.states[0]))
        for place, (name, row) in enumerate(zip(GUSTS, GUST_ROWS, strict=True)):
            entry = np.zeros(n_states + 3)
            entry[row] = entry[n_states + place] = 1.0 if name == "u" else 1.0 / V
            for way, seen, usual in zip(one.filter.ways, process, by_process, strict=True):
                add(
                    f"gust.{name}",
                    way.weight * float(((seen[steps] @ entry) ** 2).sum()),
                    way.weight * len(seen[steps]) * float(entry @ usual @ entry),
                )
        for row in (3, 4, 5):
            for way, seen, usual in zip(one.filter.ways, process, by_process, strict=True):
                add(
                    "moments",
                    way.weight * float((seen[steps, row] ** 2).sum()),
                    way.weight * len(seen[steps]) * float(usual[row, row]),
                )
        measurement = measurement[steps]
        counted = one.filter.counted[steps]
        for column, name in enumerate(one.record.channels):
            add(
                name,
                float((measurement[counted[:, column], column] ** 2).sum()),
                float(counted[:, column].sum() * by_measurement[column, column]),
            )
    ratios = {
        name: float(np.clip(held[name] / expected[name], 1.0 / _LARGEST_STEP, _LARGEST_STEP))
        for name in held
    }
    variances = {
        name: variance * ratios.get(name, 1.0) for name, variance in noise.variances.items()
    }
    for name in ("gust.u", "gust.v", "gust.w", "moments"):
        # What is not there at all goes the quicker.
        ratio = ratios[name] ** 2 if ratios[name] < _ABSENT else ratios[name]
        value = float(np.clip(noise.value(name) * ratio, *_BOUNDS))
        noise = noise.with_value(name, value)
    return noise.with_variances(variances)
