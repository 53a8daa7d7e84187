"""What the check may find fault with, and how much of it is plausible."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Final

from gsapp.foundation import UnknownNameError
from gsapp.foundation.name_suggestions import did_you_mean
from gsapp.quantities.constants import DEGREE, GRAVITY

RATE_CHANNELS = ("p", "q", "r")
ACCELERATION_CHANNELS = ("ax", "ay", "an")
KINEMATIC_INPUTS = (*RATE_CHANNELS, *ACCELERATION_CHANNELS)
"""Instruments whose readings are integrated."""
KINEMATIC_OUTPUTS = ("V", "alpha", "beta", "phi", "theta")
"""Instruments whose readings the integrated motion must show."""
ERROR_KINDS = ("bias", "scale", "delay", "position")

_GYRO = {"bias": 2.0 * DEGREE, "scale": 0.2, "delay": 0.05}
_ACCELEROMETER = {"bias": 0.1 * GRAVITY, "scale": 0.2, "delay": 0.05}
_VANE = {"bias": 3.0 * DEGREE, "scale": 0.3, "delay": 0.05, "position": 10.0}
_PITOT = {"bias": 2.0, "scale": 0.1, "delay": 0.1}
_ATTITUDE = {"bias": 5.0 * DEGREE, "scale": 0.1, "delay": 0.1}


def _by_name(groups: Mapping[str, Mapping[str, float]]) -> Mapping[str, float]:
    return MappingProxyType(
        {f"{name}.{kind}": size for name, sizes in groups.items() for kind, size in sizes.items()}
    )


PLAUSIBLE_ERRORS: Mapping[str, float] = _by_name(
    {
        **dict.fromkeys(RATE_CHANNELS, _GYRO),
        **dict.fromkeys(ACCELERATION_CHANNELS, _ACCELEROMETER),
        "V": _PITOT,
        "alpha": _VANE,
        "beta": _VANE,
        "phi": _ATTITUDE,
        "theta": _ATTITUDE,
    }
)
"""Standard deviation of each error before anything was measured; SI, scale as a share, s.

A position is the distance of a vane ahead of where the aircraft file puts it, m.

It enters the fit with this weight. What the data do not narrow down is not reported.
"""

_TOLERABLE_GYRO = {"bias": 1.0 * DEGREE, "scale": 0.05, "delay": 0.02}
_TOLERABLE_ACCELEROMETER = {"bias": 0.05 * GRAVITY, "scale": 0.05, "delay": 0.02}
_TOLERABLE_VANE = {"bias": 1.0 * DEGREE, "scale": 0.1, "delay": 0.02, "position": 0.05}
_TOLERABLE_ATTITUDE = {"bias": 2.0 * DEGREE, "scale": 0.1, "delay": 0.1}

TOLERABLE_ERRORS: Mapping[str, float] = _by_name(
    {
        **dict.fromkeys(RATE_CHANNELS, _TOLERABLE_GYRO),
        **dict.fromkeys(ACCELERATION_CHANNELS, _TOLERABLE_ACCELEROMETER),
        "V": {"bias": 1.0, "scale": 0.05, "delay": 0.1},
        **dict.fromkeys(("alpha", "beta"), _TOLERABLE_VANE),
        **dict.fromkeys(("phi", "theta"), _TOLERABLE_ATTITUDE),
    }
)
"""Errors up to these are everyday; beyond them a verdict says so. SI, scale as a share, s."""

DEFAULT_FREE_ERRORS = (
    *(f"{name}.bias" for name in KINEMATIC_INPUTS),
    "V.scale", "V.delay",
    "alpha.bias", "alpha.scale", "alpha.delay",
    "beta.bias", "beta.scale", "beta.delay",
    "phi.bias", "phi.delay", "theta.bias", "theta.delay",
)  # fmt: skip
"""Gyros and accelerometers set the scale and the time for the others: theirs are held."""

VANE_POSITIONS = ("alpha.position", "beta.position")
"""Free as well where the instruments agree much better with them."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CompatibilitySettings:
    """How to check.

    Raises
    ------
    UnknownNameError
        If an error is called otherwise.
    """

    free: tuple[str, ...] = DEFAULT_FREE_ERRORS
    """Errors to be estimated, ``<channel>.<kind>``, kind of `ERROR_KINDS`; those of channels that
    no maneuver has are left out."""
    plausible: Mapping[str, float] = field(default_factory=dict)
    """In place of `PLAUSIBLE_ERRORS` for some of them."""
    tolerable: Mapping[str, float] = field(default_factory=dict)
    """In place of `TOLERABLE_ERRORS` for some of them."""
    try_signs: bool = True  # Whether reversed and exchanged axes are looked for.
    iterations: int = 15  # Gauss-Newton steps at most.
    rate: float = 25.0
    """Residuals are averaged to about so many per second; rigid motion ends far below."""

    def __post_init__(self) -> None:
        for name in (*self.free, *self.plausible, *self.tolerable):
            if name not in PLAUSIBLE_ERRORS:
                known = ", ".join((*KINEMATIC_INPUTS, *KINEMATIC_OUTPUTS))
                hint = did_you_mean(
                    name,
                    PLAUSIBLE_ERRORS,
                    f"write one of {known}, then .bias, .scale, .delay or (for a vane) .position, "
                    "as alpha.scale",
                )
                raise UnknownNameError(f"'{name}' is not an error of an instrument; {hint}")

    def plausible_size(self, name: str) -> float:
        """Return the standard deviation of an error before anything was measured."""
        return self.plausible.get(name, PLAUSIBLE_ERRORS[name])

    def tolerable_size(self, name: str) -> float:
        """Return up to which size an error is everyday."""
        return self.tolerable.get(name, TOLERABLE_ERRORS[name])


MIN_NOISE: Mapping[str, float] = MappingProxyType(
    {
        "V": 0.01,
        **dict.fromkeys(ACCELERATION_CHANNELS, 1e-3),
        **dict.fromkeys(RATE_CHANNELS, 2e-4),
        **dict.fromkeys(("alpha", "beta", "phi", "theta"), 5e-4),
    }
)
"""White noise that a channel has at least, rms of a sample, SI.

A filter hides white noise; without a least one the fit would trust a smooth channel beyond what
any instrument is built for.
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class CompatibilityAlgorithmSettings:
    """Engineering choices; times in s."""

    observable_share: float = 0.3  # Of `PLAUSIBLE_ERRORS`: bound of a visible error.

    # Segments.
    max_filled_gap: float = 0.15  # A longer gap in rates or accelerations splits a maneuver.
    min_duration: float = 2.0  # A stretch shorter than this (s) is left out.
    min_segment_samples: int = 40  # Samples below which a stretch is left out.

    # Gauss-Newton fit.
    initial_speed_std: float = 10.0  # Of a start before any measurement: m/s ...
    initial_rotation_std: float = 0.5  # ... and rad.
    step_tolerance: float = 0.02  # A step smaller than this share of a bound is the last.
    noise_update_step: float = 0.3  # Step below which the noise is estimated again ...
    noise_update_interval: int = 4  # ... or after so many steps ...
    max_noise_updates: int = 2  # ... and so many times.
    max_iterations: int = 40  # Steps where the usual ones did not lead to an end.
    trial_iterations: int = 8  # Steps to see what one more error explains.
    max_delay: float = 0.2  # Of an instrument against the gyros, s, either way.
    max_rotation_step: float = 0.5  # Of a start in one step, rad.
    max_cost_growth: float = 1.02  # Ratio of costs up to which a step is taken.
    max_halvings: int = 3  # Halvings of a step that raises the cost by more.
    ridge: float = 1e-12  # Share of the diagonal that keeps the normal equations solvable.
    max_speed: float = 1e3  # Velocities (m/s) beyond this are no flight.
    scale_signal_to_noise: tuple[float, float] = (10.0, 20.0)
    """Variance of motion over noise, for a scale: over white noise to take part in the fit, over
    all noise to be reported ..."""
    delay_signal_to_noise: tuple[float, float] = (5.0, 25.0)  # ... and for a delay.

    # Kalman predictor.
    unmeasured_rate_density: float = 0.03  # Density of what no instrument measured: rad^2/s ...
    unmeasured_force_density: float = 4.0  # ... and m^2/s^3.
    calm_air_density: float = 1e-4  # Density of gusts in calm air, m^2/s^3.
    covariance_doublings: int = 10  # Doublings of the time over which the covariance settles.
    max_search_steps: int = 6  # Steps of the search for the noise with one factor ...
    search_factor: float = 4.0  # ... which is the square of this at first.
    assumed_speed_std: float = 4.0  # Standard deviation of a guessed airspeed, m/s.

    # Verdict.
    significant_sigmas: float = 3.0  # Bounds by which an error must exceed the tolerable.
    max_gyro_noise_ratio: float = 1000.0
    """Power over white noise at which a gyro contradicts the others as no gusts make it: at most
    500 in gusts of 2 m/s, 4000 and more with a wrong unit ..."""
    min_gyro_noise_share: float = 0.3
    """... if that noise is this share of the motion: a filtered gyro shows next to no white one."""
    plausible_position: float = 0.5  # Of a vane, against the aircraft file: times the span ...
    tolerable_position: float = 0.02  # ... and that of everyday.
    position_sigmas: float = 6.0
    """Bounds by which it must exceed the tolerable: a vane that hardly moves is put anywhere."""
    max_position: float = 1.0  # Times the span: farther away no vane stands.
    loose_airspeed_factor: float = 1e4  # On the noise power of airspeed, where it is no proof.
    motion_rate: float = 10.0  # Averages a second that tell the frequency of the motion.
    min_delay_phase: float = 0.1  # rad, at the frequency of the motion, from which a delay matters.
    max_delay_ratio: float = 2.0  # Of gyros in one box: the largest delay over the least.
    min_position_effect: float = 1.0  # Of a position on its flow angle, times its white noise.
    max_final_step: float = 4.0
    """Last step in bounds from which a fit is no proof: at most 2.2 with good instruments whose
    errors hardly show, 6 and more with a vane in another unit."""
    gust_warning_speed: float = 0.3  # Change of the wind in a second, m/s.

    # Reversed and exchanged axes.
    min_likelihood_gain: float = 20.0  # Twice the log-likelihood: far beyond chance.
    min_residual_ratio: float = 1.2  # Times by which a remedy must lower the residuals.
    flow_angle_ratio: float = 2.0  # The same, to name the flow angle of that axis instead.
    max_scale_std: float = 0.2  # Bound of a scale: a turned sign is ten times that away.
    white_noise_factors: tuple[float, float] = (3.0, 10.0)
    """For filters before the converter: on inputs and on outputs of the kinematics."""
    screening_segments: int = 4  # Segments with most motion, for first tries.
    screening_stages: tuple[tuple[int, int], tuple[int, int]] = ((1, 6), (4, 2))
    """Steps, remedies kept."""
    max_corrections: int = 3  # Remedies applied one after the other.

    # Redundant instruments.
    precision_ratio: float = 10.0  # Over `TOLERABLE_ERRORS`, for other sensors.
    min_motion_ratio: float = 10.0  # Variance of motion over that of the difference.
    max_redundant_delay: float = 0.1  # Delays are looked for up to this, s.
    min_redundant_samples: int = 40  # Samples that a comparison takes.
    redundant_sigmas: float = 4.0  # Standard deviations from which two instruments differ.


COMPATIBILITY: Final = CompatibilityAlgorithmSettings()
