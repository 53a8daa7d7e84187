"""Where model and flight disagree: which coefficient or instrument, maneuver, time and region.

The best candidate of every place, with or without a name, is sized on all maneuvers together.
What it takes off the innovations of each of them says where the model lacks it most. The filter
has taken turbulence and colored noise into account; residuals of coefficients alone would show
gusts instead.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from typing import Final

import numpy as np
from scipy.stats import chi2

from gsapp.discrepancy.candidates import VIBRATING_CHANNELS
from gsapp.discrepancy.effect_selection import CandidateScreening, log_priors
from gsapp.discrepancy.results import Disagreement, FlightRegion, ManeuverHistories
from gsapp.discrepancy.settings import SEARCH
from gsapp.identification.filter_error.filter_error_fit import FilterErrorFit, InformationMatrix
from gsapp.quantities import FloatArray

_AXES: Final = {"CA": "CX", "CN": "CZ", "thrust": "CX"}
_SURFACES: Final = {"elevator": "Cm", "aileron": "Cl", "rudder": "Cn", "flap": "CZ"}
_MASSES: Final = {
    "cg.x": "Cm", "cg.y": "Cl", "cg.z": "Cm", "mass.error": "CZ",
    "inertia.ixx": "Cl", "inertia.iyy": "Cm", "inertia.izz": "Cn", "inertia.ixz": "Cn",
}  # fmt: skip
_SHARED_SENSOR_CHANNEL: Final = {
    "accelerometer.x": "ax", "accelerometer.y": "ay", "accelerometer.z": "an",
    "air_data.y": "V", "air_data.z": "V", "airdata.delay": "V", "alpha_vane.x": "alpha",
    "alpha_vane.y": "alpha", "boom.x": "alpha", "beta_vane.x": "beta", "beta_vane.z": "beta",
    "attitude.delay": "phi", "inertial.delay": "q", "surfaces.delay": "de",
    "attitude.scale": "phi", "gyros.scale": "p",
}  # fmt: skip
"""Channel that shows most of what several instruments have in common."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelErrorLocation:
    """Where something is missing."""

    coefficient: str  # Body axes; empty for an instrument.
    channel: str  # Of the instrument; empty for a coefficient.
    maneuver: str
    gain: float  # Fall of the sum of squares of this maneuver's innovations.
    p_value: float
    """Chance of as much. Where the place shows most, that of its best candidate among all
    candidates; elsewhere at least that of this maneuver among all."""


def effect_target(competitor: str) -> tuple[str, str]:
    """Return coefficient and channel at which a candidate enters; one of them is empty.

    Its id is that of an effect, or ``unnamed.<coefficient or channel>.<terms>``.
    """
    group, target, *rest = competitor.split(".")
    if group == "unnamed" and target in VIBRATING_CHANNELS:
        return "", target
    kind = ".".join((target, *rest[:1]))
    if group == "control":
        return _SURFACES[target], ""
    if group == "mass":
        return _MASSES[kind], ""
    if group == "sensor":
        return "", _SHARED_SENSOR_CHANNEL.get(kind) or target.split("_")[0]
    return _AXES.get(target, target), ""


def localize_model_errors(
    fit: FilterErrorFit, screening: CandidateScreening
) -> tuple[ModelErrorLocation, ...]:
    """Return, for the best candidate of each coefficient and instrument, what it gains where.

    Those that gain most come first. The screening is of the same fit.
    """
    competitors, temper = screening.candidates, screening.gain_factor
    worth = temper * screening.gain + 2.0 * log_priors(competitors)
    best: dict[tuple[str, str], int] = {}
    for number in np.argsort(-worth, kind="stable"):
        if screening.gain[number] > 0.0:
            best.setdefault(effect_target(competitors[number].id), int(number))
    found = []
    for (coefficient, channel), number in best.items():
        names = (*fit.free, *fit.bias_names(), competitors[number].id)
        overall = len(competitors) * _p_value(temper * float(screening.gain[number]))
        values, _ = screening.full_information.solution(names)
        moves = dict(zip(names, values.tolist(), strict=True))
        gains = {
            maneuver: _gain(part, moves)
            for maneuver, part in screening.maneuver_information.items()
        }
        most = max(gains, key=lambda maneuver: gains[maneuver])
        for maneuver, gain in gains.items():
            here = 0.0 if maneuver == most else len(gains) * _p_value(temper * gain)
            found.append(
                ModelErrorLocation(
                    coefficient=coefficient,
                    channel=channel,
                    maneuver=maneuver,
                    gain=gain,
                    p_value=min(1.0, max(overall, here)),
                )
            )
    return tuple(sorted(found, key=lambda one: -one.gain))


def _gain(part: InformationMatrix, moves: Mapping[str, float]) -> float:
    """Return what one maneuver's sum of squares falls by."""
    own = {name: moves[name] for name in part.names if name in moves}
    return float(part.matrix[-1, -1]) - part.misfit(own)


def _p_value(gain: float) -> float:
    return float(chi2.sf(max(gain, 0.0), 1))


_CHANNELS = {"CX": "ax", "CY": "ay", "CZ": "an", "Cl": "p", "Cm": "q", "Cn": "r"}
_DEGREES = ("alpha", "beta", "de", "da", "dr", "flap")


def coefficient_map(
    shown: Sequence[ManeuverHistories], coefficients: Sequence[str]
) -> tuple[FloatArray, ...]:
    """Return, for each model, the RMS of missing coefficients over their floors.

    Shape (n_maneuvers, n_coefficients); NaN where a coefficient cannot be had.
    """
    steps = len(shown[0].missing) if shown else 0
    return tuple(
        np.array(
            [
                [
                    _rms(one.missing[step][:, k]) / one.coefficient_noise_floor[name]
                    for k, name in enumerate(coefficients)
                ]
                for one in shown
            ]
        )
        for step in range(steps)
    )


def apply_residual_floor(shown: Sequence[ManeuverHistories]) -> tuple[ManeuverHistories, ...]:
    """Return maneuvers whose coefficients have what is left of them as their floor.

    Where nothing more is proven to be missing, the rest is turbulence, and noise in colors that
    the smoothing of coefficients does not take away.
    """
    rest = {
        name: float(np.nanmedian([_rms(one.missing[-1][:, column]) for one in shown]))
        for column, name in enumerate(shown[0].coefficients)
        if any(np.isfinite(one.missing[-1][:, column]).any() for one in shown)
    }
    return tuple(
        replace(
            one,
            coefficient_noise_floor={
                name: max(floor, rest.get(name, 0.0))
                for name, floor in one.coefficient_noise_floor.items()
            },
        )
        for one in shown
    )


def _rms(history: FloatArray) -> float:
    good = history[np.isfinite(history)]
    return float(np.sqrt(np.mean(good**2))) if good.size else float("nan")


def find_disagreements(
    shown: Sequence[ManeuverHistories], found: Sequence[ModelErrorLocation], false_alarm: float
) -> tuple[Disagreement, ...]:
    """Return the places where the baseline lacks more than noise and turbulence explain.

    Those found come the worst first; `false_alarm` is the largest chance that is told.
    """
    views = {one.id: one for one in shown}
    proven = [one for one in found if one.p_value < false_alarm and one.maneuver in views]
    told = (_locate_in_time(views[one.maneuver], one) for one in proven)
    return tuple(islice((one for one in told if one is not None), SEARCH.max_disagreements))


def _locate_in_time(view: ManeuverHistories, place: ModelErrorLocation) -> Disagreement | None:
    """Return a place with the second of its maneuver in which most is missing."""
    if place.coefficient:
        column = view.coefficients.index(place.coefficient)
        history = view.missing[0][:, column]
        floor, channel = (
            view.coefficient_noise_floor[place.coefficient],
            _CHANNELS[place.coefficient],
        )
    elif place.channel in view.channels:
        column, channel = view.channels.index(place.channel), place.channel
        history = view.measured[:, column] - view.computed[0][:, column]
        floor = view.noise_floor[channel]
    else:
        return None
    good = np.isfinite(history)
    if good.sum() < SEARCH.min_samples:
        return None
    dt = float(np.median(np.diff(view.times)))
    width = min(max(2, round(SEARCH.window / dt)), len(history))
    squares = np.where(good, history, 0.0) ** 2
    means = np.convolve(squares, np.ones(width), "valid") / np.maximum(
        np.convolve(good, np.ones(width), "valid"), 1.0
    )
    start = int(np.argmax(means))
    return Disagreement(
        coefficient=place.coefficient,
        channel=channel,
        maneuver=view.id,
        t_start=float(view.times[start]),
        t_end=float(view.times[min(start + width, len(view.times) - 1)]),
        rms=float(np.sqrt(means[start])),
        noise_floor=floor,
        p_value=place.p_value,
        region=_region(view, history),
    )


def _region(one: ManeuverHistories, history: FloatArray) -> FlightRegion | None:
    """Return the variable whose high or low end the missing part gathers at."""
    best: tuple[float, FlightRegion] | None = None
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
                    FlightRegion(
                        variable=variable,
                        low=float(ends[0]),
                        high=float(ends[1]),
                        words=f"{variable} {side} {_format_condition(variable, float(edge))}",
                    ),
                )
    return None if best is None or best[0] < 1.5 else best[1]


def _format_condition(variable: str, value: float) -> str:
    if variable in _DEGREES:
        return f"{np.degrees(value):.1f} deg"
    if variable == "V":
        return f"{value:.1f} m/s"
    return f"{value:.2f}"
