"""From a run to the panel that asks for it again. No Qt."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gsapp.identification.axes import axis_derivatives
from ui.estimate_form import DerivativeEntry, EstimateForm
from ui.review.estimate_request import build_run_request, is_effect_parameter

if TYPE_CHECKING:
    from gsapp.identification.runs.request import RunRequest


def form_from_request(request: RunRequest) -> EstimateForm:
    """Return the panel as it must stand to ask for a run again."""
    settings, fit = request.settings, request.settings.likelihood
    derivatives: dict[str, DerivativeEntry] = {}
    effects = {
        *fit.free_effects,
        *filter(is_effect_parameter, (*settings.held, *fit.start, *fit.priors)),
    }
    for name in (*axis_derivatives("both"), *sorted(effects)):
        wish = DerivativeEntry(
            treated="held"
            if name in settings.held
            else "free"
            if name in (*(settings.free or ()), *fit.free_effects)
            else "tables",
            value=_text(settings.held.get(name)),
            start=_text(fit.start.get(name)),
            prior=_text(fit.priors[name][0]) if name in fit.priors else "",
            deviation=_text(fit.priors[name][1]) if name in fit.priors else "",
        )
        if wish != DerivativeEntry():
            derivatives[name] = wish
    return EstimateForm(
        axis=settings.axis,
        method=settings.method,
        six_degrees=settings.six_degrees,
        joint=settings.joint,
        derivatives=derivatives,
        weights=request.weights,
        noise=fit.noise,
        integration=fit.integration,
        bound_factor=_text(fit.bound_factor),
        responses=fit.responses,
        biases=fit.biases,
        states=fit.states,
        scale_factors=tuple(fit.scale_factors),
        time_shifts=tuple(fit.time_shifts),
        stand_ins=", ".join(f"{name}={value!r}" for name, value in fit.stand_ins.items()),
        model=request.model,
        aircraft=request.aircraft,
        calibration=request.calibration,
        channel_map=request.channel_map,
    )


def find_unrestored_settings(request: RunRequest, wishes: EstimateForm) -> tuple[str, ...]:
    """Return the names of the settings of a run that the panel cannot ask for again."""
    from gsapp.identification.runs.settings_text import setting_differences

    again = build_run_request(wishes, request.flights, request.maneuvers)
    # Read from their files anew, these stand in the settings of the run only.
    read = {name for name in ("weights", "model") if getattr(request, name)}
    return tuple(name for name, *_ in setting_differences(request, again) if name not in read)


def _text(value: float | None) -> str:
    """Return a number so that reading it gives it again to the last bit."""
    return "" if value is None else repr(float(value))
