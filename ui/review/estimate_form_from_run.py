"""From a stored run to the form that asks for it again. No Qt."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from gsapp.identification.axes import axis_derivatives
from gsapp.identification.estimate_settings import EstimateSettings
from ui.estimate_form import DerivativeEntry, EstimateForm
from ui.review.estimate_request import build_run_request, is_effect_parameter

if TYPE_CHECKING:
    from gsapp.identification.runs.request import RunRequest

_OTHER_FIELDS: Final = frozenset(
    ("free", "free_effects", "held", "start", "priors", "bound_factor", "stand_ins", "label",
     "maneuver_windows", "every_grade", "as_found")
)  # fmt: skip
"""Settings that the form holds in another way, or not at all."""


def form_from_request(request: RunRequest) -> EstimateForm:
    """Return the form as it must stand to ask for a run again."""
    derivatives: dict[str, DerivativeEntry] = {}
    effects = {
        *request.free_effects,
        *filter(is_effect_parameter, (*request.held, *request.start, *request.priors)),
    }
    for name in (*axis_derivatives("both"), *sorted(effects)):
        entry = DerivativeEntry(
            treated="held"
            if name in request.held
            else "free"
            if name in (*(request.free or ()), *request.free_effects)
            else "tables",
            value=_text(request.held.get(name)),
            start=_text(request.start.get(name)),
            prior=_text(request.priors[name][0]) if name in request.priors else "",
            deviation=_text(request.priors[name][1]) if name in request.priors else "",
        )
        if entry != DerivativeEntry():
            derivatives[name] = entry
    same = {
        name: getattr(request, name)
        for name in EstimateSettings.model_fields
        if name not in _OTHER_FIELDS
    }
    return EstimateForm(
        **same,
        derivatives=derivatives,
        bound_factor=_text(request.bound_factor),
        stand_ins=", ".join(f"{name}={value!r}" for name, value in request.stand_ins.items()),
    )


def find_unrestored_settings(request: RunRequest, form: EstimateForm) -> tuple[str, ...]:
    """Return the titles of the settings of a run that the form cannot ask for again."""
    from gsapp.identification.runs.request import setting_differences, setting_title

    again = build_run_request(form, request.flights, request.maneuvers)
    # Read from their files anew, these stand in the settings of the run only.
    read = {setting_title(name) for name in ("weights", "model") if getattr(request, name)}
    return tuple(name for name, *_ in setting_differences(request, again) if name not in read)


def _text(value: float | None) -> str:
    """Return a number so that reading it gives it again to the last bit."""
    return "" if value is None else repr(float(value))
