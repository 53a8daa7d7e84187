"""Noise found from the innovations themselves: the filter that makes them whitest.

All intensities and variances are components of one covariance that is linear in them. Each is
multiplied by the ratio of what the innovations hold of it to what they should: the fixed point is
the maximum of the likelihood (H. Zhou et al., MM algorithms for variance components models, J.
Comput. Graph. Stat. 28, 2019). One filter and one smoother pass serve all of them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from gsapp.identification.filter_error.filter_error_fit import FilterErrorFit
from gsapp.identification.filter_error.maneuver_state import ManeuverState
from gsapp.identification.filter_error.noise_model import NoiseModel
from gsapp.identification.filter_error.settings import FILTER_ERROR

ActivityCallback = Callable[[str], None]
"""Told what is being done."""


def fit_to_convergence(
    fit: FilterErrorFit, passes: int, tick: ActivityCallback, doing: str, *, fresh: bool = False
) -> None:
    """Fit a model, and its noise with it, in place; what is fresh is moved once before."""
    for number in range(passes):
        tick(doing)
        fit.linearize()
        if number or not fresh:
            tune_noise(fit, rounds=FILTER_ERROR.noise_rounds)
        move = fit.apply_step(fit.information())
        if number > 1 and move < FILTER_ERROR.converged_step:
            break
    fit.linearize()
    tune_noise(fit, rounds=FILTER_ERROR.noise_rounds)


def tune_noise(fit: FilterErrorFit, rounds: int = 4) -> None:
    """Tune the noise of every flight of a fit, in place, and filter with it.

    The fit must have been linearized.
    """
    for flight in fit.noise:
        own = [one for one in fit.maneuvers if one.record.flight == flight]
        if own:
            noise = fit.noise[flight]
            for _ in range(rounds):
                noise = _update_variances(fit, own, noise)
            fit.noise[flight] = noise
    fit.refilter()


def select_noise_correlation(fit: FilterErrorFit, rounds: int) -> None:
    """Decide, in place, whether the noise of instruments is colored; the fit was linearized.

    What looks like it may be turbulence. So it is tried as it looks, with the instruments that
    turbulence reaches like the others, with those white, and all white; the most likely one stays.
    """
    first = fit.noise
    if not any(one.correlations for one in first.values()):
        return
    best, least = first, np.inf
    tried: list[dict[str, dict[str, float]]] = []
    for shape in _CORRELATION_HYPOTHESES:
        wanted = {name: shape(one) for name, one in first.items()}
        if any(_is_near_tried(wanted, one) for one in tried):
            continue
        tried.append(wanted)
        fit.noise = {name: replace(one, correlations=wanted[name]) for name, one in first.items()}
        tune_noise(fit, rounds)
        cost = fit.deviance()
        if cost < least:
            best, least = fit.noise, cost
    fit.noise = dict(best)
    fit.refilter()
    for _ in range(FILTER_ERROR.correlation_updates):
        _update_correlations(fit)
        tune_noise(fit, 1)
    _trycommon_correlation(fit, rounds)


def _trycommon_correlation(fit: FilterErrorFit, rounds: int) -> None:
    """Give all colored channels the same correlation, in place, unless their own explain more.

    One recorder's filter colors them all. In turbulence the smoother takes some of the flow's own
    changes for color, and a color that is too slow takes what an effect would show.
    """
    own, cost = fit.noise, fit.deviance()
    colored = {name: noise.correlations for name, noise in own.items() if noise.correlations}
    if not colored:
        return
    fit.noise = dict(own)
    for flight, correlations in colored.items():
        steady = [value for name, value in correlations.items() if name in _ATTITUDE_CHANNELS]
        usual = float(np.median(steady or [*correlations.values()]))
        same = dict.fromkeys(correlations, usual)
        fit.noise[flight] = replace(own[flight], correlations=same)
    tune_noise(fit, rounds)
    saved = sum(len(correlations) - 1 for correlations in colored.values())
    if fit.deviance() > cost + FILTER_ERROR.aic_penalty * saved:
        fit.noise = own
        fit.refilter()


def _is_near_tried(
    wanted: Mapping[str, Mapping[str, float]], tried: Mapping[str, Mapping[str, float]]
) -> bool:
    """Return whether correlations are so near to others that the smoother leads from there."""
    return all(
        own.keys() == tried[flight].keys()
        and all(
            abs(value - tried[flight][name]) < FILTER_ERROR.correlation_tolerance
            for name, value in own.items()
        )
        for flight, own in wanted.items()
    )


def _measured_correlations(noise: NoiseModel) -> dict[str, float]:
    return dict(noise.correlations)


def common_correlation(noise: NoiseModel) -> dict[str, float]:
    """Return correlations where channels that feel turbulence have that of the others."""
    steady = [name for name in _ATTITUDE_CHANNELS if name in noise.variances]
    usual = float(np.median([noise.correlations.get(name, 0.0) for name in steady] or [0.0]))
    found = _steady_only(noise)
    if usual > 0.0:
        found |= {name: usual for name in noise.correlations if name not in _ATTITUDE_CHANNELS}
    return found


def _steady_only(noise: NoiseModel) -> dict[str, float]:
    return {name: value for name, value in noise.correlations.items() if name in _ATTITUDE_CHANNELS}


def _white(_: NoiseModel) -> dict[str, float]:
    return {}


_ATTITUDE_CHANNELS = ("p", "q", "r", "phi", "theta")
"""Channels that turbulence reaches through the motion of the aircraft only."""
_CORRELATION_HYPOTHESES = (_measured_correlations, common_correlation, _steady_only, _white)


def _update_correlations(fit: FilterErrorFit) -> None:
    """Move the correlation of colored noise, in place, to what the smoother sees of it."""
    for flight, noise in fit.noise.items():
        found: dict[str, list[float]] = {}
        for one in fit.maneuvers:
            if one.record.flight != flight or not len(one.current_filter.colors.channel_indices):
                continue
            own = one.current_filter
            z, b, _ = own.residual(fit.bias_of(one.record))
            kept = np.clip(
                own.smoothed_decay(z, b), FILTER_ERROR.min_correlation**own.block_size, 1.0
            )
            for place, share in zip(
                own.colors.channel_indices, kept ** (1.0 / own.block_size), strict=True
            ):
                found.setdefault(one.record.channels[place], []).append(float(share))
        moved = {
            name: min(float(np.median(values)), FILTER_ERROR.max_correlation)
            for name, values in found.items()
        }
        fit.noise[flight] = replace(noise, correlations={**noise.correlations, **moved})


def _update_variances(
    fit: FilterErrorFit, chosen: Sequence[ManeuverState], noise: NoiseModel
) -> NoiseModel:
    found: dict[str, list[float]] = {}
    for one in chosen:
        own = one.filter = one.current_filter.with_noise(noise)
        held: dict[str, float] = {}
        expected: dict[str, float] = {}
        seen_of, usual_of = own.adjoints(fit.residual_innovations(one)), own.expected_adjoints()
        steps = slice(FILTER_ERROR.skipped_blocks, None)
        gusts, n_x = own.blocks.gusts, len(own.blocks.scales)
        entries = np.zeros((len(gusts.names) + len(own.blocks.moment_rows), n_x))
        entries[: len(gusts.names), : gusts.entries.shape[1]] = gusts.entries
        entries[range(len(gusts.names), len(entries)), own.blocks.moment_rows] = 1.0
        names = [f"gust.{name}" for name in gusts.names]
        names += ["moments"] * len(own.blocks.moment_rows)
        for name, entry in zip(names, entries, strict=True):
            for way, seen, usual in zip(
                own.blocks.noise_gains, seen_of.process, usual_of.process, strict=True
            ):
                _add(
                    held,
                    expected,
                    name,
                    way.weight * float(((seen[steps] @ entry) ** 2).sum()),
                    way.weight * len(seen[steps]) * float(entry @ usual @ entry),
                )
        counted = own.valid[steps]
        measurement = seen_of.measurement[steps]
        for column, name in enumerate(one.record.channels):
            white = (
                1.0 if name not in noise.correlations else FILTER_ERROR.white_share / own.block_size
            )
            _add(
                held,
                expected,
                name,
                white * float((measurement[counted[:, column], column] ** 2).sum()),
                white * float(counted[:, column].sum() * usual_of.measurement[column, column]),
            )
        for color, column in enumerate(own.colors.channel_indices):
            here = counted[: len(seen_of.colors) - FILTER_ERROR.skipped_blocks, column]
            _add(
                held,
                expected,
                one.record.channels[column],
                float((seen_of.colors[steps][here, color] ** 2).sum()),
                float(here.sum() * usual_of.colors[color].sum()),
            )
        for name, size in expected.items():
            if size > 0.0:
                found.setdefault(name, []).append(held[name] / size)
    # The median over maneuvers: one that stalled, or was invalid, says nothing of the air.
    ratios = {
        name: float(
            np.clip(
                np.median(values), 1.0 / FILTER_ERROR.max_noise_step, FILTER_ERROR.max_noise_step
            )
        )
        for name, values in found.items()
    }
    moves = {name: _relaxed_ratio(ratio) for name, ratio in ratios.items()}
    variances = {
        name: variance * moves.get(name, 1.0) for name, variance in noise.variances.items()
    }
    for name in moves.keys() - variances.keys():
        noise = noise.with_value(
            name,
            float(np.clip(noise.value(name) * moves[name], *FILTER_ERROR.intensity_bounds)),
        )
    return noise.with_variances(variances)


def _relaxed_ratio(ratio: float) -> float:
    """Return by what a component is multiplied: up with care, down with haste.

    Its root is sure to raise the likelihood, and slow; what is hardly there at all would take
    very many rounds to go.
    """
    if ratio > 1.0:
        return float(ratio**FILTER_ERROR.increase_exponent)
    return float(ratio**FILTER_ERROR.decrease_exponent)


def _add(
    held: dict[str, float], expected: dict[str, float], name: str, found: float, usual: float
) -> None:
    held[name] = held.get(name, 0.0) + found
    expected[name] = expected.get(name, 0.0) + usual
