"""What became better or worse from flight to flight."""

from __future__ import annotations

import statistics
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby, pairwise
from typing import Any

from gsapp.excitation.debrief_maneuver import EvaluatedManeuver
from gsapp.flight.catalog import CardScore, StoredVerdict


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightTrend:
    """One flight in a row of flights."""

    flight: str
    inputs: int
    good: int
    """All that were judged, and the good ones."""
    results: Mapping[str, int]
    """How many came to each verdict."""
    amplitudes: Mapping[str, float]
    """By surface: median of the amplitude flown over the best of what was wanted; 1 is right."""
    widths: float | None
    """The same of the width of the steps."""
    trim_errors: Mapping[str, float]
    """Median of what was off as inputs began, in tolerances; of ``speed``, ``bank`` ..."""
    without_go: int
    """Inputs begun without GO."""
    seconds_each: float | None
    """Median time from one input to the next; None for fewer than two."""
    score: float | None
    """Share of the repeats asked for that were flown well; None without cards."""

    @property
    def share_good(self) -> float:
        """Return the share of good inputs, 0 to 1."""
        return self.good / self.inputs if self.inputs else 0.0

    def to_json(self) -> dict[str, Any]:
        """Return what a program reads."""
        return {
            **{name: getattr(self, name) for name in FlightTrend.__slots__},
            "results": dict(self.results),
            "amplitudes": dict(self.amplitudes),
            "trim_errors": dict(self.trim_errors),
            "share_good": self.share_good,
        }


def compute_trends(
    verdicts: Sequence[StoredVerdict], scores: Mapping[str, Sequence[CardScore]] | None = None
) -> tuple[FlightTrend, ...]:
    """Return what the flights of a catalog show, in its order.

    Parameters
    ----------
    verdicts : sequence of StoredVerdict
        As `gsapp.flight.catalog.search_verdicts` gives them: flight by flight.
    scores : mapping of str to sequence of CardScore, optional
        By flight.

    Raises
    ------
    FlightError
        If a stored verdict cannot be read.
    """
    return tuple(
        compute_flight_trend(
            flight,
            [EvaluatedManeuver.from_record(one.record) for one in stored],
            (scores or {}).get(flight, ()),
        )
        for flight, stored in groupby(verdicts, key=lambda one: one.flight)
    )


def compute_flight_trend(
    flight: str, maneuvers: Sequence[EvaluatedManeuver], scores: Sequence[CardScore] = ()
) -> FlightTrend:
    """Return what one flight shows."""
    sizes: dict[str, list[float]] = {}
    widths: list[float] = []
    errors: dict[str, list[float]] = {}
    results: dict[str, int] = {}
    for one in maneuvers:
        results[one.verdict.result] = results.get(one.verdict.result, 0) + 1
        for name, share in one.trim_deviations.items():
            errors.setdefault(name, []).append(abs(share))
        if one.target_input is None:
            continue
        for surface, band in one.target_input.amplitudes.items():
            if surface in one.verdict.amplitudes and band.best > 0.0:
                share = one.verdict.amplitudes[surface] / band.best
                sizes.setdefault(surface, []).append(share)
        widths += [
            step / one.target_input.width.best
            for steps in one.verdict.halves.values()
            for step in steps
        ]
    wanted = sum(one.requested for one in scores)
    begun = [one.verdict.t_input for one in maneuvers]
    return FlightTrend(
        flight=flight,
        inputs=len(maneuvers),
        good=results.get("good", 0),
        results=results,
        amplitudes=_medians(sizes),
        widths=_median(widths),
        trim_errors=_medians(errors),
        without_go=sum(one.go_at is None for one in maneuvers),
        seconds_each=_median(after - before for before, after in pairwise(begun)),
        score=sum(min(one.good, one.requested) for one in scores) / wanted if wanted else None,
    )


def _median(values: Iterable[float]) -> float | None:
    found = list(values)
    return statistics.median(found) if found else None


def _medians(values: Mapping[str, Sequence[float]]) -> dict[str, float]:
    return {name: statistics.median(found) for name, found in values.items() if found}
