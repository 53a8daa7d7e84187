"""Where model and flight disagree: which coefficient, maneuver, time and region."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.stats import chi2

from gsapp.discrepancy.results import Disagreement, ManeuverView, Region
from gsapp.quantities import FloatArray

_WINDOW = 1.0
"""Length of the stretches looked at, s."""
_BANDWIDTH = 3.0
"""Of the reconstructed coefficients, Hz: twice this many independent samples a second."""
_MARGIN = 1.3
"""The noise floor of a reconstructed coefficient is known to about this factor."""
_CHANNELS = {"CX": "ax", "CY": "ay", "CZ": "an", "Cl": "p", "Cm": "q", "Cn": "r"}
_DEGREES = ("alpha", "beta", "de", "da", "dr", "flap")
_MOST = 30


def coefficient_map(
    shown: Sequence[ManeuverView], coefficients: Sequence[str]
) -> tuple[FloatArray, ...]:
    """Return, for each model, the RMS of missing coefficients over their floors.

    Returns
    -------
    tuple of ndarray, shape (n_maneuvers, n_coefficients)
        NaN where a coefficient cannot be had.
    """
    steps = len(shown[0].missing) if shown else 0
    return tuple(
        np.array(
            [
                [
                    _rms(one.missing[step][:, k]) / one.coefficient_floor[name]
                    for k, name in enumerate(coefficients)
                ]
                for one in shown
            ]
        )
        for step in range(steps)
    )


def _rms(history: FloatArray) -> float:
    good = history[np.isfinite(history)]
    return float(np.sqrt(np.mean(good**2))) if good.size else float("nan")


def disagreements(
    shown: Sequence[ManeuverView], coefficients: Sequence[str], false_alarm: float
) -> tuple[Disagreement, ...]:
    """Return the places where the baseline lacks more than noise explains, worst first.

    Every stretch of a second is tested against the floor with as many independent samples as the
    bandwidth holds; p-values count all stretches looked at (Bonferroni).
    """
    looked_at = sum(
        max(1, int((one.times[-1] - one.times[0]) / _WINDOW)) * len(coefficients) for one in shown
    )
    found = []
    for one in shown:
        for column, name in enumerate(coefficients):
            worst = _worst(one, column, name, looked_at)
            if worst is not None and worst.p_value < false_alarm:
                found.append(worst)
    found.sort(key=lambda one: (one.p_value, -one.rms / one.noise_floor))
    return tuple(found[:_MOST])


def _worst(one: ManeuverView, column: int, name: str, looked_at: int) -> Disagreement | None:
    history = one.missing[0][:, column]
    good = np.isfinite(history)
    if good.sum() < 10:
        return None
    dt = float(np.median(np.diff(one.times)))
    width = max(2, round(_WINDOW / dt))
    squares = np.where(good, history, 0.0) ** 2
    means = np.convolve(squares, np.ones(width), "valid") / np.maximum(
        np.convolve(good, np.ones(width), "valid"), 1.0
    )
    floor = one.coefficient_floor[name]
    start = int(np.argmax(means))
    independent = 2.0 * _BANDWIDTH * _WINDOW
    statistic = independent * float(means[start]) / (_MARGIN * floor) ** 2
    p_value = min(1.0, looked_at * float(chi2.sf(statistic, independent)))
    return Disagreement(
        coefficient=name,
        channel=_CHANNELS[name],
        maneuver=one.id,
        t_start=float(one.times[start]),
        t_end=float(one.times[min(start + width, len(one.times) - 1)]),
        rms=float(np.sqrt(means[start])),
        noise_floor=floor,
        p_value=p_value,
        region=_region(one, history),
    )


def _region(one: ManeuverView, history: FloatArray) -> Region | None:
    """Return the variable whose high or low end the missing part gathers at."""
    best: tuple[float, Region] | None = None
    size = np.abs(history)
    for variable, values in one.conditions.items():
        good = np.isfinite(size) & np.isfinite(values)
        if good.sum() < 20 or np.ptp(values[good]) <= 0.0:
            continue
        low, high = np.quantile(values[good], (0.2, 0.8))
        if high <= low:
            continue
        for side, inside in (("above", values > high), ("below", values < low)):
            part, rest = size[good & inside], size[good & ~inside]
            if part.size < 10 or rest.size < 10:
                continue
            ratio = float(np.mean(part) / max(np.mean(rest), 1e-12))
            if best is None or ratio > best[0]:
                edge = high if side == "above" else low
                ends = (edge, float(values[good].max()))
                if side == "below":
                    ends = (float(values[good].min()), edge)
                best = (
                    ratio,
                    Region(
                        variable=variable,
                        low=float(ends[0]),
                        high=float(ends[1]),
                        words=f"{variable} {side} {_shown(variable, float(edge))}",
                    ),
                )
    return None if best is None or best[0] < 1.5 else best[1]


def _shown(variable: str, value: float) -> str:
    if variable in _DEGREES:
        return f"{np.degrees(value):.1f} deg"
    if variable == "V":
        return f"{value:.1f} m/s"
    return f"{value:.2f}"
