"""Where structure is missing: for each coefficient and instrument, and each maneuver by itself.

The best candidate of every place, with or without a name, is sized on all maneuvers together.
What it takes off the innovations of each of them says where the model lacks it most. The filter
has taken turbulence and colored noise into account; residuals of coefficients alone would show
gusts instead.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.stats import chi2

from gsapp.discrepancy.effect_selection import log_priors
from gsapp.discrepancy.screening import CandidateScreening
from gsapp.discrepancy.unnamed_effects import VIBRATING_CHANNELS
from gsapp.identification.filter_error.filter_error_fit import FilterErrorFit
from gsapp.identification.filter_error.information_matrix import InformationMatrix

_AXES: Final = {"CA": "CX", "CN": "CZ", "thrust": "CX"}
_SURFACES: Final = {"elevator": "Cm", "aileron": "Cl", "rudder": "Cn", "flap": "CZ"}
_MASSES: Final = {
    "cg.x": "Cm", "cg.y": "Cl", "cg.z": "Cm", "mass.error": "CZ",
    "inertia.ixx": "Cl", "inertia.iyy": "Cm", "inertia.izz": "Cn", "inertia.ixz": "Cn",
}  # fmt: skip
_SHARED_SENSOR_CHANNEL: Final = {
    "accelerometer.x": "ax", "accelerometer.y": "ay", "accelerometer.z": "an",
    "air_data.y": "V", "air_data.z": "V", "airdata.delay": "V", "alpha_vane.x": "alpha",
    "alpha_vane.y": "alpha", "beta_vane.x": "beta", "beta_vane.z": "beta",
    "attitude.delay": "phi", "inertial.delay": "q", "surfaces.delay": "de",
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

    Parameters
    ----------
    competitor : str
        Id of an effect, or ``unnamed.<coefficient or channel>.<terms>``.
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

    Those that gain most come first.

    Parameters
    ----------
    fit : FilterErrorFit
    screening : CandidateScreening
        Of the same fit.
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
