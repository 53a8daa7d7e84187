"""Settings of an estimation: options of ``gsapp estimate``, form, stored request, report."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final, Literal

from pydantic import field_validator

from gsapp.flight.maneuver_settings import ManeuverSettings
from gsapp.foundation import FlightError
from gsapp.foundation.name_suggestions import did_you_mean
from gsapp.foundation.settings import (
    Names,
    OptionalNames,
    OptionalNumber,
    Priors,
    SettingsModel,
    Values,
    setting,
)
from gsapp.identification.axes import Axis
from gsapp.identification.methods import DEFAULT_METHOD, estimation_method

_OF_AXIS: Final = "those of the axis"


class FitSettings(SettingsModel):
    """Settings of a fit, whatever it is asked for by."""

    # fmt: off
    free: OptionalNames = setting(
        None, "Free",
        "Estimate these alone; the others keep the values of the model.",
        option="--free", metavar="NAME,..",
        default_text="those of the surfaces moved (tables 6.2.5 and 6.2.6)")
    free_effects: Names = setting(
        (), "Free parameters of effects",
        "Parameters of the effects of the model that are free, <effect id>.<parameter>.")
    held: Values = setting(
        {}, "Held", "Hold a derivative, or a parameter of an effect, at a value.",
        option="--hold", metavar="NAME=VALUE", is_repeatable=True)
    start: Values = setting(
        {}, "Start values", "Start value of a derivative.",
        option="--start", metavar="NAME=VALUE", is_repeatable=True,
        default_text="from equation error")
    priors: Priors = setting(
        {}, "A-priori values", "A-priori value of a derivative with its standard deviation (W2).",
        option="--prior", metavar="NAME=VALUE:STD", is_repeatable=True)
    states: OptionalNames = setting(
        None, "States", "Integrated states; the others are measured.",
        option="--states", metavar="ID,..", default_text=_OF_AXIS)
    responses: OptionalNames = setting(
        None, "Responses",
        "Responses compared with measurement. What a maneuver did not measure is left out there.",
        option="--responses", metavar="ID,..", default_text=_OF_AXIS)
    biases: OptionalNames = setting(
        None, "Sensor biases", "Responses whose sensor bias is free.",
        option="--biases", metavar="ID,..", default_text=_OF_AXIS)
    scale_factors: Names = setting(
        (), "Scale factors", "Responses whose scale factor is free (1: none).",
        option="--scales", metavar="ID,..")
    time_shifts: Names = setting(
        (), "Time shifts", "Responses whose time shift is free (s, positive: late).",
        option="--shifts", metavar="ID,..")
    noise: Literal["diagonal", "full"] = setting(
        "diagonal", "Noise of the responses",
        "Whether the noise of different responses is independent (diagonal) or correlated (full). "
        "Choose correlated where one disturbance, such as a gust, moves several responses at once.",
        option="--noise", choices=(("diagonal", "Independent"), ("full", "Correlated")))
    integration: Literal["rk4", "euler"] = setting(
        "rk4", "Integration",
        "Runge-Kutta of fourth order, or Euler. Choose Euler only to reproduce the numbers of an "
        "older program.",
        option="--integration", choices=(("rk4", "Runge-Kutta"), ("euler", "Euler")))
    bound_factor: OptionalNumber = setting(
        None, "Bounds",
        "Multiply the Cramer-Rao bounds by this in place of the correction for colored residuals. "
        "The source: 10.",
        option="--bound-factor", metavar="X", unit="times Cramer-Rao",
        default_text="corrected for colored residuals", gt=0.0)
    stand_ins: Values = setting(
        {}, "Stand-ins",
        "Constant for a channel that was not measured, SI and radians, such as V=30. By default "
        "the other maneuvers of the campaign give it, where they can.",
        option="--stand-in", metavar="NAME=VALUE", is_repeatable=True)
    initial_states: bool = setting(
        True, "Initial states",
        "Whether the states at the start of every segment are free; else the smoothed measurement.")
    airspeed_cutoff: float | None = setting(
        None, "Airspeed low-pass",
        "Cutoff of a zero-phase low-pass for measured airspeed and density. By default 3 Hz where "
        "a time shift or a delay of an instrument is free, else none: noise of the airspeed passes "
        "through the dynamic pressure into every computed acceleration, and makes shifts stick "
        "between two samples, where interpolation averages it away.",
        unit="Hz", default_text="by the free time shifts", gt=0.0)
    lags: int | None = setting(
        None, "Lags of the residuals", "Lags of the residuals' autocovariance.",
        default_text="from the data")
    tolerance: float = setting(
        1e-6, "Tolerance",
        "Stop when a step promises to lower the cost by less than this share, |dJ/J|. The source: "
        "1e-4. 1e-6 leaves a ten-thousandth of a bound, 1e-12 only rounding.")
    max_iterations: int = setting(
        30, "Maximum iterations", "Stop after so many iterations.")
    restart: float = setting(
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


class EstimateSettings(ManeuverSettings, FitSettings):
    """What a user can choose of an estimation."""

    # fmt: off
    method: str = setting(
        DEFAULT_METHOD, "Method", "Method of estimation.", option="--method")
    axis: Axis = setting(
        "both", "Axis",
        "Use maneuvers of one axis only; both: each by the surfaces that it moved. Choose one "
        "axis to select its responses.",
        option="--axis",
        choices=(("both", "By moved surfaces"), ("lon", "Longitudinal only"),
                 ("lat", "Lateral only")))
    six_degrees: bool = setting(
        False, "Six degrees of freedom",
        "Fit all six degrees of freedom together. Only where elevator and lateral surfaces moved "
        "together, or sideslip couples into pitch.",
        option="--six-degrees")
    joint: bool = setting(
        False, "All maneuvers jointly",
        "Also fit all maneuvers of an axis jointly. Takes longer; helps where single maneuvers "
        "are weak.",
        option="--joint")
    vane_positions: Literal["find", "file"] = setting(
        "find", "Vane positions",
        "find: where the flow vanes contradict the other instruments, use the position at which "
        "they agree and say so; file: use the aircraft file's.",
        option="--vane-positions", choices=(("find", "Find"), ("file", "As in the aircraft file")))
    weights: str = setting(
        "", "Weights",
        "Weights of the responses, such as the shipped table-6.2.7; by default the noise is "
        "estimated. Weights of your own reproduce an older analysis.",
        option="--weights", metavar="FILE", default_text="from the residuals")
    model: str = setting(
        "", "Model",
        "Model: its effects apply, its values are held where not free. Without a model, the "
        "means of the campaign are held.",
        option="--model", metavar="FILE")
    label: str = setting(
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
