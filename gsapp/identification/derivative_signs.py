"""Which signs of an estimate look wrong: a reversed surface, gyro, vane or accelerometer.

A reversed channel turns a whole pattern of derivatives over. A reversed pitch gyro leaves Cm_q
alone (both sides change) but turns over Cm_alpha and Cm_de; a reversed elevator turns over Cm_de
only; a reversed alpha vane Cm_alpha and CN_alpha. So the channel is named whose pattern fits.
"""

from __future__ import annotations

from collections.abc import Mapping

from gsapp.dynamics.model import Model
from gsapp.dynamics.trim import find_suspect_signs
from gsapp.identification.preparation_settings import PREPARATION
from gsapp.identification.results import Estimate

_USUAL_SIGNS: Mapping[str, int] = {
    "CN_alpha": 1,
    "CN_de": 1,
    "Cm_alpha": -1,
    "Cm_q": -1,
    "Cm_de": -1,
    "CY_beta": -1,
    "CY_dr": 1,
    "Cl_beta": -1,
    "Cl_p": -1,
    "Cl_da": 1,
    "Cn_beta": 1,
    "Cn_r": -1,
    "Cn_dr": -1,
}
"""Signs that an aircraft of the usual layout has."""
_UNCERTAIN_SIGNS = frozenset({"CN_de", "CY_dr", "Cl_beta"})
"""These may differ on a sound aircraft: they tell channels apart, but raise no alarm alone."""
_REVERSED_PATTERNS: Mapping[str, tuple[str, ...]] = {
    "elevator (de)": ("Cm_de", "CN_de"),
    "aileron (da)": ("Cl_da",),
    "rudder (dr)": ("Cn_dr", "CY_dr"),
    "angle of attack (alpha)": ("CN_alpha", "Cm_alpha"),
    "sideslip (beta)": ("CY_beta", "Cl_beta", "Cn_beta"),
    "roll rate (p)": ("Cl_beta", "Cl_da"),
    "pitch rate (q)": ("Cm_alpha", "Cm_de"),
    "yaw rate (r)": ("Cn_beta", "Cn_dr"),
    "normal acceleration (an)": ("CN_alpha", "CN_de"),
    "side acceleration (ay)": ("CY_beta", "CY_dr"),
}
"""By channel: the derivatives whose sign changes when it is reversed."""


def suspicious_signs(estimate: Estimate) -> tuple[str, ...]:
    """Return which channels, or else derivatives, look reversed; one sentence each.

    `estimate`: by any method. Only derivatives three standard deviations from zero are judged.
    """
    values = _significant_derivatives(estimate)
    wrong = {name for name, value in values.items() if value * _USUAL_SIGNS[name] < 0.0}
    right = values.keys() - wrong
    found = []
    while wrong - _UNCERTAIN_SIGNS:
        # The channel that explains most, and would spoil nothing that is right.
        fitting = [
            (len(wrong.intersection(turned)), channel)
            for channel, turned in _REVERSED_PATTERNS.items()
            if wrong.intersection(turned) - _UNCERTAIN_SIGNS and right.isdisjoint(turned)
        ]
        if not fitting:
            break
        most = max(count for count, _ in fitting)
        channels = [channel for count, channel in fitting if count == most]
        turned = sorted(wrong.intersection(*(_REVERSED_PATTERNS[one] for one in channels)))
        if not turned:
            turned = sorted(wrong.intersection(_REVERSED_PATTERNS[channels[0]]))
            channels = channels[:1]
        numbers = " and ".join(f"{name} = {values[name]:.3g}" for name in turned)
        found.append(
            f"the sign of {' or of '.join(channels)} appears wrong: {numbers} "
            f"{'has' if len(turned) == 1 else 'have'} the opposite sign on every usual aircraft"
        )
        wrong -= set(turned)
    rest = {name: values[name] for name in wrong}
    return (*found, *find_suspect_signs(Model(derivatives=rest)))


def _significant_derivatives(estimate: Estimate) -> dict[str, float]:
    """Return the derivatives whose sign is known."""
    found = {}
    for name, one in estimate.derivatives.items():
        if (
            name not in _USUAL_SIGNS
            or one.value is None
            or not one.std
            or one.status != "estimated"
        ):
            continue
        if abs(one.value) > PREPARATION.sign_sigmas * one.std:
            found[name] = one.value
    return found
