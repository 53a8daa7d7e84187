"""What the check may find fault with, and how much of it is plausible."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from gsapp.foundation import UnknownNameError
from gsapp.foundation.name_suggestions import did_you_mean
from gsapp.quantities.constants import DEGREE, GRAVITY

RATE_CHANNELS = ("p", "q", "r")
ACCELERATION_CHANNELS = ("ax", "ay", "an")
KINEMATIC_INPUTS = (*RATE_CHANNELS, *ACCELERATION_CHANNELS)
"""Instruments whose readings are integrated."""
KINEMATIC_OUTPUTS = ("V", "alpha", "beta", "phi", "theta")
"""Instruments whose readings the integrated motion must show."""
ERROR_KINDS = ("bias", "scale", "delay")

_GYRO = {"bias": 2.0 * DEGREE, "scale": 0.2, "delay": 0.05}
_ACCELEROMETER = {"bias": 0.1 * GRAVITY, "scale": 0.2, "delay": 0.05}
_VANE = {"bias": 3.0 * DEGREE, "scale": 0.3, "delay": 0.05}
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

It enters the fit with this weight. What the data do not narrow down is not reported.
"""

_TOLERABLE_GYRO = {"bias": 1.0 * DEGREE, "scale": 0.05, "delay": 0.02}
_TOLERABLE_ACCELEROMETER = {"bias": 0.05 * GRAVITY, "scale": 0.05, "delay": 0.02}
_TOLERABLE_VANE = {"bias": 1.0 * DEGREE, "scale": 0.1, "delay": 0.02}
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

OBSERVABLE_SHARE = 0.3
"""A parameter counts as seen where its bound is at most this share of `PLAUSIBLE_ERRORS`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CompatibilitySettings:
    """How to check.

    Attributes
    ----------
    free : tuple of str
        Errors to be estimated, ``<channel>.<kind>``, kind of `ERROR_KINDS`; those of channels that
        no maneuver has are left out.
    plausible : mapping of str to float
        In place of `PLAUSIBLE_ERRORS` for some of them.
    tolerable : mapping of str to float
        In place of `TOLERABLE_ERRORS` for some of them.
    try_signs : bool
        Whether reversed and exchanged axes are looked for.
    iterations : int
        Gauss-Newton steps at most.
    rate : float
        Residuals are averaged to about so many per second; rigid motion ends far below.

    Raises
    ------
    UnknownNameError
        If an error is called otherwise.
    """

    free: tuple[str, ...] = DEFAULT_FREE_ERRORS
    plausible: Mapping[str, float] = field(default_factory=dict)
    tolerable: Mapping[str, float] = field(default_factory=dict)
    try_signs: bool = True
    iterations: int = 15
    rate: float = 25.0

    def __post_init__(self) -> None:
        for name in (*self.free, *self.plausible, *self.tolerable):
            if name not in PLAUSIBLE_ERRORS:
                known = ", ".join((*KINEMATIC_INPUTS, *KINEMATIC_OUTPUTS))
                hint = did_you_mean(
                    name,
                    PLAUSIBLE_ERRORS,
                    f"write one of {known}, then .bias, .scale or .delay, as alpha.scale",
                )
                raise UnknownNameError(f"'{name}' is not an error of an instrument; {hint}")

    def plausible_size(self, name: str) -> float:
        """Return the standard deviation of an error before anything was measured."""
        return self.plausible.get(name, PLAUSIBLE_ERRORS[name])

    def tolerable_size(self, name: str) -> float:
        """Return up to which size an error is everyday."""
        return self.tolerable.get(name, TOLERABLE_ERRORS[name])
