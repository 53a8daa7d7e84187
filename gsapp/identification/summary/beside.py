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
from typing import Final

from gsapp.dynamics.buildup import derivative_names
from gsapp.identification.campaign import ManeuverResult, campaign_values
from gsapp.identification.results import Estimate

FAR: Final = 2.0
"""Joint bounds from which two values count as apart."""

Known = tuple[float, float]
"""A value and its bound."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BesideValue:
    """One derivative by both methods, per radian.

    Attributes
    ----------
    name : str
    likelihood, equations : (float, float) or None
        Value and bound by maximum likelihood and by equation error; None where not earned.
    """

    name: str
    likelihood: Known | None
    equations: Known | None

    @property
    def apart(self) -> float | None:
        """Return equation error less maximum likelihood, in joint bounds."""
        if self.likelihood is None or self.equations is None:
            return None
        (one, bound), (other, other_bound) = self.likelihood, self.equations
        return (other - one) / math.hypot(bound, other_bound)

    @property
    def differs(self) -> bool:
        """Return whether the two lie farther apart than their bounds allow."""
        return self.apart is not None and abs(self.apart) > FAR


def beside_values(result: ManeuverResult) -> tuple[BesideValue, ...]:
    """Return both values of each derivative of a maneuver; empty where it flew in calm air."""
    if result.estimate is None or result.beside is None:
        return ()
    return _both(_earned(result.estimate), _earned(result.beside))


def beside_means(results: Sequence[ManeuverResult]) -> tuple[BesideValue, ...]:
    """Return the means of both methods over the maneuvers in gusts; empty where there are none."""
    gusty = [one for one in results if one.beside is not None]
    one, other = (
        {name: (mean.mean, mean.std) for name, mean in campaign_values(estimates).items()}
        for estimates in ([one.estimate for one in gusty], [one.beside for one in gusty])
    )
    return _both(one, other)


def _earned(estimate: Estimate) -> dict[str, Known]:
    return {
        name: (one.value, one.std)
        for name, one in estimate.derivatives.items()
        if one.status == "estimated" and one.value is not None and one.std
    }


def _both(one: Mapping[str, Known], other: Mapping[str, Known]) -> tuple[BesideValue, ...]:
    order = {name: place for place, name in enumerate(derivative_names())}
    names = sorted({*one, *other}, key=lambda name: (order.get(name, len(order)), name))
    return tuple(
        BesideValue(name=name, likelihood=one.get(name), equations=other.get(name))
        for name in names
        if not name.endswith("_0")
    )
