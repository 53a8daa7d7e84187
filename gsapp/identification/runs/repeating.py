"""A kept run done again, and what differs in words."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from gsapp.flight.catalog import Catalog, Run, StoredEstimate, search_runs
from gsapp.flight.provenance import InputFile, changed
from gsapp.foundation.naming import listed
from gsapp.identification.campaign import Step
from gsapp.identification.runs.choosing import Doing
from gsapp.identification.runs.keeping import KeptRun, kept
from gsapp.identification.runs.outcome import Outcome
from gsapp.identification.runs.running import run
from gsapp.identification.runs.shelf import FlightShelf
from gsapp.identification.storing import stored_estimates

_MOST_NAMED = 4
"""Derivatives named where values differ."""
_KEPT_ITSELF = frozenset({"model", "weights"})
"""Files whose content is kept with the run: what became of them since does not matter."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Repeated:
    """A run done again.

    Attributes
    ----------
    outcome : Outcome
    same : bool
        Whether every value and bound of every maneuver is the same to the last bit.
    differences : tuple of str
        Files and versions that changed since, and values that differ, in words.
    """

    outcome: Outcome
    same: bool
    differences: tuple[str, ...]


def repeat(
    catalog: Catalog,
    number: int,
    *,
    flights: FlightShelf | None = None,
    doing: Doing | None = None,
    progress: Step | None = None,
) -> Repeated:
    """Do a kept run again, from exactly what it was asked for.

    Parameters
    ----------
    catalog : Catalog
    number : int
    flights, doing, progress
        As for `run`.

    Raises
    ------
    UnknownNameError
        If there is no such run.
    GroundStationError
        If a flight of it cannot be read any more; see `run`.
    """
    before = kept(catalog, number)
    fits = search_runs(catalog, kept=number)
    outcome = run(before.request, flights=flights, doing=doing, progress=progress)
    other = tuple(_other_values(before, fits, outcome))
    around = (
        *_other_inputs(before.inputs, outcome.inputs),
        *other_versions(before.versions, outcome.versions),
    )
    if other and not around:
        other = (*other, "files and versions are the same: the program itself was changed since")
    return Repeated(outcome=outcome, same=not other, differences=(*around, *other))


def other_versions(before: Mapping[str, str], now: Mapping[str, str]) -> Iterator[str]:
    """Yield what differs between two sets of versions, in words."""
    for name in dict.fromkeys((*before, *now)):
        if before.get(name) != now.get(name):
            yield f"{name} was {before.get(name, 'not there')}, and is {now.get(name, 'not there')}"


def _other_inputs(before: Sequence[InputFile], now: Sequence[InputFile]) -> Iterator[str]:
    one = [file for file in before if file.role not in _KEPT_ITSELF]
    other = [file for file in now if file.role not in _KEPT_ITSELF]
    # The same request has the same files in the same order, but for certificates of a folder.
    for old, new in zip(one, other, strict=False):
        for name in changed(old, new):
            yield f"{name} has changed"
    for file in (*one[len(other) :], *other[len(one) :]):
        yield f"{file.name} was not there both times"


def _other_values(before: KeptRun, fits: Sequence[Run], outcome: Outcome) -> Iterator[str]:
    """Yield which values differ by a bit or more, fit by fit."""
    again = [one.estimate for one in outcome.result.results if one.estimate is not None]
    fitted = [*again, *outcome.result.joint]
    failures = {
        one.maneuver.id: one.failure for one in outcome.result.results if one.estimate is None
    }
    if failures != dict(before.failures) or len(fits) != len(fitted):
        yield "other maneuvers could be fitted than then"
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
            words = [_change(name, old.estimates.get(name), new.get(name)) for name in names]
            yield f"maneuver {which}: {listed(words, _MOST_NAMED)}"
    means = {name: one.value for name, one in outcome.summary.derivatives.items()}
    moved = [name for name in means if means[name] != before.values.get(name)]
    if moved or set(means) != set(before.values):
        yield f"the means of {', '.join(moved) or 'other derivatives'} differ"


def _change(name: str, old: StoredEstimate | None, new: StoredEstimate | None) -> str:
    one = None if old is None else old.value
    other = None if new is None else new.value
    if one is None or other is None:
        return f"{name} was {_status(old)}, and is {_status(new)}"
    if one == other:
        return f"the bound of {name} differs"
    return f"{name} was {one:.6g}, and is {other:.6g} ({other - one:+.2g})"


def _status(one: StoredEstimate | None) -> str:
    if one is None:
        return "absent"
    return one.status if one.value is None else f"{one.value:.6g}"
