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
from gsapp.foundation.translation import QT_TR_NOOP
from gsapp.identification.axes import AXIS_SURFACES, Axis
from gsapp.identification.methods import DEFAULT_METHOD, estimation_method

_OF_AXIS: Final = "those of the axis"


class FitSettings(SettingsModel):
    """Settings of a fit, whatever it is asked for by."""

    # fmt: off
    free: OptionalNames = setting(
        None, QT_TR_NOOP("Free"),
        QT_TR_NOOP("Estimate these alone; the others keep the values of the model."),
        option="--free", metavar="NAME,..",
        default_text="those of the surfaces moved (tables 6.2.5 and 6.2.6)")
    free_effects: Names = setting(
        (), QT_TR_NOOP("Free parameters of effects"),
        QT_TR_NOOP("Parameters of the effects of the model that are free, "
                   "<effect id>.<parameter>."))
    held: Values = setting(
        {}, QT_TR_NOOP("Held"),
        QT_TR_NOOP("Hold a derivative, or a parameter of an effect, at a value."),
        option="--hold", metavar="NAME=VALUE", is_repeatable=True)
    start: Values = setting(
        {}, QT_TR_NOOP("Start values"),
        QT_TR_NOOP("Start value of a derivative."),
        option="--start", metavar="NAME=VALUE", is_repeatable=True,
        default_text="from equation error")
    priors: Priors = setting(
        {}, QT_TR_NOOP("A-priori values"),
        QT_TR_NOOP("A-priori value of a derivative with its standard deviation (W2)."),
        option="--prior", metavar="NAME=VALUE:STD", is_repeatable=True)
    states: OptionalNames = setting(
        None, QT_TR_NOOP("States"),
        QT_TR_NOOP("Integrated states; the others are measured."),
        option="--states", metavar="ID,..", default_text=_OF_AXIS)
    responses: OptionalNames = setting(
        None, QT_TR_NOOP("Responses"),
        QT_TR_NOOP("Responses compared with measurement. What a maneuver did not measure is left "
                   "out there."),
        option="--responses", metavar="ID,..", default_text=_OF_AXIS)
    measured_inputs: Names = setting(
        (), QT_TR_NOOP("Measured inputs"),
        QT_TR_NOOP("States that enter as measured inputs: neither integrated nor compared. Choose "
                   "rates or angles whose equation is unreliable, as beta in gusts."),
        option="--measured-inputs", metavar="ID,..")
    biases: OptionalNames = setting(
        None, QT_TR_NOOP("Sensor biases"),
        QT_TR_NOOP("Responses whose sensor bias is free."),
        option="--biases", metavar="ID,..", default_text=_OF_AXIS)
    scale_factors: Names = setting(
        (), QT_TR_NOOP("Scale factors"),
        QT_TR_NOOP("Responses whose scale factor is free (1: none)."),
        option="--scales", metavar="ID,..")
    time_shifts: Names = setting(
        (), QT_TR_NOOP("Time shifts"),
        QT_TR_NOOP("Responses whose time shift is free (s, positive: late)."),
        option="--shifts", metavar="ID,..")
    noise: Literal["diagonal", "full"] = setting(
        "diagonal", QT_TR_NOOP("Noise of the responses"),
        QT_TR_NOOP("Whether the noise of different responses is independent (diagonal) or "
                   "correlated (full). Choose correlated where one disturbance, such as a gust, "
                   "moves several responses at once."),
        option="--noise",
        choices=(("diagonal", QT_TR_NOOP("Independent")), ("full", QT_TR_NOOP("Correlated"))))
    integration: Literal["rk4", "euler"] = setting(
        "rk4", QT_TR_NOOP("Integration"),
        QT_TR_NOOP("Runge-Kutta of fourth order, or Euler. Choose Euler only to reproduce the "
                   "numbers of an older program."),
        option="--integration",
        choices=(("rk4", QT_TR_NOOP("Runge-Kutta")), ("euler", QT_TR_NOOP("Euler"))))
    bound_factor: OptionalNumber = setting(
        None, QT_TR_NOOP("Bounds"),
        QT_TR_NOOP("Multiply the Cramer-Rao bounds by this in place of the correction for colored "
                   "residuals. The source: 10."),
        option="--bound-factor", metavar="X", unit="times Cramer-Rao",
        default_text="corrected for colored residuals", gt=0.0)
    stand_ins: Values = setting(
        {}, QT_TR_NOOP("Stand-ins"),
        QT_TR_NOOP("Constant for a channel that was not measured, SI and radians, such as V=30. "
                   "By default the other maneuvers of the campaign give it, where they can."),
        option="--stand-in", metavar="NAME=VALUE", is_repeatable=True)
    initial_states: bool = setting(
        True, QT_TR_NOOP("Initial states"),
        QT_TR_NOOP("Whether the states at the start of every segment are free; else the smoothed "
                   "measurement."))
    airspeed_cutoff: float | None = setting(
        None, QT_TR_NOOP("Airspeed low-pass"),
        QT_TR_NOOP("Cutoff of a zero-phase low-pass for measured airspeed and density. By default "
                   "3 Hz where a time shift or a delay of an instrument is free, else none: noise "
                   "of the airspeed passes through the dynamic pressure into every computed "
                   "acceleration, and makes shifts stick between two samples, where interpolation "
                   "averages it away."),
        unit="Hz", default_text="by the free time shifts", gt=0.0)
    lags: int | None = setting(
        None, QT_TR_NOOP("Lags of the residuals"),
        QT_TR_NOOP("Lags of the residuals' autocovariance."),
        default_text="from the data")
    tolerance: float = setting(
        1e-6, QT_TR_NOOP("Tolerance"),
        QT_TR_NOOP("Stop when a step promises to lower the cost by less than this share, |dJ/J|. "
                   "The source: 1e-4. 1e-6 leaves a ten-thousandth of a bound, 1e-12 only "
                   "rounding."))
    max_iterations: int = setting(
        30, QT_TR_NOOP("Maximum iterations"),
        QT_TR_NOOP("Stop after so many iterations."))
    restart: float = setting(
        1.0, QT_TR_NOOP("Restart"),
        QT_TR_NOOP("Where the model diverges over whole segments: length of the pieces, each "
                   "started from measurement, that a first fit is made on."),
        unit="s", gt=0.0)
    # fmt: on

    def fit_values(self) -> dict[str, Any]:
        """Return the values of these fields, for settings of another class."""
        return {name: getattr(self, name) for name in FitSettings.model_fields}

    @field_validator(
        "states", "responses", "measured_inputs", "biases", "scale_factors", "time_shifts"
    )
    @classmethod
    def _check_channels(cls, names: tuple[str, ...] | None, info: Any) -> tuple[str, ...] | None:
        if names:
            from gsapp.dynamics.equations import POLAR_STATES
            from gsapp.dynamics.sensors import OUTPUTS

            of_states = info.field_name in ("states", "measured_inputs")
            known = POLAR_STATES if of_states else OUTPUTS
            for name in names:
                if name not in known:
                    hint = did_you_mean(name, known, f"choose from {', '.join(known)}")
                    kind = info.field_name.replace("_", " ")
                    raise FlightError(f"'{name}' is not one of the {kind}; {hint}")
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
        DEFAULT_METHOD, QT_TR_NOOP("Method"),
        QT_TR_NOOP("Method of estimation."),
        option="--method")
    axis: Axis = setting(
        "both", QT_TR_NOOP("Axis"),
        QT_TR_NOOP("Use maneuvers of one axis only; both: each by the surfaces that it moved. "
                   "Choose one axis to select its responses."),
        option="--axis",
        choices=(("both", QT_TR_NOOP("By moved surfaces")),
                 ("lon", QT_TR_NOOP("Longitudinal only")), ("lat", QT_TR_NOOP("Lateral only"))))
    inputs: Names = setting(
        (), QT_TR_NOOP("Moved surfaces"),
        QT_TR_NOOP("Surfaces that count as the inputs of every maneuver, in place of those found "
                   "to move."),
        option="--inputs", metavar="ID,..", default_text="those that moved")
    six_degrees: bool = setting(
        False, QT_TR_NOOP("Six degrees of freedom"),
        QT_TR_NOOP("Fit all six degrees of freedom together. Only where elevator and lateral "
                   "surfaces moved together, or sideslip couples into pitch."),
        option="--six-degrees")
    joint: bool = setting(
        False, QT_TR_NOOP("All maneuvers jointly"),
        QT_TR_NOOP("Also fit all maneuvers of an axis jointly. Takes longer; helps where single "
                   "maneuvers are weak."),
        option="--joint")
    single_method: bool = setting(
        False, QT_TR_NOOP("Single method"),
        QT_TR_NOOP("Do not compute the methods other than the one chosen. Saves time; "
                   "contradictions between methods then stay unseen."),
        option="--single-method")
    instruments: Literal["find", "file"] = setting(
        "find", QT_TR_NOOP("Instruments"),
        QT_TR_NOOP("find: where instruments contradict each other, correct the position of a vane "
                   "or of the accelerometers, or the delay of a channel, with which they agree, "
                   "and say so; file: as in the aircraft file."),
        option="--instruments",
        choices=(("find", QT_TR_NOOP("Find")), ("file", QT_TR_NOOP("As in the aircraft file"))))
    differentiator: Literal["smoothed", "central"] = setting(
        "smoothed", QT_TR_NOOP("Differentiator"),
        QT_TR_NOOP("smoothed: derivatives of the rates, and all regressors, smoothed alike up to "
                   "the highest frequency above the noise; central: plain central "
                   "differences."),
        option="--differentiator",
        choices=(("smoothed", QT_TR_NOOP("Smoothed")),
                 ("central", QT_TR_NOOP("Central differences"))))
    weights: str = setting(
        "", QT_TR_NOOP("Weights"),
        QT_TR_NOOP("Weights of the responses, such as the shipped table-6.2.7; by default the "
                   "noise is estimated. Weights of your own reproduce an older analysis."),
        option="--weights", metavar="FILE", default_text="from the residuals")
    model: str = setting(
        "", QT_TR_NOOP("Model"),
        QT_TR_NOOP("Model: its effects apply, its values are held where not free. Without a "
                   "model, the means of the campaign are held."),
        option="--model", metavar="FILE")
    label: str = setting(
        "", QT_TR_NOOP("Name of the run"),
        QT_TR_NOOP("Name of the run in the catalog."),
        option="--label", metavar="TEXT")
    # fmt: on

    @field_validator("inputs")
    @classmethod
    def _check_inputs(cls, names: tuple[str, ...]) -> tuple[str, ...]:
        known = AXIS_SURFACES["both"]
        for name in names:
            if name not in known:
                hint = did_you_mean(name, known, f"choose from {', '.join(known)}")
                raise FlightError(f"'{name}' is not a surface; {hint}")
        return names

    @field_validator("method")
    @classmethod
    def _check_method(cls, method: str) -> str:
        try:
            return estimation_method(method).id
        except KeyError as error:
            raise FlightError(str(error)) from error
