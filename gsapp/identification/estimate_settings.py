"""Every setting of an estimation, declared once: type, default, limits, title, help, unit.

The options of ``gsapp estimate``, the form in the window, the request that a catalog stores, and
the description of a run in a report derive from these fields. Values may be given as typed text:
``Cm_q,Cm_de`` for names, ``Cm_q=-20, CN_q=5`` for values, ``Cm_q=-20:5`` for values with a
standard deviation.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Final, Literal, Self

from pydantic import BeforeValidator, Field, ValidationError, field_validator
from pydantic.fields import FieldInfo

from gsapp.foundation import FlightError, StrictModel
from gsapp.foundation.name_suggestions import did_you_mean
from gsapp.identification.axes import Axis
from gsapp.identification.methods import DEFAULT_METHOD, estimation_method


class SettingError(FlightError):
    """A setting has a value that it cannot have.

    Parameters
    ----------
    field : str
        Name of the setting.
    words : str
        What is wrong, and the remedy.
    """

    def __init__(self, field: str, words: str) -> None:
        super().__init__(words)
        self.field = field


@dataclass(frozen=True, slots=True, kw_only=True)
class SettingInfo:
    """How a setting appears to the user, beside its title and help.

    Attributes
    ----------
    option : str
        On the command line; empty for none.
    metavar : str
        Of its value there.
    is_repeatable : bool
        Whether the option may be given several times.
    choices : tuple of (str, str)
        Values and their titles.
    unit : str
    default_text : str
        What the default means.
    """

    option: str = ""
    metavar: str = ""
    is_repeatable: bool = False
    choices: tuple[tuple[str, str], ...] = ()
    unit: str = ""
    default_text: str = "none"


def setting_info(field: FieldInfo) -> SettingInfo:
    """Return how a setting appears to the user."""
    return next((one for one in field.metadata if isinstance(one, SettingInfo)), SettingInfo())


def _setting(default: Any, title: str, text: str, gt: float | None = None, **info: Any) -> Any:
    """Declare a setting; the first sentence of its text is its help on the command line."""
    field = Field(default, title=title, description=text, gt=gt)
    field.metadata.append(SettingInfo(**info))
    return field


# --- typed text -----------------------------------------------------------------------------------


def _parse_names(value: Any) -> Any:
    if isinstance(value, str):
        return tuple(name.strip() for name in value.split(",") if name.strip())
    return value


def _parse_pairs(value: Any, read: Callable[[str], Any], form: str) -> Any:
    texts = value.split(",") if isinstance(value, str) else value
    if not isinstance(texts, Sequence):
        return value
    found = {}
    for text in filter(None, (one.strip() for one in texts)):
        name, equals, number = (part.strip() for part in text.partition("="))
        try:
            found[name] = read(number)
        except ValueError:
            equals = ""
        if not equals or not name:
            raise FlightError(f"'{text}' cannot be read; write {form}")
    return found


def _parse_values(value: Any) -> Any:
    return _parse_pairs(value, float, "NAME=VALUE, as Cm_q=-20")


def _parse_priors(value: Any) -> Any:
    def read(text: str) -> tuple[float, float]:
        number, _, std = text.partition(":")
        return float(number), float(std)

    return _parse_pairs(value, read, "NAME=VALUE:STD, as Cm_q=-20:5")


def _parse_optional_number(value: Any) -> Any:
    if not isinstance(value, str):
        return value
    try:
        return float(value) if value.strip() else None
    except ValueError:
        raise FlightError(f"'{value}' is not a number; write it as 10") from None


Names = Annotated[tuple[str, ...], BeforeValidator(_parse_names)]
OptionalNames = Annotated[tuple[str, ...] | None, BeforeValidator(_parse_names)]
Values = Annotated[Mapping[str, float], BeforeValidator(_parse_values)]
Priors = Annotated[Mapping[str, tuple[float, float]], BeforeValidator(_parse_priors)]
OptionalNumber = Annotated[float | None, BeforeValidator(_parse_optional_number)]

_OF_AXIS: Final = "those of the axis"
_OF_FLIGHT: Final = "that of each flight"


# --- declarations ---------------------------------------------------------------------------------


class SettingsModel(StrictModel):
    """Base of settings: a value that a setting cannot have raises `SettingError`."""

    def __init__(self, **values: Any) -> None:
        try:
            super().__init__(**values)
        except ValidationError as error:
            first = error.errors()[0]
            field = str(first["loc"][0]) if first["loc"] else ""
            words = str(first["msg"]).removeprefix("Value error, ")
            declared = type(self).model_fields.get(field)
            titles = () if declared is None or not declared.title else (declared.title,)
            where = ".".join(map(str, (*titles, *first["loc"][len(titles) :])))
            if first["type"] == "extra_forbidden":
                words = f"'{where}' is not a setting"
            elif first["type"] != "value_error":
                must = words.removeprefix("Input ")  # "Input should be greater than 0"
                words = f"{where} is {first['input']!r}; it {must[:1].lower()}{must[1:]}"
            raise SettingError(field, words) from error

    def with_changes(self, **changes: Any) -> Self:
        """Return settings with other values."""
        return type(self)(**{**dict(self), **changes})


class FitSettings(SettingsModel):
    """Settings of a fit, whatever it is asked for by."""

    # fmt: off
    free: OptionalNames = _setting(
        None, "Free",
        "Estimate these alone; the others keep the values of the model.",
        option="--free", metavar="NAME,..",
        default_text="those of the surfaces moved (tables 6.2.5 and 6.2.6)")
    free_effects: Names = _setting(
        (), "Free parameters of effects",
        "Parameters of the effects of the model that are free, <effect id>.<parameter>.")
    held: Values = _setting(
        {}, "Held", "Hold a derivative, or a parameter of an effect, at a value.",
        option="--hold", metavar="NAME=VALUE", is_repeatable=True)
    start: Values = _setting(
        {}, "Start values", "Start value of a derivative.",
        option="--start", metavar="NAME=VALUE", is_repeatable=True,
        default_text="from equation error")
    priors: Priors = _setting(
        {}, "A-priori values", "A-priori value of a derivative with its standard deviation (W2).",
        option="--prior", metavar="NAME=VALUE:STD", is_repeatable=True)
    states: OptionalNames = _setting(
        None, "States", "Integrated states; the others are measured.",
        option="--states", metavar="ID,..", default_text=_OF_AXIS)
    responses: OptionalNames = _setting(
        None, "Responses",
        "Responses compared with measurement. What a maneuver did not measure is left out there.",
        option="--responses", metavar="ID,..", default_text=_OF_AXIS)
    biases: OptionalNames = _setting(
        None, "Sensor biases", "Responses whose sensor bias is free.",
        option="--biases", metavar="ID,..", default_text=_OF_AXIS)
    scale_factors: Names = _setting(
        (), "Scale factors", "Responses whose scale factor is free (1: none).",
        option="--scales", metavar="ID,..")
    time_shifts: Names = _setting(
        (), "Time shifts", "Responses whose time shift is free (s, positive: late).",
        option="--shifts", metavar="ID,..")
    noise: Literal["diagonal", "full"] = _setting(
        "diagonal", "Noise of the responses",
        "Whether the noise of different responses is independent (diagonal) or correlated (full). "
        "Choose correlated where one disturbance, such as a gust, moves several responses at once.",
        option="--noise", choices=(("diagonal", "Independent"), ("full", "Correlated")))
    integration: Literal["rk4", "euler"] = _setting(
        "rk4", "Integration",
        "Runge-Kutta of fourth order, or Euler. Choose Euler only to reproduce the numbers of an "
        "older program.",
        option="--integration", choices=(("rk4", "Runge-Kutta"), ("euler", "Euler")))
    bound_factor: OptionalNumber = _setting(
        None, "Bounds",
        "Multiply the Cramer-Rao bounds by this in place of the correction for colored residuals. "
        "The source: 10.",
        option="--bound-factor", metavar="X", unit="times Cramer-Rao",
        default_text="corrected for colored residuals", gt=0.0)
    stand_ins: Values = _setting(
        {}, "Stand-ins",
        "Constant for a channel that was not measured, SI and radians, such as V=30. By default "
        "the other maneuvers of the campaign give it, where they can.",
        option="--stand-in", metavar="NAME=VALUE", is_repeatable=True)
    initial_states: bool = _setting(
        True, "Initial states",
        "Whether the states at the start of every segment are free; else the smoothed measurement.")
    airspeed_cutoff: float | None = _setting(
        None, "Airspeed low-pass",
        "Cutoff of a zero-phase low-pass for measured airspeed and density. By default 3 Hz where "
        "a time shift or a delay of an instrument is free, else none: noise of the airspeed passes "
        "through the dynamic pressure into every computed acceleration, and makes shifts stick "
        "between two samples, where interpolation averages it away.",
        unit="Hz", default_text="by the free time shifts", gt=0.0)
    lags: int | None = _setting(
        None, "Lags of the residuals", "Lags of the residuals' autocovariance.",
        default_text="from the data")
    tolerance: float = _setting(
        1e-6, "Tolerance",
        "Stop when a step promises to lower the cost by less than this share, |dJ/J|. The source: "
        "1e-4. 1e-6 leaves a ten-thousandth of a bound, 1e-12 only rounding.")
    max_iterations: int = _setting(
        30, "Maximum iterations", "Stop after so many iterations.")
    restart: float = _setting(
        1.0, "Restart",
        "Where the model diverges over whole segments: length of the pieces, each started from "
        "measurement, that a first fit is made on.",
        unit="s", gt=0.0)
    # fmt: on

    def fit_values(self) -> dict[str, Any]:
        """Return the values of these fields, for settings of another class."""
        return {name: getattr(self, name) for name in FitSettings.model_fields}

    @field_validator("states", "responses", "biases", "scale_factors", "time_shifts")
    @classmethod
    def _check_channels(cls, names: tuple[str, ...] | None, info: Any) -> tuple[str, ...] | None:
        if names:
            from gsapp.dynamics.equations import POLAR_STATES
            from gsapp.dynamics.sensors import OUTPUTS

            known = POLAR_STATES if info.field_name == "states" else OUTPUTS
            for name in names:
                if name not in known:
                    hint = did_you_mean(name, known, f"choose from {', '.join(known)}")
                    raise FlightError(f"'{name}' is not one of the {info.field_name}; {hint}")
        return names

    @field_validator("priors")
    @classmethod
    def _check_priors(
        cls, priors: Mapping[str, tuple[float, float]]
    ) -> Mapping[str, tuple[float, float]]:
        for name, (_, std) in priors.items():
            if not std > 0.0:
                raise FlightError(f"the prior of {name} needs a standard deviation above zero")
        return priors


class EstimateSettings(FitSettings):
    """What a user can choose of an estimation."""

    # fmt: off
    aircraft: str = _setting(
        "", "Aircraft",
        "Aircraft: a file, or the name of a shipped one; else the copy in the flight folder. "
        "Choose another file only to correct what was recorded with the flight.",
        option="--aircraft", metavar="FILE", default_text=_OF_FLIGHT)
    method: str = _setting(
        DEFAULT_METHOD, "Method", "Method of estimation.", option="--method")
    axis: Axis = _setting(
        "both", "Axis",
        "Use maneuvers of one axis only; both: each by the surfaces that it moved. Choose one "
        "axis to select its responses.",
        option="--axis",
        choices=(("both", "By moved surfaces"), ("lon", "Longitudinal only"),
                 ("lat", "Lateral only")))
    six_degrees: bool = _setting(
        False, "Six degrees of freedom",
        "Fit all six degrees of freedom together. Only where elevator and lateral surfaces moved "
        "together, or sideslip couples into pitch.",
        option="--six-degrees")
    joint: bool = _setting(
        False, "All maneuvers jointly",
        "Also fit all maneuvers of an axis jointly. Takes longer; helps where single maneuvers "
        "are weak.",
        option="--joint")
    weights: str = _setting(
        "", "Weights",
        "Weights of the responses, such as the shipped table-6.2.7; by default the noise is "
        "estimated. Weights of your own reproduce an older analysis.",
        option="--weights", metavar="FILE", default_text="from the residuals")
    model: str = _setting(
        "", "Model",
        "Model: its effects apply, its values are held where not free. Without a model, the "
        "means of the campaign are held.",
        option="--model", metavar="FILE")
    maneuver_windows: Names = _setting(
        (), "Maneuver windows",
        "Seconds, in place of what would be found; K:START:STOP for the K-th flight.",
        option="--maneuver", metavar="START:STOP", is_repeatable=True)
    every_grade: bool = _setting(
        False, "Every grade", "Include maneuvers graded unfit (D).", option="--every-grade")
    as_found: bool = _setting(
        False, "As found", "Ignore manual changes from the review.",
        option="--as-found")
    channel_map: str = _setting(
        "", "Channel map", "Channel map: a file, or the name of a shipped one.",
        option="--map", metavar="MAP", default_text=_OF_FLIGHT)
    calibration: str = _setting(
        "", "Certificates",
        "Certificates to use instead of those of the flight: a folder, or a shipped set. "
        "Choose others after a calibration that was found wrong.",
        option="--calibration", metavar="FOLDER|NAME", default_text="those of each flight")
    label: str = _setting(
        "", "Name of the run", "Name of the run in the catalog.",
        option="--label", metavar="TEXT")
    # fmt: on

    @field_validator("method")
    @classmethod
    def _check_method(cls, method: str) -> str:
        try:
            return estimation_method(method).id
        except KeyError as error:
            raise FlightError(str(error)) from error
