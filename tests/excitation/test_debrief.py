"""Debriefs: stored and read back whole; trends from flight to flight; the command."""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gsapp.cli._usage_errors import CommandUsageError
from gsapp.cli.debrief import debrief as debrief_command
from gsapp.excitation.debrief import (
    Debrief,
    EvaluatedManeuver,
    ManeuverCurves,
    compute_flight_trend,
    compute_trends,
    extract_curves,
)
from gsapp.excitation.doublets.verdict import InputFinding, InputVerdict, VerdictResult
from gsapp.excitation.flight_rows import rows_from_block
from gsapp.excitation.test_points.point import TargetInput, TestPoint, ToleranceBand
from gsapp.flight.cards import save_cards
from gsapp.flight.catalog import (
    CardScore,
    Catalog,
    list_card_scores,
    search_verdicts,
    store_debrief,
)
from gsapp.flight.flight import Flight
from gsapp.flight.writers import write_block
from gsapp.foundation import FlightError
from gsapp.quantities import Block
from tests.excitation.cue_kit import CARDS, RATE, flown

WANTED = TargetInput(
    surfaces=("da", "dr"), kind="doublet", hands_off=3.0, mode="dutch roll", source="card",
    amplitudes={
        "da": ToleranceBand(low=0.05, best=0.1, high=0.15, why_low="noise", why_high="p clips"),
        "dr": ToleranceBand(low=0.1, best=0.2, high=np.inf),
    },
    width=ToleranceBand(low=0.3, best=0.5, high=0.7),
)  # fmt: skip
POINT = TestPoint(card="C1", speed=30.0, alpha=0.05, speed_tolerance=1.5, alpha_tolerance=0.03)


def judged(
    number: int, time: float, result: VerdictResult = "good", size: float = 1.0, go: bool = True
) -> EvaluatedManeuver:
    """Return a maneuver so many times as large as wanted."""
    times = np.arange(time, time + 4.0, 0.04)
    verdict = InputVerdict(
        id=f"M{number}", given_at=time + 4.5, t_start=time - 1.0, t_input=time,
        t_input_end=time + 1.5, t_end=time + 4.0, surfaces=("da", "dr"), kind="doublet",
        amplitudes={"da": 0.1 * size, "dr": 0.2 * size}, halves={"da": (0.5, 0.5), "dr": (0.6,)},
        symmetry={"da": 0.9}, left_over={"da": 0.0}, cross={"de": 0.01}, V=30.2, alpha=None,
        result=result,
        findings=() if result == "good" else (InputFinding(result=result, words="no", factor=1.5),),
        advice="good" if result == "good" else "once more", card="C1", counts=result == "good",
        judged_by=("bank: no attitude",),
    )  # fmt: skip
    return EvaluatedManeuver(
        verdict=verdict, target_input=WANTED, point=POINT, go_at=time - 0.5 if go else None,
        trim_deviations={"speed": 0.5 * (-1) ** number, "bank": 1.2},
        curves=ManeuverCurves(times=times, series={"da": np.sin(times), "p": np.full(times.size,
        np.nan)}),
    )  # fmt: skip


def flight_of(name: str) -> Flight:
    block = Block(channels=("V",), times=np.arange(10) / 10, values=np.full((10, 1), 30.0))
    return Flight(name=name, path=Path(name), block=block, sources={})


def test_a_maneuver_comes_back_from_its_record() -> None:
    one = judged(1, 20.0, "too-small")
    record = json.loads(json.dumps(one.to_record(), allow_nan=False))
    back = EvaluatedManeuver.from_record(record)
    assert (back.verdict, back.target_input, back.point) == (one.verdict, WANTED, POINT)
    assert (back.go_at, back.trim_deviations) == (one.go_at, one.trim_deviations)
    np.testing.assert_allclose(back.curves.times, one.curves.times, atol=1e-4)
    for name, values in one.curves.series.items():
        np.testing.assert_allclose(back.curves.series[name], values, rtol=1e-4)
    for wrong in (None, {}, {**record, "verdict": {"id": "M1"}}, {**record, "curves": 3}):
        with pytest.raises(FlightError, match="debrief the flight"):
            EvaluatedManeuver.from_record(wrong)


@settings(deadline=None, max_examples=30)  # the first one flies
@given(start=st.integers(0, 300), count=st.integers(1, 400))
def test_curves_are_samples_of_the_flight_whatever_is_cut_out(start: int, count: int) -> None:
    rows = rows_from_block(flown(), RATE)
    cut = extract_curves(rows.slice_rows(start, start + count), ("de",), RATE)
    whole = extract_curves(rows, ("de",), RATE)
    places = np.searchsorted(whole.times, cut.times)
    np.testing.assert_array_equal(whole.times[places], cut.times)
    for name, values in cut.series.items():
        np.testing.assert_array_equal(whole.series[name][places], values)
    assert cut.times.size <= count // 4 + 1


def test_trends_tell_sizes_errors_and_time() -> None:
    maneuvers = [
        judged(1, 20.0, "too-small", 0.5), judged(2, 55.0, "good", 0.9, go=False),
        judged(3, 100.0, "good", 1.2),
    ]  # fmt: skip
    scores = [
        CardScore(card="C1", title="", good=2, flown=3, requested=4),
        CardScore(card="E1", title="", good=3, flown=3, requested=2),
    ]
    trend = compute_flight_trend("a", maneuvers, scores)
    assert (trend.inputs, trend.good, trend.without_go) == (3, 2, 1)
    assert trend.results == {"too-small": 1, "good": 2}
    assert trend.amplitudes == pytest.approx({"da": 0.9, "dr": 0.9})
    assert trend.widths == pytest.approx(1.0)
    assert trend.trim_errors == pytest.approx({"speed": 0.5, "bank": 1.2})
    assert trend.seconds_each == pytest.approx(40.0)
    assert trend.score == pytest.approx(4 / 6)  # a third one of E1 is worth nothing
    assert trend.share_good == pytest.approx(2 / 3)
    empty = compute_flight_trend("b", ())
    assert (empty.share_good, empty.seconds_each, empty.score) == (0.0, None, None)
    json.dumps([trend.to_json(), empty.to_json()], allow_nan=False)


def test_trends_come_from_the_catalog_flight_by_flight(tmp_path: Path) -> None:
    flights = {"b": [judged(1, 20.0)], "a": [judged(1, 10.0, "invalid"), judged(2, 50.0)]}
    score = (CardScore(card="C1", title="both", good=1, flown=2, requested=4),)
    with Catalog(tmp_path / "c.sqlite") as catalog:
        for name, maneuvers in flights.items():
            made = Debrief(flight=name, maneuvers=tuple(maneuvers), cards=score)
            store_debrief(catalog, flight_of(name), made.to_stored_verdicts(), made.cards)
        scores = {name: list_card_scores(catalog, name) for name in flights}
        found = compute_trends(search_verdicts(catalog), scores)
    assert [one.flight for one in found] == ["a", "b"]
    assert found == tuple(compute_flight_trend(name, flights[name], score) for name in ("a", "b"))


def test_the_command_judges_keeps_and_compares(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, plan = tmp_path / "small.csv", tmp_path / "cards.toml"
    write_block(path, flown(size=2.0), "csv")
    save_cards(plan, CARDS)
    catalog, target = tmp_path / "c.sqlite", tmp_path / "out.json"
    debrief_command(flights=[path], aircraft="b777", cards=str(plan), catalog=catalog, json=target)
    told = json.loads(target.read_text())
    (one,) = told["flights"]
    assert (one["flight"], one["results"], one["score"]) == ("small", {"too-small": 1}, 0.0)
    (trend,) = told["trends"]
    assert trend["amplitudes"]["de"] == pytest.approx(2.0 / 4.5, rel=0.2)
    shown = capsys.readouterr().out
    assert "small: 1 input" in shown
    assert "twice" in shown
    assert "E1: 0 of 2 good, 1 flown" in shown
    debrief_command(flights=[], catalog=catalog)
    again = capsys.readouterr().out
    assert "flight to flight" in again
    assert "small: elevator 0.4" in again
    assert "written" not in again
    with pytest.raises(CommandUsageError, match="nothing to debrief"):
        debrief_command(flights=[])
