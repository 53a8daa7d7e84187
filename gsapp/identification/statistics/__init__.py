"""How far estimates may be trusted: bounds, identifiability, residuals, fit. Pure NumPy.

In all of it S are the sensitivities of the computed responses, shape (n, n_responses,
n_parameters), v the residuals (measured minus computed), shape (n, n_responses), NaN where a
sample does not count, W the weight matrix of the responses, shape (n_responses, n_responses), and
``segments`` the stretches of contiguous samples (one by default).
"""

from gsapp.identification.statistics.bounds import (
    ManeuverFitData,
    colored_covariance,
    covariance_for_known_noise,
    cramer_rao,
    information_matrix,
    joint_covariance,
    noise_autocovariance,
    noise_covariance,
)
from gsapp.identification.statistics.identifiability import (
    CORRELATION_WARNING_PREFIX,
    Identifiability,
    ParameterVerdict,
    assess_identifiability,
    correlation_warning,
)
from gsapp.identification.statistics.residuals import (
    TurbulenceDetection,
    Whiteness,
    detect_turbulence,
    evaluate_whiteness,
    response_fit,
)

__all__ = [
    "CORRELATION_WARNING_PREFIX",
    "Identifiability",
    "ManeuverFitData",
    "ParameterVerdict",
    "TurbulenceDetection",
    "Whiteness",
    "assess_identifiability",
    "colored_covariance",
    "correlation_warning",
    "covariance_for_known_noise",
    "cramer_rao",
    "detect_turbulence",
    "evaluate_whiteness",
    "information_matrix",
    "joint_covariance",
    "noise_autocovariance",
    "noise_covariance",
    "response_fit",
]
