"""Data compatibility: are the instruments consistent with one another? Kinematics, no aerodynamics.

`check` tells a bad vane from a bad model before any model is fitted.
"""

from gsapp.identification.compatibility.check import MOTION, check
from gsapp.identification.compatibility.results import (
    CompatibilityResult,
    InstrumentParameter,
    InstrumentVerdict,
    SensorComparison,
)
from gsapp.identification.compatibility.settings import (
    DEFAULT_FREE,
    PLAUSIBLE,
    TOLERABLE,
    CompatibilitySettings,
)

__all__ = [
    "DEFAULT_FREE",
    "MOTION",
    "PLAUSIBLE",
    "TOLERABLE",
    "CompatibilityResult",
    "CompatibilitySettings",
    "InstrumentParameter",
    "InstrumentVerdict",
    "SensorComparison",
    "check",
]
