"""The same derivatives by several methods, and where those contradict one another.

Methods make different use of one record: output error integrates the motion in calm air, filter
error in gusts that it estimates, equation
error takes the air as the vanes felt it, FTR looks at one band of frequencies. With instruments
where the aircraft file says, on time and in calm air they agree within their bounds; a difference
beyond is an error of the record or of the model that no bound knows of.

The constants (``_0``) are left out: those of forces hold the zero offsets of the accelerometers,
which maximum likelihood estimates beside them and equation error cannot.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from gsapp.dynamics.buildup import derivative_names
from gsapp.identification.campaign import CampaignResult, ManeuverResult, campaign_values
from gsapp.identification.methods import short_method_title
from gsapp.identification.results import Estimate
from gsapp.identification.summary.settings import SUMMARY

ValueWithBound = tuple[float, float]
"""A value and its bound."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MethodComparison:
    """One derivative by several methods, per radian."""

    name: str
    method: str  # Id of the method that was asked for.
    values: Mapping[str, ValueWithBound]
    """Value and bound by method id, of the methods that earned it."""

    def difference(self, other: str) -> float | None:
        """Return the value of another method less that of the own, in joint bounds."""
        if self.method not in self.values or other not in self.values:
            return None
        (one, bound), (value, other_bound) = self.values[self.method], self.values[other]
        return (value - one) / math.hypot(bound, other_bound)

    @property
    def contradictions(self) -> tuple[str, ...]:
        """Return the methods farther away than three joint bounds.

        Output error in gusts contradicts nobody: filter error is there because it is wrong.
        """
        return tuple(
            other
            for other in self.values
            if (self.method, other) != ("fem", "ml")
            and abs(self.difference(other) or 0.0) > SUMMARY.contradiction_sigmas
        )

    @property
    def disagreement(self) -> float:
        """Return what to add to the bound (root of squares) to cover the contradictions."""
        own = self.values.get(self.method, (0.0, 0.0))
        return max(
            (
                math.sqrt((value - own[0]) ** 2 - own[1] ** 2 - bound**2)
                for value, bound in (self.values[other] for other in self.contradictions)
            ),
            default=0.0,
        )


def compare_methods(result: ManeuverResult) -> tuple[MethodComparison, ...]:
    """Return the derivatives of a maneuver by each method; empty where only one gave any."""
    if result.estimate is None:
        return ()
    return compare_estimates(result.estimate, result.comparisons)


def compare_estimates(
    estimate: Estimate, others: Mapping[str, Estimate]
) -> tuple[MethodComparison, ...]:
    """Return the derivatives of an estimate beside those of other methods, by method id."""
    every = {estimate.method: estimate, **others}
    return _comparisons(estimate.method, {method: one.estimated for method, one in every.items()})


def compare_method_means(results: Sequence[ManeuverResult]) -> tuple[MethodComparison, ...]:
    """Return the means of each method over the maneuvers from which all gave estimates."""
    compared = [one for one in results if one.estimate is not None and one.comparisons]
    if not compared:
        return ()
    own = compared[0].estimate
    method = "" if own is None else own.method
    others = dict.fromkeys(other for one in compared for other in one.comparisons)
    estimates: dict[str, list[Estimate | None]] = {method: [one.estimate for one in compared]}
    for other in others:
        estimates[other] = [one.comparisons.get(other) for one in compared]
    return _comparisons(
        method,
        {
            name: {key: (one.mean, one.std) for key, one in campaign_values(found).items()}
            for name, found in estimates.items()
        },
    )


def contradiction_warnings(result: CampaignResult) -> tuple[str, ...]:
    """Return where methods contradict one another, in sentences: of joint fits, else of means."""
    if result.joint:
        compared: Iterable[MethodComparison] = (
            one
            for estimate, others in zip(result.joint, result.joint_comparisons, strict=True)
            for one in compare_estimates(estimate, others)
        )
    else:
        compared = compare_method_means(result.results)
    found: dict[str, list[tuple[float, str]]] = {}
    title = short_method_title(result.settings.method)
    for one in compared:
        title = short_method_title(one.method)
        for other in one.contradictions:
            value, bound = one.values[other]
            own, own_bound = one.values[one.method]
            size = abs(one.difference(other) or 0.0)
            text = f"{one.name} {own:.3g} ±{own_bound:.2g} against {value:.3g} ±{bound:.2g}"
            found.setdefault(other, []).append((size, text))
    cause = _likely_cause(result)
    return tuple(
        f"{title} and {short_method_title(other)} contradict each other in {len(values)} "
        f"derivative{'' if len(values) == 1 else 's'} (beyond "
        f"{SUMMARY.contradiction_sigmas:z.0f} joint bounds): {_largest(values)}{cause}"
        for other, values in found.items()
    )


def _likely_cause(result: CampaignResult) -> str:
    """Return the likelier reason why methods contradict each other, to end a sentence with."""
    fitted = [one.estimate for one in result.results if one.estimate is not None]
    if any(one.gusty_maneuvers for one in fitted):
        return ". Likely cause: gusts, which filter error alone allows for"
    strongest = max(
        (one for fit in (result.joint or fitted) for one in fit.influences),
        key=lambda one: one.sigmas,
        default=None,
    )
    if strongest is not None:
        return (
            f". Likely cause: {strongest.response} cannot be followed together with the other "
            "responses (position, delay or scale of its instrument, or a term that the model "
            "lacks)"
        )
    return ". Compare the instruments with 'gsapp compatibility'"


def _largest(values: Sequence[tuple[float, str]]) -> str:
    shown = [text for _, text in sorted(values, reverse=True)[: SUMMARY.max_named]]
    more = len(values) - len(shown)
    return "; ".join(shown) + (f"; and {more} more" if more else "")


def _comparisons(
    method: str, values: Mapping[str, Mapping[str, ValueWithBound]]
) -> tuple[MethodComparison, ...]:
    if len(values) < 2:
        return ()
    order = {name: index for index, name in enumerate(derivative_names())}
    names = sorted(
        set().union(*values.values()), key=lambda name: (order.get(name, len(order)), name)
    )
    return tuple(
        MethodComparison(
            name=name,
            method=method,
            values={key: found[name] for key, found in values.items() if name in found},
        )
        for name in names
        if not name.endswith("_0")
    )
