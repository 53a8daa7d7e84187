"""How far estimates may be trusted: bounds, identifiability, residuals, fit. Pure NumPy.

In all of it S are the sensitivities of the computed responses, shape (n, n_responses,
n_parameters), v the residuals (measured minus computed), shape (n, n_responses), NaN where a
sample does not count, W the weight matrix of the responses, shape (n_responses, n_responses), and
``segments`` the stretches of contiguous samples (one by default).
"""

from gsapp.identification.statistics.bounds import (
    Part,
    colored_covariance,
    covariance_under,
    cramer_rao,
    information,
    joint_covariance,
    noise_autocovariance,
    noise_covariance,
)
from gsapp.identification.statistics.fit import response_fit
from gsapp.identification.statistics.identifiability import (
    STRONGLY_CORRELATED,
    Identifiability,
    Verdict,
    correlation_warning,
    identifiability,
)
from gsapp.identification.statistics.turbulence import Turbulence, turbulence
from gsapp.identification.statistics.whiteness import Whiteness, whiteness

__all__ = [
    "STRONGLY_CORRELATED",
    "Identifiability",
    "Part",
    "Turbulence",
    "Verdict",
    "Whiteness",
    "colored_covariance",
    "correlation_warning",
    "covariance_under",
    "cramer_rao",
    "identifiability",
    "information",
    "joint_covariance",
    "noise_autocovariance",
    "noise_covariance",
    "response_fit",
    "turbulence",
    "whiteness",
]
