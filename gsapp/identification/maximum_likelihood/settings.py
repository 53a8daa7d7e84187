"""What a maximum likelihood fit is told."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Literal

from gsapp.dynamics.equations import POLAR_STATES
from gsapp.dynamics.model import Model
from gsapp.dynamics.sensors import OUTPUTS
from gsapp.foundation import FlightError
from gsapp.foundation.name_suggestions import did_you_mean
from gsapp.identification.axes import Axis


@dataclass(frozen=True, slots=True, kw_only=True)
class MLSettings:
    """Settings of a maximum likelihood (output error) fit.

    Attributes
    ----------
    axis : {"lon", "lat", "both"}
    states : tuple of str, optional
        Active states; by default those of the axis, and attitude where it was not measured. The
        others come from measurement.
    responses : tuple of str, optional
        Compared with measurement; by default those of the axis. What a maneuver did not measure
        is left out there.
    model : Model, optional
        Gives the effects beyond the linear build-up, and values of derivatives that are not free.
    free : tuple of str, optional
        Free derivatives; by default tables 6.2.5 and 6.2.6 for the surfaces that were moved.
    free_effects : tuple of str
        Free parameters of the model's effects, ``<effect id>.<parameter>``.
    held : mapping of str to float
        Derivatives and effect parameters held at a value.
    start : mapping of str to float
        Start values; the rest starts from equation error.
    weights : mapping of str to float, optional
        Weight of each response (SI; diagonal of W1). By default the noise covariance is estimated
        from the residuals, for each maneuver its own, and iterated.
    joint_weights : mapping of str to mapping, optional
        The same by maneuver id; comes before `weights`.
    noise : {"diagonal", "full"}
        Whether the estimated noise of the responses is taken as independent of one another.
    priors : mapping of str to (float, float)
        A-priori value and its standard deviation (W2).
    integration : {"rk4", "euler"}
    biases : tuple of str, optional
        Responses whose sensor bias is free in every maneuver; by default those of
        `gsapp.identification.axes.DEFAULT_BIASES`.
    scale_factors, time_shifts : tuple of str
        Responses whose scale factor (1: none), time shift (s, positive: late) is free.
    airspeed_cutoff : float, optional
        Of a zero-phase low-pass for measured airspeed and density, Hz. By default 3 Hz where a
        time shift or a delay of an instrument is free, else they are taken as measured. Their
        noise passes through the dynamic pressure into every computed acceleration; there it makes
        shifts stick between two samples, where interpolation averages it away.
    initial_states : bool
        Whether the states at the start of every segment are free; else the smoothed measurement.
    stand_ins : mapping of str to float
        Constants for what was not measured.
    max_iterations : int
    tolerance : float
        Stops when a step promises to lower the cost by less than this share, |dJ/J|. The source:
        1e-4. 1e-6 leaves a ten-thousandth of a bound, 1e-12 nothing but rounding.
    bound_factor : float
        Multiplies the Cramer-Rao bounds in place of the correction for colored residuals; 10 in
        the source. None: the correction.
    lags : int, optional
        Of the residuals' autocovariance.
    restart : float, optional
        Where the model diverges over whole segments: length (s) of the pieces, each started from
        measurement, that a first fit is made on.
    """

    axis: Axis
    states: tuple[str, ...] | None = None
    responses: tuple[str, ...] | None = None
    model: Model | None = None
    free: tuple[str, ...] | None = None
    free_effects: tuple[str, ...] = ()
    held: Mapping[str, float] = field(default_factory=dict)
    start: Mapping[str, float] = field(default_factory=dict)
    weights: Mapping[str, float] | None = None
    joint_weights: Mapping[str, Mapping[str, float]] | None = None
    noise: Literal["diagonal", "full"] = "diagonal"
    priors: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    integration: Literal["rk4", "euler"] = "rk4"
    biases: tuple[str, ...] | None = None
    scale_factors: tuple[str, ...] = ()
    time_shifts: tuple[str, ...] = ()
    airspeed_cutoff: float | None = None
    initial_states: bool = True
    stand_ins: Mapping[str, float] = field(default_factory=dict)
    max_iterations: int = 30
    tolerance: float = 1e-6
    bound_factor: float | None = None
    lags: int | None = None
    restart: float = 1.0

    def __post_init__(self) -> None:
        _check_names("states", self.states, POLAR_STATES)
        for what in ("responses", "biases", "scale_factors", "time_shifts"):
            _check_names(what, getattr(self, what), OUTPUTS)
        for name, (_, std) in self.priors.items():
            if not std > 0.0:
                raise FlightError(
                    f"the a-priori value of {name} needs a standard deviation above zero"
                )
        if self.bound_factor is not None and not self.bound_factor > 0.0:
            raise FlightError(f"bounds cannot be multiplied by {self.bound_factor:g}; give above 0")
        for where in (self.weights, *(self.joint_weights or {}).values()):
            for name, weight in (where or {}).items():
                if not weight >= 0.0:
                    raise FlightError(f"the weight of {name} is {weight:g}; give 0 or more")

    def with_stand_ins(self, values: Mapping[str, float]) -> MLSettings:
        """Return settings with constants for further channels; those of the settings count."""
        return replace(self, stand_ins={**values, **self.stand_ins})


def _check_names(what: str, names: tuple[str, ...] | None, known: tuple[str, ...]) -> None:
    unknown = [name for name in names or () if name not in known]
    if unknown:
        hint = did_you_mean(unknown[0], known, f"choose from {', '.join(known)}")
        raise FlightError(f"'{unknown[0]}' is not one of the {what}; {hint}")


@dataclass(frozen=True, slots=True, kw_only=True)
class FitProgress:
    """How far a fit has come.

    Attributes
    ----------
    iteration : int
    cost : float
        Mean square of the weighted residuals, over that at the start.
    change : float
        Share of the cost that the last step promised to take off.
    """

    iteration: int
    cost: float
    change: float


FitProgressCallback = Callable[[FitProgress], bool | None]
"""Called after every iteration; returning False stops the fit where it is."""
