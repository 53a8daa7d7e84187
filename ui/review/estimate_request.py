"""From the panel to what is asked for; what cannot be is said beside its field. No Qt."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from gsapp.foundation import FlightError, GroundStationError
from gsapp.identification.axes import axis_derivatives
from ui.estimate_form import DerivativeEntry, EstimateForm
from ui.number_format import parse_number

if TYPE_CHECKING:
    # The window starts without the numerics behind an estimation.
    from gsapp.aircraft import Aircraft
    from gsapp.identification.campaign import CampaignSettings
    from gsapp.identification.maximum_likelihood import MLSettings
    from gsapp.identification.runs.request import RunRequest, SelectedManeuver

METHOD_SETTINGS: Mapping[str, frozenset[str]] = {
    "ml": frozenset(
        ("derivatives", "start", "weights", "channels", "bounds", "model", "stand_ins", "noise",
         "integration")
    ),
    "ee": frozenset(("derivatives", "model", "stand_ins")),
    "ftr": frozenset(),
}  # fmt: skip
"""What each method heeds; the rest of the panel is gray."""


class FormFieldError(FlightError):
    """What stands in a field cannot be asked for.

    Parameters
    ----------
    field : str
        Of the panel.
    words : str
        What is wrong, and the remedy.
    """

    def __init__(self, field: str, words: str) -> None:
        super().__init__(words)
        self.field = field


@dataclass(frozen=True, slots=True, kw_only=True)
class DerivativeSettings:
    """What is asked of the derivatives.

    Attributes
    ----------
    free : tuple of str, optional
        These alone; None for those of the tables.
    free_effects : tuple of str
        Parameters of the model's effects that are free, too.
    held, start : mapping of str to float
    priors : mapping of str to (float, float)
    """

    free: tuple[str, ...] | None
    free_effects: tuple[str, ...]
    held: Mapping[str, float]
    start: Mapping[str, float]
    priors: Mapping[str, tuple[float, float]]


def parse_derivative_settings(wishes: EstimateForm) -> DerivativeSettings:
    """Return what is asked of the derivatives of the axis.

    Raises
    ------
    FormFieldError
        If a number cannot be read, or is missing.
    """
    free: list[str] = []
    held: dict[str, float] = {}
    start: dict[str, float] = {}
    priors: dict[str, tuple[float, float]] = {}
    names = axis_derivatives("both" if wishes.six_degrees else wishes.axis)
    effects = list_edited_effect_parameters(wishes)
    for name in (*names, *effects):
        wish = wishes.derivative(name)
        if wish.treated == "held":
            if not wish.value:
                raise FormFieldError(
                    "derivatives", f"{name} is held: type the value that it is held at"
                )
            held[name] = _number("derivatives", name, wish.value)
            continue
        if wish.treated == "free":
            free.append(name)
        if wishes.method != "ml":
            continue
        if wish.start:
            start[name] = _number("derivatives", f"the start of {name}", wish.start)
        if wish.prior or wish.deviation:
            priors[name] = _prior(name, wish)
    if all(name in held for name in names):
        raise FormFieldError("derivatives", "every derivative is held: free at least one")
    return DerivativeSettings(
        free=tuple(name for name in free if name not in effects) or None,
        free_effects=tuple(name for name in free if name in effects),
        held=held,
        start=start,
        priors=priors,
    )


def list_edited_effect_parameters(wishes: EstimateForm) -> tuple[str, ...]:
    """Return the parameters of effects that something is wished for, where they count."""
    if wishes.method != "ml" or not wishes.model:
        return ()
    return tuple(name for name in wishes.derivatives if is_effect_parameter(name))


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


def _prior(name: str, wish: DerivativeEntry) -> tuple[float, float]:
    if not wish.prior or not wish.deviation:
        missing = "a value" if not wish.prior else "a deviation"
        raise FormFieldError(
            "derivatives", f"what is known of {name} beforehand needs {missing}, too"
        )
    value = _number("derivatives", f"the a-priori value of {name}", wish.prior)
    deviation = _number("derivatives", f"the a-priori deviation of {name}", wish.deviation)
    if deviation <= 0.0:
        raise FormFieldError(
            "derivatives",
            f"the a-priori value of {name} needs a standard deviation above zero",
        )
    return value, deviation


def _number(field: str, what: str, text: str) -> float:
    found = parse_number(text)
    if found is None:
        raise FormFieldError(field, f"{what}: '{text}' is no number; write it as -0.34")
    return found


def parse_missing_channels(text: str) -> dict[str, float]:
    """Return constants for what was not measured.

    Raises
    ------
    FormFieldError
        If the text cannot be read.
    """
    found = {}
    for part in filter(None, (one.strip() for one in text.split(","))):
        name, equals, value = part.partition("=")
        if not equals or not name.strip():
            raise FormFieldError(
                "stand_ins", f"'{part}' cannot be read; write NAME=VALUE, as V=30 (SI, radians)"
            )
        found[name.strip()] = _number("stand_ins", name.strip(), value)
    return found


def parse_bound_factor(text: str) -> float | None:
    """Return what multiplies the Cramer-Rao bounds; None for the correction.

    Raises
    ------
    FormFieldError
        If it is no number above zero.
    """
    if not text.strip():
        return None
    found = _number("bound_factor", "the factor of the bounds", text)
    if found <= 0.0:
        raise FormFieldError(
            "bound_factor", f"the factor of the bounds is {found:g}; give one above 0"
        )
    return found


def build_ml_settings(wishes: EstimateForm) -> MLSettings:
    """Return what maximum likelihood takes.

    Raises
    ------
    FormFieldError
        If a field holds what cannot be asked for.
    """
    from gsapp.identification.maximum_likelihood import MLSettings

    takes = METHOD_SETTINGS[wishes.method]
    asked = parse_derivative_settings(wishes)
    constants = parse_missing_channels(wishes.stand_ins) if "stand_ins" in takes else {}
    if wishes.method != "ml":
        return MLSettings(axis="lon", stand_ins=constants)
    own = is_single_axis(wishes)
    try:
        return MLSettings(
            axis="lon",
            stand_ins=constants,
            free_effects=asked.free_effects,
            start=asked.start,
            priors=asked.priors,
            noise=wishes.noise,
            integration=wishes.integration,
            bound_factor=parse_bound_factor(wishes.bound_factor),
            responses=wishes.responses if own else None,
            states=wishes.states if own else None,
            biases=wishes.biases,
            scale_factors=wishes.scale_factors,
            time_shifts=wishes.time_shifts,
        )
    except FormFieldError:
        raise
    except FlightError as error:
        raise FormFieldError("channels", str(error)) from error


def is_single_axis(wishes: EstimateForm) -> bool:
    """Return whether all maneuvers are fitted in one axis, so that its channels can be chosen."""
    return wishes.axis != "both" or wishes.six_degrees


def build_campaign_settings(wishes: EstimateForm) -> CampaignSettings:
    """Return how to estimate; weights and model are named by the request.

    Raises
    ------
    FormFieldError
        If a field holds what cannot be asked for.
    """
    from gsapp.identification.campaign import CampaignSettings

    asked = parse_derivative_settings(wishes)
    heeds = "derivatives" in METHOD_SETTINGS[wishes.method]
    return CampaignSettings(
        method=wishes.method,
        axis=wishes.axis,
        six_degrees=wishes.six_degrees,
        free=asked.free if heeds else None,
        held=asked.held if heeds else {},
        likelihood=build_ml_settings(wishes),
        joint=wishes.joint,
    )


def build_run_request(
    wishes: EstimateForm,
    flights: Sequence[Path],
    maneuvers: Sequence[SelectedManeuver],
    label: str = "",
) -> RunRequest:
    """Return what is asked for.

    Raises
    ------
    FormFieldError
        If a field holds what cannot be asked for.
    """
    from gsapp.identification.runs.request import RunRequest

    takes = METHOD_SETTINGS[wishes.method]
    return RunRequest(
        flights=tuple(flights),
        maneuvers=tuple(maneuvers),
        settings=build_campaign_settings(wishes),
        aircraft=wishes.aircraft,
        calibration=wishes.calibration,
        channel_map=wishes.channel_map,
        label=label,
        weights=wishes.weights if "weights" in takes else "",
        model=wishes.model if "model" in takes else "",
    )


def find_form_error(wishes: EstimateForm) -> FormFieldError | None:
    """Return what cannot be asked for as the panel stands; None if all is well."""
    from gsapp.dynamics.model import load_model
    from gsapp.identification.weights import load_weights

    takes = METHOD_SETTINGS[wishes.method]
    readers: tuple[tuple[str, str, Callable[[str], object]], ...] = (
        ("weights", wishes.weights, load_weights),
        ("model", wishes.model, load_model),
    )
    try:
        build_campaign_settings(wishes)
    except FormFieldError as error:
        return error
    for field, name, read in readers:
        if name and field in takes:
            try:
                read(name)
            except (GroundStationError, OSError) as error:
                return FormFieldError(field, str(error))
    return None
