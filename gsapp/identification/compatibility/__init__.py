"""Data compatibility: are the instruments consistent with one another? Kinematics, no aerodynamics.

`check_compatibility` tells a bad vane from a bad model before any model is fitted.
"""

from gsapp.identification.compatibility.compatibility_check import (
    RECONSTRUCTED_CHANNELS,
    check_compatibility,
)
from gsapp.identification.compatibility.error_selection import (
    VanePosition,
    at_found_positions,
    find_vane_positions,
)
from gsapp.identification.compatibility.results import (
    CompatibilityResult,
    InstrumentParameter,
    InstrumentVerdict,
    SensorComparison,
)
from gsapp.identification.compatibility.settings import (
    DEFAULT_FREE_ERRORS,
    PLAUSIBLE_ERRORS,
    TOLERABLE_ERRORS,
    CompatibilitySettings,
)

__all__ = [
    "DEFAULT_FREE_ERRORS",
    "PLAUSIBLE_ERRORS",
    "RECONSTRUCTED_CHANNELS",
    "TOLERABLE_ERRORS",
    "CompatibilityResult",
    "CompatibilitySettings",
    "InstrumentParameter",
    "InstrumentVerdict",
    "SensorComparison",
    "VanePosition",
    "at_found_positions",
    "check_compatibility",
    "find_vane_positions",
]
