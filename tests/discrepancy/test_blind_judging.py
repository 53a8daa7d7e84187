"""Proves the marks of the benchmark: right and wrong answers to blind cases are told apart."""

import importlib.util
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from tests.discrepancy.blind import answering, flying, judging, sensitivity
from tests.discrepancy.blind.cases import CLOCKS, Case, hidden
from tests.discrepancy.blind.judging import Named, Outcome, judge
from tests.discrepancy.blind.plan import PLAN
from tests.discrepancy.blind.sensitivity import Showing


@pytest.fixture(autouse=True)
def _what_shows(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let effects show as the tests need it; nothing is flown for it."""
    found = Showing(
        per_size={
            "aero.Cm.alpha2": 200.0,
            "aero.Cl.dr": 1000.0,
            "sensor.alpha.lag": 4000.0,
            "aero.Cm.flap": 1000.0,
        },
        alike={
            "aero.Cm.flap": {"b": 0.99},
            "aero.Cm.alpha2": {"aero.Cm.alpha_q": 0.8},
            "aero.Cl.dr": {},
            "sensor.alpha.lag": {"sensor.alpha.delay": 0.9999},
        },
        where={"aero.Cm.alpha2": {"3": 0.6, "4": 0.35, "1": 0.05}},
    )
    for module in (judging, sensitivity):
        monkeypatch.setattr(module, "showing", lambda *_: found)


CURVED = hidden("aero.Cm.alpha2", -0.05)


def told(effect: str, size: float = -0.05, std: float = 0.005, **how: object) -> Outcome:
    named = (Named(effect=effect, confidence=0.9, size=size, std=std),)
    content: dict[str, Any] = {"id": "x", "verdict": "effects-found", "named": named, **how}
    return Outcome(**content)


def test_the_right_name_first_earns_all_marks() -> None:
    answer = told("aero.Cm.alpha2", -0.047, 0.005, coefficient="Cm", maneuver="B:3")
    marks = judge(CURVED, answer)
    assert marks.verdict
    assert marks.first
    assert marks.three
    assert not marks.false_name
    assert marks.coefficient
    assert marks.maneuver
    assert marks.size_error == pytest.approx(0.06)
    assert marks.covered
    assert marks.confidences == ((0.9, True),)
    assert not judge(CURVED, replace(answer, maneuver="1")).maneuver
    assert not judge(CURVED, replace(answer, coefficient="CZ")).coefficient
    assert not judge(CURVED, told("aero.Cm.alpha2", -0.03, 0.005)).covered


def test_a_wrong_name_is_false_even_if_the_truth_ranks_second() -> None:
    marks = judge(CURVED, told("aero.Cm.alpha_q", ranking=("aero.Cm.alpha_q", "aero.Cm.alpha2")))
    assert marks.first is False
    assert marks.three
    assert marks.false_name
    assert marks.confidences == ((0.9, False),)
    nothing = judge(CURVED, Outcome(id="x", verdict="model-adequate"))
    assert (nothing.first, nothing.three, nothing.false_name) == (False, False, False)


def test_a_false_name_beside_the_right_one_is_seen() -> None:
    both = (Named(effect="aero.Cm.alpha2", confidence=1.0), Named(effect="aero.Cl.p", confidence=1))
    marks = judge(CURVED, Outcome(id="x", verdict="effects-found", named=both))
    assert marks.first
    assert marks.false_name


def test_not_to_be_told_apart_is_right_with_the_truth_in_the_set() -> None:
    late = hidden("sensor.alpha.lag", 0.003)
    answer = Outcome(
        id="x", verdict="ambiguous", open=(("sensor.alpha.delay", "sensor.alpha.lag"),)
    )
    marks = judge(late, answer)
    assert (marks.first, marks.ambiguity, marks.deserved) == (False, True, True)
    assert marks.first_or_ambiguous
    marks = judge(CURVED, answer)
    assert (marks.ambiguity, marks.deserved) == (False, False)


def test_nothing_hidden_allows_no_name_but_a_late_clock_allows_a_delay() -> None:
    clean = Case(id="clean", group="nothing", verdicts=("model-adequate",))
    assert judge(clean, Outcome(id="x", verdict="model-adequate")).verdict
    assert judge(clean, told("sensor.airdata.delay")).false_name
    assert not judge(clean, told("unnamed.Cm.alpha_de2")).false_name
    assert not judge(clean, told("aero.Cm.memory")).false_name
    clock = replace(clean, clock="air", accepted=(CLOCKS["air"],))
    assert not judge(clock, told("sensor.airdata.delay")).false_name
    assert judge(clock, told("aero.Cm.alphadot")).false_name


def test_outside_the_catalog_abstaining_is_right() -> None:
    outside = Case(
        id="o", group="outside", effects={"outside.Cm.alpha3": -0.3}, verdicts=("unexplained",)
    )
    assert judge(outside, Outcome(id="x", verdict="unexplained")).abstained
    assert judge(outside, told("unnamed.Cm.alpha3")).abstained
    assert not judge(outside, told("aero.Cm.alpha2")).abstained


def test_two_effects_need_both_names_and_a_missing_derivative_may_be_a_value() -> None:
    pair = Case(
        id="p", group="pair", effects={"aero.Cm.flap": -0.01, "aero.Cl.da3": -1.0},
        verdicts=("effects-found",), accepted=(("aero.Cm.flap",), ("aero.Cl.da3",)),
    )  # fmt: skip
    one = Named(effect="aero.Cl.da3", confidence=0.9)
    two = Named(effect="aero.Cm.flap", confidence=0.9)
    assert not judge(pair, Outcome(id="x", verdict="effects-found", named=(one,))).first
    assert judge(pair, Outcome(id="x", verdict="effects-found", named=(one, two))).first
    # The other half may be in a set that these flights cannot tell apart.
    open_ = Outcome(id="x", verdict="effects-found", named=(one,), open=(("aero.Cm.flap", "b"),))
    assert judge(pair, open_).first_or_ambiguous
    assert judge(pair, open_).deserved
    assert not judge(pair, replace(open_, open=(("a", "b"),))).first_or_ambiguous
    lacking = replace(hidden("aero.Cl.dr", 0.01), verdicts=("effects-found", "values-wrong"))
    assert judge(lacking, Outcome(id="x", verdict="values-wrong", values=("Cl_dr",))).first
    assert not judge(lacking, Outcome(id="x", verdict="values-wrong", values=("Cl_da",))).first


def test_answers_are_kept_and_taken_up_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A case is put to the program once; its kept answer is the same answer."""
    asked = []

    def answer(case: Case) -> Outcome:
        asked.append(case.id)
        return told("aero.Cm.alpha2", ranking=("a", "b"), open=(("a",), ("b", "c")))

    monkeypatch.setattr(answering, "answer", answer)
    first = answering.kept(CURVED, tmp_path)
    assert answering.kept(CURVED, tmp_path) == first
    assert asked == [CURVED.id]


def test_what_the_program_refuses_is_a_failed_case(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(answering, "fly_case", lambda case: flying.fly_case(case, PLAN[:1]))
    outcome = answering.answer(Case(id="one maneuver", group="nothing"))
    assert outcome.verdict == "failed"
    assert outcome.error


def test_the_benchmark_prints_what_was_asked_for(capsys: pytest.CaptureFixture[str]) -> None:
    """Every table of the benchmark, from made-up answers."""
    place = Path(__file__).parents[1] / "bench" / "discrepancy.py"
    spec = importlib.util.spec_from_file_location("bench_discrepancy", place)
    bench = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = bench
    spec.loader.exec_module(bench)
    right = told("aero.Cm.alpha2", coefficient="Cm", maneuver="3", cpu=7.0, closed=0.97)
    wrong = told("aero.Cm.alpha_q", ranking=("aero.Cm.alpha_q", "aero.Cm.alpha2"))
    strong = replace(CURVED, sigma=10.0)
    clean = Case(id="c", group="nothing", kind="clean", verdicts=("model-adequate",))
    outside = Case(
        id="o", group="outside", kind="outside.Cm.alpha3", effects={"outside.Cm.alpha3": 1.0}
    )
    answers = [
        (strong, right),
        (strong, wrong),
        (replace(strong, gust=0.3), right),
        (clean, Outcome(id="c", verdict="model-adequate")),
        (clean, wrong),
        (outside, Outcome(id="o", verdict="unexplained")),
    ]
    bench.report([bench.Row(case=a, outcome=b, marks=judge(a, b)) for a, b in answers])
    said = capsys.readouterr().out
    for text in (
        "66.7 %/3", "by size", "by air", "gusts 0.3 m/s", "by effect", "by baseline", "coefficient",
        "maneuver", "covered", "closed %", "97.0", "size off %", "in three", "100.0 %/3",
        "nothing hidden", "50.0 %/2", "outside the catalog", "confidence: said, right",
        "CPU s a case",
    ):  # fmt: skip
        assert text in said, text
