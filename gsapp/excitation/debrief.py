"""The debrief of a flight: inputs with verdicts, how the test cards were flown, and trends."""

from __future__ import annotations

import math
import statistics
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby, pairwise
from typing import TYPE_CHECKING, Any, Final, cast

import numpy as np
from pydantic import TypeAdapter

from gsapp.excitation.announcer import Announcement
from gsapp.excitation.cues import CueEvent
from gsapp.excitation.doublets.verdict import InputVerdict
from gsapp.excitation.flight_rows import FlightRows
from gsapp.excitation.settings import CUES
from gsapp.excitation.test_points.point import TargetInput, TestPoint
from gsapp.flight.cards import CardSetProgress
from gsapp.flight.catalog import CardScore, StoredVerdict
from gsapp.foundation import FlightError
from gsapp.quantities import FloatArray

_ANSWERS: Final[Mapping[str, tuple[str, ...]]] = {
    "de": ("q", "alpha", "an"),
    "da": ("p", "phi"),
    "dr": ("r", "beta", "ay"),
}
"""What answers to each surface."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ManeuverCurves:
    """A few samples a second of some channels, for a small plot."""

    times: FloatArray
    """Shape (n,). Flight time, s."""
    series: Mapping[str, FloatArray]
    """Shape (n,). By channel, SI; NaN where missing."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class EvaluatedManeuver:
    """A maneuver with all that the debrief shows of it."""

    verdict: InputVerdict
    target_input: TargetInput | None
    """What was asked for when it was flown."""
    point: TestPoint | None
    """Where it should have begun."""
    go_at: float | None
    """When GO was given before it, s; None if it was flown without."""
    trim_deviations: Mapping[str, float]
    """What was off as it began, in tolerances, signed; of ``speed``, ``bank`` ..."""
    curves: ManeuverCurves

    def to_json(self) -> dict[str, Any]:
        """Return what a program reads of it, without the curves. SI, absent = None."""
        record = self.to_record()
        return {
            **record["verdict"],
            "wanted": record["wanted"],
            "go_at": record["go_at"],
            "off": record["off"],
        }

    def to_record(self) -> dict[str, Any]:
        """Return what JSON can hold; `from_record` reads it back. SI, absent = None."""
        return {
            "verdict": _json(_VERDICT.dump_python(self.verdict, mode="json")),
            "wanted": _json(_WANTED.dump_python(self.target_input, mode="json")),
            "point": _json(_POINT.dump_python(self.point, mode="json")),
            "go_at": self.go_at,
            "off": _json(dict(self.trim_deviations)),
            "curves": {
                "times": [round(float(time), 4) for time in self.curves.times],
                "series": {
                    name: [_sample(value) for value in values]
                    for name, values in self.curves.series.items()
                },
            },
        }

    @staticmethod
    def from_record(record: object) -> EvaluatedManeuver:
        """Return the maneuver that `to_record` made."""
        try:
            return _read(cast("Mapping[str, Any]", record))
        except (KeyError, TypeError, ValueError, AttributeError) as error:
            raise FlightError(
                f"a stored verdict cannot be read ({error}); debrief the flight again"
            ) from error


def extract_curves(
    rows: FlightRows | None, surfaces: tuple[str, ...], rate: float
) -> ManeuverCurves:
    """Return the surfaces that moved and their answers, thinned; empty without rows."""
    if rows is None:
        return ManeuverCurves(times=np.empty(0), series={})
    every = max(1, round(rate / CUES.plot_rate))
    kept = (rows.first_index + np.arange(len(rows))) % every == 0
    names = dict.fromkeys((*surfaces, *(name for one in surfaces for name in _ANSWERS[one])))
    series = {name: rows[name][kept] for name in names}
    return ManeuverCurves(
        times=rows.times[kept],
        series={name: values for name, values in series.items() if np.isfinite(values).any()},
    )


_VERDICT: Final = TypeAdapter(InputVerdict)
_WANTED: Final = TypeAdapter[TargetInput | None](TargetInput | None)
_POINT: Final = TypeAdapter[TestPoint | None](TestPoint | None)


def _read(record: Mapping[str, Any]) -> EvaluatedManeuver:
    curves = record["curves"]
    return EvaluatedManeuver(
        verdict=_VERDICT.validate_python(record["verdict"]),
        target_input=_WANTED.validate_python(record["wanted"]),
        point=_POINT.validate_python(record["point"]),
        go_at=record["go_at"],
        trim_deviations={str(name): float(share) for name, share in record["off"].items()},
        curves=ManeuverCurves(
            times=np.array(curves["times"], dtype=np.float64),
            series={
                name: np.array([math.nan if one is None else one for one in values])
                for name, values in curves["series"].items()
            },
        ),
    )


def _sample(value: float) -> float | None:
    return float(f"{value:.5g}") if math.isfinite(value) else None


def _json(content: Any) -> Any:
    if isinstance(content, dict):
        return {name: _json(one) for name, one in content.items()}
    if isinstance(content, list):
        return [_json(one) for one in content]
    if isinstance(content, float) and not math.isfinite(content):
        return str(content)
    return content


if TYPE_CHECKING:
    from gsapp.excitation.cueing import CueGenerator


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Debrief:
    """What there is to say of a flight afterwards."""

    flight: str
    maneuvers: tuple[EvaluatedManeuver, ...]
    """Every input, by time."""
    cards: tuple[CardScore, ...] = ()
    """In the order of the cards; empty without cards."""
    events: tuple[CueEvent, ...] = ()
    """All that changed for the crew."""
    announcements: tuple[Announcement, ...] = ()
    """All that was to be heard."""
    limitations: tuple[str, ...] = ()
    """What could not be judged, in words."""

    @property
    def good(self) -> int:
        return sum(one.verdict.result == "good" for one in self.maneuvers)

    @property
    def results(self) -> dict[str, int]:
        return dict(Counter(one.verdict.result for one in self.maneuvers).most_common())

    @property
    def score(self) -> float | None:
        """Return the share of the repeats asked for that were flown well, 0 to 1.

        None without cards.
        """
        wanted = sum(one.requested for one in self.cards)
        return sum(min(one.good, one.requested) for one in self.cards) / wanted if wanted else None

    def to_stored_verdicts(self) -> tuple[StoredVerdict, ...]:
        """Return the verdicts for a catalog."""
        return tuple(
            StoredVerdict(
                name=one.verdict.id,
                t_input=one.verdict.t_input,
                t_end=one.verdict.t_end,
                surfaces=one.verdict.surfaces,
                kind=one.verdict.kind,
                V=one.verdict.V,
                result=one.verdict.result,
                advice=one.verdict.advice,
                card=one.verdict.card,
                is_counted=one.verdict.counts,
                record=one.to_record(),
            )
            for one in self.maneuvers
        )

    def cues_json(self) -> list[dict[str, Any]]:
        """Return what changed and what was heard, by time, for programs."""
        cues = [event.to_json() for event in self.events]
        cues += [
            {
                "time": round(one.time, 6),
                "kind": "spoken",
                "state": one.priority,
                "words": one.text,
                "data": {"tone": one.tone} if one.tone else {},
            }
            for one in self.announcements
        ]
        return sorted(cues, key=lambda cue: cue["time"])

    def to_json(self) -> dict[str, Any]:
        """Return what a program reads: SI, absent = None."""
        return {
            "flight": self.flight,
            "score": self.score,
            "good": self.good,
            "results": self.results,
            "cards": [
                {name: getattr(card, name) for name in CardScore.__slots__} for card in self.cards
            ],
            "maneuvers": [one.to_json() for one in self.maneuvers],
            "missing": list(self.limitations),
        }


def create_debrief(name: str, cueing: CueGenerator) -> Debrief:
    """Return the debrief of a flight that was followed."""
    return Debrief(
        flight=name,
        maneuvers=tuple(cueing.maneuvers),
        cards=score_cards(cueing.card_progress),
        events=tuple(cueing.log),
        announcements=tuple(cueing.announcements),
        limitations=cueing.snapshot().limitations,
    )


def score_cards(flown: CardSetProgress | None) -> tuple[CardScore, ...]:
    """Return how the cards were flown; empty without cards."""
    return tuple(
        CardScore(
            card=one.card.id,
            title=one.card.display_title,
            good=one.good_count,
            flown=len(one.attempts),
            requested=one.card.repeats,
        )
        for one in (() if flown is None else flown.cards)
    )


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
    """Return what the verdicts of a catalog show flight by flight, in its order."""
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
