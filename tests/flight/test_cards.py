"""Test cards: files with all their mistakes told, and maneuvers matched to what was planned."""

import io
from dataclasses import replace
from typing import Any

import pytest

from gsapp.cli._console import PlainConsole
from gsapp.cli.maneuvers import print_card_status
from gsapp.flight.cards import (
    CardSet,
    TestCard,
    compare_with_card,
    load_cards,
    match_cards,
    save_cards,
    shipped_cards,
)
from gsapp.flight.folder import FlightFolder
from gsapp.flight.maneuvers import DetectedManeuver
from gsapp.foundation import FileProblemsError
from gsapp.foundation.toml import validate_content
from gsapp.quantities.constants import DEGREE, FOOT

E1: dict[str, Any] = {
    "id": "E1",
    "speed": "100 ft/s",
    "surfaces": ["de"],
    "amplitude": "4 deg",
    "width": "0.5 s",
    "repeats": 2,
}
E2 = {**E1, "id": "E2", "speed": "85 ft/s", "repeats": 1}
C1 = {
    **E1,
    "id": "C1",
    "surfaces": ["da", "dr"],
    "amplitude": {"da": "6 deg", "dr": "10 deg"},
    "repeats": 1,
}


def cards(*rows: dict[str, Any]) -> CardSet:
    return validate_content("cards.toml", {"cards": list(rows)}, CardSet)


def flown(number: int = 1, **changes: Any) -> DetectedManeuver:
    """Return an elevator doublet as the card E1 asks for, but for what is given."""
    start = 10.0 * number
    usual = DetectedManeuver(
        id=str(number),
        t_start=start,
        t_end=start + 6.0,
        inputs=("de",),
        kind="doublet",
        amplitude=4.0 * DEGREE,
        amplitudes={"de": 4.0 * DEGREE},
        grade="A",
        V=100.0 * FOOT,
        alpha=4.0 * DEGREE,
        t_input=start + 1.0,
        t_input_end=start + 2.0,
    )
    return replace(usual, **changes)


def test_the_shipped_cards_are_a_flight(tmp_path) -> None:
    assert "b777" in shipped_cards()
    for name in shipped_cards():
        found = load_cards(name)
        assert load_cards(save_cards(tmp_path / "cards.toml", found)) == found
        # Seven minutes give nine to thirteen maneuvers.
        assert sum(card.repeats for card in found.cards) <= 13


def test_all_mistakes_of_all_cards_are_told_at_once(tmp_path) -> None:
    """Units, surfaces, sizes, unknown keys, ids given twice: one pass with key paths."""
    path = tmp_path / "plan.toml"
    path.write_text(
        """
[[cards]]
id = "E"
speed = "100 kg"
surfaces = ["de", "de"]
amplitude = "90 deg"
width = "0.4 s"
throttle_step = 3
repeats = 0
[[cards]]
id = "E"
sped = "90 ft/s"
speed = "90 ft/s"
surfaces = ["elevator"]
amplitude = "3 deg"
width = "400 s"
tolerance = { speed = "-1 ft/s" }
[[cards]]
id = "R"
speed = "90 ft/s"
surfaces = ["da", "dr"]
amplitude = { da = "3 deg" }
width = "0.4 s"
"""
    )
    with pytest.raises(FileProblemsError) as caught:
        load_cards(path)
    text = str(caught.value)
    for part in (
        "cards[0].speed: 'kg' is not a unit of speed",
        "cards[0].surfaces: names none, or one twice",
        "cards[0].amplitude: must lie between 0 and 45 deg",
        "cards[0].throttle_step: must lie from -1 to 1",
        "cards[0].repeats: must lie from 1",
        "cards[1].sped: is not a known key; did you mean 'speed'?",
        "cards[1].surfaces[0]: input should be 'de', 'da' or 'dr'",
        "cards[1].width: must lie from 0.05 to 30 s",
        "cards[1].tolerance.speed: must be greater than zero",
        "cards[2]: amplitude is given for da, but da, dr move",
        "cards: the id 'E' is given 2 times",
    ):
        assert part in text
    path.write_text("name = 'none'\n")
    with pytest.raises(FileProblemsError, match="cards: is missing"):
        load_cards(path)


def test_cards_are_kept_with_the_flight(tmp_path) -> None:
    folder = FlightFolder.create(tmp_path / "f")
    assert folder.cards() is None
    plan = cards(E1, C1)
    folder.store_cards(plan)
    assert folder.cards() == plan


def test_a_card_is_done_when_enough_good_ones_were_flown() -> None:
    plan = cards(E1, C1)
    assert match_cards(plan, []).next_card.id == "E1"
    one = match_cards(plan, [flown(1)])
    assert (one.cards[0].state, one.cards[0].remaining_count) == ("begun", 1)
    two = match_cards(plan, [flown(1), flown(2)])
    assert two.cards[0].state == "done"
    assert two.next_card.id == "C1"
    combo = flown(
        3, inputs=("da", "dr"), amplitudes={"da": 6.5 * DEGREE, "dr": 9.0 * DEGREE}, amplitude=0.11
    )
    whole = match_cards(plan, [flown(1), flown(2), combo])
    assert whole.is_complete
    assert whole.next_card is None
    assert whole.unplanned == ()


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"V": 107.0 * FOOT}, "speed 7.0 ft/s too fast, 5.0 ft/s allowed"),
        ({"V": 94.0 * FOOT}, "speed 6.0 ft/s too slow"),
        (
            {"amplitudes": {"de": 2.0 * DEGREE}},
            "amplitude of the elevator 50 % too small, 35 % allowed",
        ),
        ({"amplitudes": {"de": 6.0 * DEGREE}}, "amplitude of the elevator 50 % too large"),
        ({"t_input_end": 11.4}, "width 60 % too short"),
        ({"grade": "D", "reasons": ("the sensor clipped",)}, "unfit (the sensor clipped)"),
    ],
)
def test_what_misses_the_card_does_not_count_and_says_why(changes, reason) -> None:
    result = match_cards(cards(E1), [flown(1, **changes)])
    (attempt,) = result.cards[0].attempts
    assert not attempt.is_counted
    assert len(attempt.reasons) == 1
    assert reason in attempt.reasons[0]
    assert result.cards[0].state == "open"


def test_maneuvers_go_to_the_card_they_were_flown_for() -> None:
    plan = cards(E1, E2)
    slow = flown(1, V=86.0 * FOOT)
    fast = flown(2, V=101.0 * FOOT)
    result = match_cards(plan, [slow, fast])
    assert [len(one.attempts) for one in result.cards] == [1, 1]
    assert result.cards[1].attempts[0].maneuver is slow
    # 90 ft/s fits neither, and lies nearer to 85.
    between = match_cards(plan, [flown(1, V=91.0 * FOOT)])
    assert [len(one.attempts) for one in between.cards] == [0, 1]
    twins = cards({**E1, "repeats": 1}, {**E1, "id": "E9", "repeats": 1})
    assert match_cards(twins, [flown(1), flown(2)]).is_complete
    odd = match_cards(plan, [flown(1, inputs=("dr",)), flown(2, kind="3-2-1-1")])
    assert [one.id for one in odd.unplanned] == ["1", "2"]


def test_what_was_not_measured_is_not_held_against_a_maneuver() -> None:
    card = TestCard.model_validate({**E1, "alpha": "9 deg"})
    assert compare_with_card(card, flown(1, alpha=None, V=None)).is_counted
    far = compare_with_card(card, flown(1))
    assert set(far.deviations) == {"speed", "alpha", "amplitude of the elevator", "width"}
    assert far.deviations["alpha"] == pytest.approx(-5.0 / 1.5)
    bare = compare_with_card(card, flown(1, alpha=None, amplitudes={}, t_input=float("nan")))
    assert bare.deviations["amplitude of the elevator"] == pytest.approx(0.0, abs=1e-12)
    assert "width" not in bare.deviations


def test_the_command_line_tells_what_is_done_and_what_is_open(tmp_path) -> None:
    """Cards of the flight folder as a table, with the reason of each attempt that fails."""
    folder = FlightFolder.create(tmp_path / "f")
    screen = PlainConsole(width=120, record=True, file=io.StringIO())
    print_card_status(screen, folder.path, [flown(1)])
    assert screen.export_text() == ""
    folder.store_cards(cards(E1, C1))
    found = [flown(1), flown(2, V=120.0 * FOOT), flown(3, inputs=("dr",))]
    print_card_status(screen, folder.path, found)
    text = " ".join(screen.export_text().split())
    for part in (
        "E1 Elevator doublet 1 of 2 begun",
        "C1 Aileron and rudder doublet 0 of 1 open",
        "E1: maneuver 2 not counted: speed 20.0 ft/s too fast, 5.0 ft/s allowed",
        "not on a card: 3",
    ):
        assert part in text
