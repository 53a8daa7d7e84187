"""What maximum likelihood made of maneuvers in gusts, and what equation error makes of them.

Output error flies in calm air: what gusts did to the motion stays in its residuals and bends its
values. Equation error takes the air as the vanes felt it: the stronger the gusts, the smaller its
errors are beside those of maximum likelihood (`bench truth` shows by how much); in light gusts
and colored noise they are not. Bounds tell which of two values is the better one.

The constants (``_0``) are left out: those of forces hold the zero offsets of the accelerometers,
which maximum likelihood estimates beside them and equation error cannot.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from gsapp.dynamics.buildup import derivative_names
from gsapp.identification.campaign import ManeuverResult, campaign_values
from gsapp.identification.results import Estimate
from gsapp.identification.summary.settings import SUMMARY

ValueWithBound = tuple[float, float]
"""A value and its bound."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MethodDifference:
    """One derivative by both methods, per radian."""

    name: str
    maximum_likelihood: ValueWithBound | None
    equation_error: ValueWithBound | None
    """Value and bound by maximum likelihood and by equation error; None where not earned."""

    @property
    def normalized_difference(self) -> float | None:
        """Return equation error less maximum likelihood, in joint bounds."""
        if self.maximum_likelihood is None or self.equation_error is None:
            return None
        (one, bound), (other, other_bound) = self.maximum_likelihood, self.equation_error
        return (other - one) / math.hypot(bound, other_bound)

    @property
    def differs(self) -> bool:
        """Return whether the two lie farther apart than their bounds allow."""
        return (
            self.normalized_difference is not None
            and abs(self.normalized_difference) > SUMMARY.significant_sigmas
        )


def compare_methods(result: ManeuverResult) -> tuple[MethodDifference, ...]:
    """Return both values of each derivative of a maneuver; empty where it flew in calm air."""
    if result.estimate is None or result.equation_error_estimate is None:
        return ()
    return _method_differences(
        _estimated_values(result.estimate), _estimated_values(result.equation_error_estimate)
    )


def compare_method_means(results: Sequence[ManeuverResult]) -> tuple[MethodDifference, ...]:
    """Return the means of both methods over the maneuvers in gusts; empty where there are none."""
    gusty = [one for one in results if one.equation_error_estimate is not None]
    one, other = (
        {name: (mean.mean, mean.std) for name, mean in campaign_values(estimates).items()}
        for estimates in (
            [one.estimate for one in gusty],
            [one.equation_error_estimate for one in gusty],
        )
    )
    return _method_differences(one, other)


def _estimated_values(estimate: Estimate) -> dict[str, ValueWithBound]:
    return {
        name: (one.value, one.std)
        for name, one in estimate.derivatives.items()
        if one.status == "estimated" and one.value is not None and one.std
    }


def _method_differences(
    one: Mapping[str, ValueWithBound], other: Mapping[str, ValueWithBound]
) -> tuple[MethodDifference, ...]:
    order = {name: place for place, name in enumerate(derivative_names())}
    names = sorted({*one, *other}, key=lambda name: (order.get(name, len(order)), name))
    return tuple(
        MethodDifference(
            name=name, maximum_likelihood=one.get(name), equation_error=other.get(name)
        )
        for name in names
        if not name.endswith("_0")
    )
