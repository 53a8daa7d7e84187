"""The settings of a run in words, each by its name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

from gsapp.identification.axes import Axis
from gsapp.identification.results import EstimationMethod
from gsapp.identification.runs.request import RunRequest

METHOD_TEXT: Final[Mapping[EstimationMethod, str]] = {
    "ml": "maximum likelihood",
    "ee": "equation error",
    "ftr": "Fourier transform regression",
}
"""Methods of estimation in words."""

AXIS_TEXT: Final[Mapping[Axis, str]] = {
    "lon": "longitudinal",
    "lat": "lateral",
    "both": "each maneuver by the surfaces it moved",
}
"""Axes in words."""

_DIGITS: Final = 6
"""Enough for people; all of them tell settings apart that look alike."""

_NONE_TEXT: Final = "none"


def describe_settings(request: RunRequest, *, digits: int = _DIGITS) -> dict[str, str]:
    """Return every setting of a run in words, by its name; maneuvers and flights are none.

    Parameters
    ----------
    request : RunRequest
    digits : int
        Significant digits of numbers.
    """
    settings, fit = request.settings, request.settings.likelihood
    model = settings.model

    def number(value: float) -> str:
        return f"{value:.{digits}g}"

    def values(found: Mapping[str, float], otherwise: str = _NONE_TEXT) -> str:
        return ", ".join(f"{name} {number(one)}" for name, one in found.items()) or otherwise

    def names(found: Sequence[str] | None, otherwise: str) -> str:
        return otherwise if found is None else ", ".join(found) or _NONE_TEXT

    weights = "; ".join(
        f"{flight or 'others'}: {values(found, 'from the residuals')}"
        for flight, found in (settings.weights or {"": fit.weights or {}}).items()
    )
    priors = ", ".join(
        f"{name} {number(value)} ± {number(std)}" for name, (value, std) in fit.priors.items()
    )
    return {
        "method": METHOD_TEXT[settings.method],
        "axis": "all six degrees of freedom" if settings.six_degrees else AXIS_TEXT[settings.axis],
        "all maneuvers together": "fitted too" if settings.joint else "not fitted",
        "left out of the means": names(request.without, _NONE_TEXT),
        "free": names(settings.free, "those of the surfaces moved (tables 6.2.5 and 6.2.6)"),
        "free parameters of effects": names(fit.free_effects, _NONE_TEXT),
        "held": values(settings.held),
        "weights": weights if settings.weights or fit.weights else "from the residuals",
        "model": _NONE_TEXT if model is None else model.name,
        "states": names(fit.states, "those of the axis"),
        "responses": names(fit.responses, "those of the axis"),
        "a-priori values": priors or _NONE_TEXT,
        "start values": values(fit.start, "from equation error"),
        "sensor biases": names(fit.biases, "those of the axis"),
        "scale factors": names(fit.scale_factors, _NONE_TEXT),
        "time shifts": names(fit.time_shifts, _NONE_TEXT),
        "initial states": "free" if fit.initial_states else "as measured",
        "stand-ins": values(fit.stand_ins),
        "noise of the responses": "independent" if fit.noise == "diagonal" else "correlated",
        "bounds": "corrected for colored residuals"
        if fit.bound_factor is None
        else f"Cramer-Rao times {number(fit.bound_factor)}",
        "integration": "Runge and Kutta, fourth order" if fit.integration == "rk4" else "Euler",
        "airspeed low-pass": "by itself"
        if fit.airspeed_cutoff is None
        else f"{number(fit.airspeed_cutoff)} Hz",
        "lags of the residuals": "by itself" if fit.lags is None else str(fit.lags),
        "stops": f"below {number(fit.tolerance)} of the cost, or after {fit.max_iterations} rounds",
        "restart": f"from pieces of {number(fit.restart)} s where it diverges",
        "aircraft": request.aircraft or "that of each flight",
        "channel map": request.channel_map or "that of each flight",
        "certificates": request.calibration or "those kept with the flights",
    }


def setting_differences(one: RunRequest, other: RunRequest) -> tuple[tuple[str, str, str], ...]:
    """Return the settings in which two runs differ: name, the one's, the other's in words."""
    exact = describe_settings(one, digits=17), describe_settings(other, digits=17)
    short = describe_settings(one), describe_settings(other)
    found = []
    for name in exact[0]:
        if exact[0][name] != exact[1][name]:
            words = short if short[0][name] != short[1][name] else exact
            found.append((name, words[0][name], words[1][name]))
    if one.settings.model != other.settings.model and not any(row[0] == "model" for row in found):
        found.append(("model", "its values", "other values of the same name"))
    return tuple(found)
