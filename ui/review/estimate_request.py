"""From the panel to what is asked for; what cannot be is said beside its field. No Qt."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from gsapp.foundation import GroundStationError
from gsapp.foundation.settings import SettingError
from gsapp.identification.axes import axis_derivatives
from gsapp.identification.estimate_settings import EstimateSettings, FitSettings
from gsapp.identification.methods import estimation_method
from ui.estimate_form import DerivativeEntry, EstimateForm
from ui.number_format import parse_number
from ui.translation import tr

if TYPE_CHECKING:
    # The window starts without the numerics behind an estimation.
    from gsapp.aircraft import Aircraft
    from gsapp.identification.runs.request import RunRequest, SelectedManeuver

_METHOD_DEPENDENT: Final = frozenset((*FitSettings.model_fields, "weights", "model"))
"""Settings that only some methods use."""
_FORM_FIELDS: Final = {
    **dict.fromkeys(("free", "free_effects", "held", "start", "priors"), "derivatives"),
    **dict.fromkeys(("states", "responses", "biases", "scale_factors", "time_shifts"), "channels"),
}
"""Where settings stand on the form, if not in a field of their own."""


def method_uses(form: EstimateForm, setting: str) -> bool:
    """Return whether the chosen method uses a setting."""
    return setting not in _METHOD_DEPENDENT or setting in estimation_method(form.method).settings


def parse_derivative_settings(form: EstimateForm) -> dict[str, Any]:
    """Return the settings of the derivatives of the axis: free, held, start values, priors.

    Raises
    ------
    SettingError
        If a number cannot be read, or is missing.
    """
    free: list[str] = []
    held: dict[str, float] = {}
    start: dict[str, float] = {}
    priors: dict[str, tuple[float, float]] = {}
    names = axis_derivatives("both" if form.six_degrees else form.axis)
    effects = list_edited_effect_parameters(form)
    for name in (*names, *effects):
        entry = form.derivative(name)
        if entry.treated == "held":
            if not entry.value:
                raise SettingError("held", tr("{name} is held: enter its value").format(name=name))
            held[name] = _number("held", name, entry.value)
            continue
        if entry.treated == "free":
            free.append(name)
        if entry.start and method_uses(form, "start"):
            start[name] = _number("start", tr("the start of {name}").format(name=name), entry.start)
        if (entry.prior or entry.deviation) and method_uses(form, "priors"):
            priors[name] = _prior(name, entry)
    if all(name in held for name in names):
        raise SettingError("held", tr("every derivative is held: free at least one"))
    return {
        "free": tuple(name for name in free if name not in effects) or None,
        "free_effects": tuple(name for name in free if name in effects),
        "held": held,
        "start": start,
        "priors": priors,
    }


def list_edited_effect_parameters(form: EstimateForm) -> tuple[str, ...]:
    """Return the parameters of effects that something is wished for, where they count."""
    if not method_uses(form, "free_effects") or not form.model:
        return ()
    return tuple(name for name in form.derivatives if is_effect_parameter(name))


def is_effect_parameter(name: str) -> bool:
    """Return whether a name is that of an effect's parameter, ``<effect id>.<parameter>``."""
    return "." in name


def load_effect_parameters(model: str, aircraft: Aircraft) -> dict[str, float]:
    """Return the parameters of the effects of a model with their values, by name.

    Raises
    ------
    GroundStationError
        If there is no such model.
    """
    from gsapp.dynamics.model import load_model

    return {
        f"{effect.id}.{parameter.name}": value
        for effect in load_model(model).effects
        for parameter, value in zip(
            effect.term(aircraft).parameters, effect.values(aircraft), strict=True
        )
    }


def _prior(name: str, entry: DerivativeEntry) -> tuple[float, float]:
    if not entry.prior or not entry.deviation:
        missing = tr("a value") if not entry.prior else tr("a deviation")
        raise SettingError(
            "priors", tr("the prior of {name} needs {missing}").format(name=name, missing=missing)
        )
    return (
        _number("priors", tr("the prior of {name}").format(name=name), entry.prior),
        _number(
            "priors",
            tr("the prior standard deviation of {name}").format(name=name),
            entry.deviation,
        ),
    )


def _number(field: str, what: str, text: str) -> float:
    found = parse_number(text)
    if found is None:
        raise SettingError(
            field,
            tr("{what}: '{text}' is not a number; write it as -0.34").format(what=what, text=text),
        )
    return found


def is_single_axis(form: EstimateForm) -> bool:
    """Return whether all maneuvers are fitted in one axis, so that its channels can be chosen."""
    return form.axis != "both" or form.six_degrees


def build_run_request(
    form: EstimateForm,
    flights: Sequence[Path],
    maneuvers: Sequence[SelectedManeuver],
    label: str = "",
) -> RunRequest:
    """Return what is asked for.

    Raises
    ------
    SettingError
        If a field holds what cannot be asked for.
    """
    from gsapp.identification.runs.request import RunRequest

    values = {name: getattr(form, name) for name in EstimateSettings.model_fields}
    own_channels = () if is_single_axis(form) else ("responses", "states")
    used = {
        name: value
        for name, value in values.items()
        if method_uses(form, name) and name not in own_channels
    }
    used |= {"flights": flights, "maneuvers": maneuvers, "label": label}
    try:
        if method_uses(form, "held"):
            used |= parse_derivative_settings(form)
        return RunRequest(**used)
    except SettingError as error:
        raise SettingError(_FORM_FIELDS.get(error.field, error.field), str(error)) from error


def find_form_error(form: EstimateForm) -> SettingError | None:
    """Return what cannot be asked for, with its field of the form; None if all is well."""
    from gsapp.dynamics.model import load_model
    from gsapp.identification.weights import load_weights

    readers: tuple[tuple[str, Callable[[str], object]], ...] = (
        ("weights", load_weights),
        ("model", load_model),
    )
    try:
        build_run_request(form, (), ())
    except SettingError as error:
        return error
    for field, read in readers:
        name = getattr(form, field)
        if name and method_uses(form, field):
            try:
                read(name)
            except (GroundStationError, OSError) as error:
                return SettingError(field, str(error))
    return None
