"""A kept run done again, and what differs in words."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from gsapp.flight.catalog import Catalog, EstimationRun, StoredEstimate, search_runs
from gsapp.flight.provenance import InputFile, find_changed_parts
from gsapp.foundation.name_suggestions import format_names
from gsapp.identification.campaign import CampaignProgressCallback
from gsapp.identification.catalog_storage import stored_estimates
from gsapp.identification.runs.flight_cache import FlightCache
from gsapp.identification.runs.maneuver_selection import StatusCallback
from gsapp.identification.runs.outcome import RunOutcome
from gsapp.identification.runs.run_execution import execute_run
from gsapp.identification.runs.run_store import StoredRun, load_run

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

    Raises
    ------
    UnknownNameError
        If there is no such run.
    GroundStationError
        If a flight of it cannot be read any more; see `execute_run`.
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
