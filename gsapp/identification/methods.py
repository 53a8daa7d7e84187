"""The registry of estimation methods.

A method is one record. Those of this program stand in `_OWN_METHODS`; other packages add theirs as
entry points of the group ``gsapp.methods``, each of which names an `EstimationMethod`. Records are
light: what a method computes with is imported when it runs first.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from importlib.metadata import entry_points
from pkgutil import resolve_name
from types import MappingProxyType
from typing import TYPE_CHECKING, Final, Literal

from gsapp.foundation import UnknownNameError
from gsapp.foundation.name_suggestions import did_you_mean
from gsapp.foundation.translation import QT_TR_NOOP

if TYPE_CHECKING:
    from gsapp.identification.campaign import EstimationTask
    from gsapp.identification.results import Estimate

log = logging.getLogger(__name__)

METHOD_GROUP: Final = "gsapp.methods"
"""Group of the entry points."""


@dataclass(frozen=True, slots=True, kw_only=True)
class EstimationMethod:
    """One method of estimation."""

    id: str  # As on the command line, in files and in JSON.
    title: str
    short_title: str
    """In full, and for lists and legends."""
    help_text: str  # What it does and when to choose it: one sentence or two.
    function: str
    """``module:name`` of a function that takes an `EstimationTask` and returns an `Estimate`."""
    settings: frozenset[str] = frozenset()
    """Fields of `gsapp.identification.estimate_settings.EstimateSettings` that it uses, beside
    those of every method (axis, maneuvers, aircraft ...); the form disables the others."""
    is_quick: bool = False  # Quick enough to be computed beside every other method.
    compares: Literal["responses", "coefficients"] = "coefficients"
    """What `Estimate.fit` and `Estimate.histories` are of: channels that are integrated and
    compared with measurement, or force and moment coefficients."""
    comparison_text: str = (
        "force and moment coefficients, as measured motion gives them (solid) and as the "
        "derivatives compute them (dashed), both smoothed alike."
    )
    """Caption of a figure of these histories."""
    documentation: str = ""  # Page, or address, that describes it.

    def estimate(self, task: EstimationTask) -> Estimate:
        """Estimate from maneuvers of one axis.

        Raises `FlightError` if nothing can be estimated from them.
        """
        run: Callable[[EstimationTask], Estimate] = resolve_name(self.function)
        return run(task)


_DERIVATIVE_SETTINGS: Final = frozenset({"free", "held", "model", "stand_ins"})
_OWN_METHODS: Final = (
    EstimationMethod(
        id="ml",
        title=QT_TR_NOOP("Maximum likelihood"),
        short_title=QT_TR_NOOP("ML"),
        help_text=QT_TR_NOOP("Integrates the motion until it follows the measured responses."),
        function="gsapp.identification.campaign:estimate_by_maximum_likelihood",
        settings=_DERIVATIVE_SETTINGS
        | {
            "start", "priors", "free_effects", "weights", "noise", "integration", "bound_factor",
            "responses", "states", "measured_inputs", "biases", "scale_factors", "time_shifts",
        },
        is_quick=True,
        compares="responses",
        comparison_text="measured (solid) against computed (dashed) responses.",
        documentation="docs/identification.md",
    ),
    EstimationMethod(
        id="fem",
        title=QT_TR_NOOP("Filter error"),
        short_title=QT_TR_NOOP("filter error"),
        help_text=QT_TR_NOOP(
            "Follows the responses through a Kalman filter and estimates turbulence, too: for "
            "rough air."
        ),
        function="gsapp.identification.campaign:estimate_by_filter_error",
        settings=_DERIVATIVE_SETTINGS
        | {"start", "priors", "free_effects", "responses", "states", "biases"},
        compares="responses",
        comparison_text="measured (solid) against predicted (dashed) responses: each sample from "
        "those before it.",
        documentation="docs/identification.md",
    ),
    EstimationMethod(
        id="ee",
        title=QT_TR_NOOP("Equation error"),
        short_title=QT_TR_NOOP("equation error"),
        help_text=QT_TR_NOOP("Regresses forces and moments: seconds, and no start values."),
        function="gsapp.identification.campaign:estimate_by_equation_error",
        settings=_DERIVATIVE_SETTINGS | {"differentiator"},
        is_quick=True,
        documentation="docs/identification.md",
    ),
    EstimationMethod(
        id="ftr",
        title=QT_TR_NOOP("Fourier transform regression"),
        short_title=QT_TR_NOOP("FTR"),
        help_text=QT_TR_NOOP("Equation error in the frequency domain, as in flight."),
        function="gsapp.identification.campaign:estimate_by_ftr",
        is_quick=True,
        comparison_text="force and moment coefficients, as measured motion gives them (solid) and "
        "as the derivatives compute their changes (dashed), both smoothed alike.",
        documentation="docs/identification.md",
    ),
)  # fmt: skip
LINEAR_MODEL_TITLES: Final[Mapping[str, str]] = {
    "bls": "batch least squares",
    "subspace": "subspace + PEM",
    "ml": "derivatives, appendix A",
}
"""The three linear models by id; `linear_model_title` says whose derivatives."""
DEFAULT_METHOD: Final = _OWN_METHODS[0].id


@cache
def estimation_methods() -> Mapping[str, EstimationMethod]:
    """Return every method by its id, those of this program first.

    A method of another package that cannot be used is logged and left out.
    """
    found = {one.id: one for one in _OWN_METHODS}
    for point in sorted(entry_points(group=METHOD_GROUP), key=lambda one: one.name):
        try:
            method = point.load()
        except Exception as error:  # a package that fails must not stop the program
            problem = f"cannot be loaded ({error!r})"
        else:
            if isinstance(method, EstimationMethod) and method.id not in found:
                found[method.id] = method
                continue
            problem = "is not an EstimationMethod, or has an id that is taken"
        log.warning("estimation method '%s' (%s) %s", point.name, point.value, problem)
    return MappingProxyType(found)


def estimation_method(method_id: str) -> EstimationMethod:
    """Return a method.

    Raises `UnknownNameError` if none is called that.
    """
    methods = estimation_methods()
    if method_id not in methods:
        hint = did_you_mean(method_id, methods, f"there are {', '.join(methods)}")
        raise UnknownNameError(f"no estimation method is called '{method_id}'; {hint}")
    return methods[method_id]


def short_method_title(method_id: str) -> str:
    """Return the short title of a method; its id where its package is not installed."""
    method = estimation_methods().get(method_id)
    return method_id if method is None else method.short_title


def compares_coefficients(method_id: str) -> bool:
    """Return whether a method compares coefficients, not responses that it integrated."""
    return estimation_method(method_id).compares == "coefficients"


def linear_model_title(model_id: str, method_id: str) -> str:
    """Return the title of a linear model: the third is made from derivatives of some method."""
    if model_id == "ml":
        return f"{short_method_title(method_id)}, appendix A"
    return LINEAR_MODEL_TITLES[model_id]
