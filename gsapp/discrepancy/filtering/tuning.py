"""Noise found from the innovations themselves: the filter that makes them whitest.

All intensities and variances are components of one covariance that is linear in them. Each is
multiplied by the ratio of what the innovations hold of it to what they should: the fixed point is
the maximum of the likelihood (H. Zhou et al., MM algorithms for variance components models, J.
Comput. Graph. Stat. 28, 2019). One filter and one smoother pass serve all of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from gsapp.discrepancy.filtering.fitting import Fit
from gsapp.discrepancy.filtering.noise import GUST_ROWS, GUSTS, NoiseModel
from gsapp.discrepancy.filtering.passing import ManeuverState

_LARGEST_STEP = 6.0
_UP, _DOWN = 0.6, 2.0
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


def choose_colors(fit: Fit, rounds: int) -> None:
    """Decide, in place, whether the noise of instruments is colored; the fit was linearized.

    What looks like it may be turbulence. So both are tuned, and the more likely one stays.
    """
    if not any(one.correlations for one in fit.noise.values()):
        return
    tune(fit, rounds)
    colored, with_colors = dict(fit.noise), _cost_each(fit)
    fit.noise = {name: replace(one, correlations={}) for name, one in colored.items()}
    fit.refilter()
    tune(fit, rounds)
    if _cost_each(fit) > with_colors:
        fit.noise = colored
        fit.refilter()


def _cost_each(fit: Fit) -> float:
    """Return minus two log likelihoods per block: colored noise leaves one block less."""
    blocks = sum(len(one.filtered.compared) for one in fit.maneuvers)
    return fit.cost() / max(blocks, 1)


def _round(fit: Fit, chosen: Sequence[ManeuverState], noise: NoiseModel) -> NoiseModel:
    found: dict[str, list[float]] = {}
    for one in chosen:
        own = one.filter = one.filtered.with_noise(noise)
        held: dict[str, float] = {}
        expected: dict[str, float] = {}
        process, measurement = own.adjoints(fit.residual_innovations(one))
        by_process, by_measurement = own.expected()
        steps = slice(_SKIPPED, None)
        n_states = len(one.motion.states)
        V = float(np.mean(one.motion.states[0]))
        for place, (name, row) in enumerate(zip(GUSTS, GUST_ROWS, strict=True)):
            entry = np.zeros(n_states + 3)
            entry[row] = entry[n_states + place] = 1.0 if name == "u" else 1.0 / V
            for way, seen, usual in zip(own.ways, process, by_process, strict=True):
                _add(
                    held,
                    expected,
                    f"gust.{name}",
                    way.weight * float(((seen[steps] @ entry) ** 2).sum()),
                    way.weight * len(seen[steps]) * float(entry @ usual @ entry),
                )
        for row in (3, 4, 5):
            for way, seen, usual in zip(own.ways, process, by_process, strict=True):
                _add(
                    held,
                    expected,
                    "moments",
                    way.weight * float((seen[steps, row] ** 2).sum()),
                    way.weight * len(seen[steps]) * float(usual[row, row]),
                )
        measurement = measurement[steps]
        counted = own.compared_counted[steps]
        for column, name in enumerate(one.record.channels):
            _add(
                held,
                expected,
                name,
                float((measurement[counted[:, column], column] ** 2).sum()),
                float(counted[:, column].sum() * by_measurement[column, column]),
            )
        for name, size in expected.items():
            if size > 0.0:
                found.setdefault(name, []).append(held[name] / size)
    # The median over maneuvers: one that stalled, or was spoiled, says nothing of the air.
    ratios = {
        name: float(np.clip(np.median(values), 1.0 / _LARGEST_STEP, _LARGEST_STEP))
        for name, values in found.items()
    }
    moves = {name: _relaxed(ratio) for name, ratio in ratios.items()}
    variances = {
        name: variance * moves.get(name, 1.0) for name, variance in noise.variances.items()
    }
    for name in ("gust.u", "gust.v", "gust.w", "moments"):
        noise = noise.with_value(
            name, float(np.clip(noise.value(name) * moves.get(name, 1.0), *_BOUNDS))
        )
    return noise.with_variances(variances)


def _relaxed(ratio: float) -> float:
    """Return by what a component is multiplied: up with care, down with haste.

    Its root is sure to raise the likelihood, and slow; what is hardly there at all would take
    very many rounds to go.
    """
    if ratio > 1.0:
        return float(ratio**_UP)
    return float(ratio**_DOWN)


def _add(
    held: dict[str, float], expected: dict[str, float], name: str, found: float, usual: float
) -> None:
    held[name] = held.get(name, 0.0) + found
    expected[name] = expected.get(name, 0.0) + usual
