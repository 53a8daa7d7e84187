"""Data compatibility: are the instruments consistent with one another? Kinematics, no aerodynamics.

`check_compatibility` tells a bad vane from a bad model before any model is fitted.
"""

from gsapp.identification.compatibility.compatibility_check import (
    check_compatibility,
)
from gsapp.identification.compatibility.error_selection import find_instrument_errors
from gsapp.identification.compatibility.instrument_error import (
    InstrumentError,
    correct_instruments,
)
from gsapp.identification.compatibility.results import (
    CompatibilityResult,
    InstrumentVerdict,
)
from gsapp.identification.compatibility.settings import (
    DEFAULT_FREE_ERRORS,
    PLAUSIBLE_ERRORS,
    CompatibilitySettings,
)

__all__ = [
    "DEFAULT_FREE_ERRORS",
    "PLAUSIBLE_ERRORS",
    "CompatibilityResult",
    "CompatibilitySettings",
    "InstrumentError",
    "InstrumentVerdict",
    "check_compatibility",
    "correct_instruments",
    "find_instrument_errors",
]
