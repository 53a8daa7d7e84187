"""A kept run done again, or beside another one: what differs, in words."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from gsapp.dynamics.buildup import derivative_names
from gsapp.flight.catalog import Catalog, EstimationRun, StoredEstimate, search_runs
from gsapp.flight.provenance import InputFile, find_changed_parts
from gsapp.foundation.name_suggestions import format_names
from gsapp.identification.campaign import CampaignProgressCallback, CampaignValue
from gsapp.identification.estimate_json import stored_estimates
from gsapp.identification.maneuver import StatusCallback
from gsapp.identification.runs.inputs import FlightCache
from gsapp.identification.runs.request import RunRequest, setting_differences
from gsapp.identification.runs.run_execution import RunOutcome, execute_run
from gsapp.identification.runs.run_store import StoredRun, load_run
from gsapp.identification.summary.settings import SUMMARY

_MAX_NAMED = 4
"""Derivatives named where values differ."""
_STORED_ROLES = frozenset({"model", "weights"})
"""Files whose content is kept with the run: what became of them since does not matter."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RepeatedRun:
    """A run done again."""

    outcome: RunOutcome
    is_identical: bool
    """Whether every value and bound of every maneuver is the same to the last bit."""
    differences: tuple[str, ...]
    """Files and versions that changed since, and values that differ, in words."""


def repeat_run(
    catalog: Catalog,
    number: int,
    *,
    flights: FlightCache | None = None,
    doing: StatusCallback | None = None,
    progress: CampaignProgressCallback | None = None,
) -> RepeatedRun:
    """Do a kept run again, from exactly what it was asked for.

    `flights`, `doing`, `progress`: as for `execute_run`.

    Raises `UnknownNameError` if there is no such run. Raises `GroundStationError` if a flight of it
    cannot be read any more; see `execute_run`.
    """
    before = load_run(catalog, number)
    fits = search_runs(catalog, kept=number)
    outcome = execute_run(before.request, flights=flights, doing=doing, progress=progress)
    other = tuple(_value_differences(before, fits, outcome))
    around = (
        *_input_differences(before.inputs, outcome.inputs),
        *version_differences(before.versions, outcome.versions),
    )
    if other and not around:
        other = (*other, "same files and versions: the program code changed")
    return RepeatedRun(outcome=outcome, is_identical=not other, differences=(*around, *other))


def version_differences(before: Mapping[str, str], now: Mapping[str, str]) -> Iterator[str]:
    """Yield what differs between two sets of versions, in words."""
    for name in dict.fromkeys((*before, *now)):
        if before.get(name) != now.get(name):
            yield f"{name} was {before.get(name, 'not there')}, and is {now.get(name, 'not there')}"


def _input_differences(before: Sequence[InputFile], now: Sequence[InputFile]) -> Iterator[str]:
    one = [file for file in before if file.role not in _STORED_ROLES]
    other = [file for file in now if file.role not in _STORED_ROLES]
    # The same request has the same files in the same order, but for certificates of a folder.
    for old, new in zip(one, other, strict=False):
        for name in find_changed_parts(old, new):
            yield f"{name} has changed"
    for file in (*one[len(other) :], *other[len(one) :]):
        yield f"{file.name} was not there both times"


def _value_differences(
    before: StoredRun, fits: Sequence[EstimationRun], outcome: RunOutcome
) -> Iterator[str]:
    """Yield which values differ by a bit or more, fit by fit."""
    again = [one.estimate for one in outcome.result.results if one.estimate is not None]
    fitted = [*again, *outcome.result.joint]
    failures = {
        one.maneuver.id: one.failure for one in outcome.result.results if one.estimate is None
    }
    if failures != dict(before.failures) or len(fits) != len(fitted):
        yield "different maneuvers could be fitted"
        return
    for old, estimate in zip(fits, fitted, strict=True):
        new = stored_estimates(estimate)
        names = [
            name
            for name in dict.fromkeys((*old.estimates, *new))
            if old.estimates.get(name) != new.get(name)
        ]
        if names:
            which = ", ".join(estimate.maneuvers)
            words = [
                _difference_text(name, old.estimates.get(name), new.get(name)) for name in names
            ]
            yield f"maneuver {which}: {format_names(words, _MAX_NAMED)}"
    means = {name: one.value for name, one in outcome.summary.derivatives.items()}
    moved = [name for name in means if means[name] != before.values.get(name)]
    if moved or set(means) != set(before.values):
        yield f"the means of {', '.join(moved) or 'other derivatives'} differ"


def _difference_text(name: str, old: StoredEstimate | None, new: StoredEstimate | None) -> str:
    one = None if old is None else old.value
    other = None if new is None else new.value
    if one is None or other is None:
        return f"{name} was {_status_text(old)}, and is {_status_text(new)}"
    if one == other:
        return f"the bound of {name} differs"
    return f"{name} was {one:.6g}, and is {other:.6g} ({other - one:+.2g})"


def _status_text(one: StoredEstimate | None) -> str:
    if one is None:
        return "absent"
    return one.status if one.value is None else f"{one.value:.6g}"


@dataclass(frozen=True, slots=True, kw_only=True)
class SettingDifference:
    """A setting of two runs in words."""

    name: str
    one: str
    other: str


@dataclass(frozen=True, slots=True, kw_only=True)
class ValueDifference:
    """A derivative of two runs."""

    name: str
    one: CampaignValue | None
    other: CampaignValue | None
    """None where the run did not earn it."""
    difference: float | None = None  # Of the means, the other's less the one's.
    in_bounds: float | None = None
    """The difference over the root of the sum of both variances. Runs that share maneuvers share
    their noise as well: they should then differ by less than 1."""

    @property
    def differs(self) -> bool:
        """Return whether the values lie farther apart than their bounds allow, or one is not."""
        if self.in_bounds is None:
            return True
        return abs(self.in_bounds) > SUMMARY.significant_sigmas


@dataclass(frozen=True, slots=True, kw_only=True)
class RunComparison:
    """Two runs beside each other."""

    one: str
    other: str
    """Their names."""
    settings: tuple[SettingDifference, ...]  # Those that differ, flights and maneuvers among them.
    values: tuple[ValueDifference, ...]  # In the order of the build-up.
    versions: tuple[str, ...] = ()  # What differs, in words.


def compare_runs(
    one: StoredRun, other: StoredRun, *, means: Literal["values", "campaign"] = "values"
) -> RunComparison:
    """Return two runs beside each other.

    `means`: which of their means.

    Raises `FlightError` if what one of them was asked for cannot be read.
    """
    asked = one.request, other.request
    order = {name: index for index, name in enumerate(derivative_names())}
    ones: Mapping[str, CampaignValue] = getattr(one, means)
    others: Mapping[str, CampaignValue] = getattr(other, means)
    names = sorted({*ones, *others}, key=lambda name: (order.get(name, len(order)), name))
    return RunComparison(
        one=one.name,
        other=other.name if other.name != one.name else f"{other.name} ({other.number})",
        settings=(
            *(
                SettingDifference(name=name, one=first, other=second)
                for name, first, second in setting_differences(*asked)
            ),
            *_flight_differences(one, other),
            *_maneuver_differences(*asked),
        ),
        values=tuple(_compare_value(name, ones, others) for name in names),
        versions=tuple(version_differences(one.versions, other.versions)),
    )


def _compare_value(
    name: str, ones: Mapping[str, CampaignValue], others: Mapping[str, CampaignValue]
) -> ValueDifference:
    one, other = ones.get(name), others.get(name)
    if one is None or other is None:
        return ValueDifference(name=name, one=one, other=other)
    difference = other.mean - one.mean
    bound = math.hypot(one.std, other.std)
    return ValueDifference(
        name=name,
        one=one,
        other=other,
        difference=difference,
        in_bounds=difference / bound if bound > 0.0 else None,
    )


def _flight_differences(one: StoredRun, other: StoredRun) -> Iterator[SettingDifference]:
    if one.flights != other.flights:
        yield SettingDifference(
            name="flights", one=", ".join(one.flights), other=", ".join(other.flights)
        )
    sums = {file.name: file.sha256 for file in one.inputs if file.role == "flight"}
    for file in other.inputs:
        if sums.get(file.name, file.sha256) != file.sha256:
            yield SettingDifference(name=file.name, one="unchanged", other="changed since")


def _maneuver_differences(one: RunRequest, other: RunRequest) -> Iterator[SettingDifference]:
    edges = [
        {
            (chosen.flight.name, chosen.id): f"{chosen.t_start:.2f} to {chosen.t_end:.2f} s"
            for chosen in request.maneuvers
        }
        for request in (one, other)
    ]
    for key in dict.fromkeys((*edges[0], *edges[1])):
        first, second = (own.get(key, "not used") for own in edges)
        if first != second:
            yield SettingDifference(name=f"maneuver {key[1]} of {key[0]}", one=first, other=second)
