"""What stands on the pilot's page for every state of the cues, without a window."""

import subprocess
import sys
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gsapp.excitation.doublets.verdict import VerdictResult
from gsapp.excitation.settings import CUES
from gsapp.quantities.constants import DEGREE, FOOT
from tests.ui.pilot_kit import (
    BASE,
    CARD,
    CARDS,
    NEXT,
    OUTLOOK,
    STATES,
    VERDICT,
    WANTED,
    cue,
    danger,
    display,
    moving,
)
from ui.display_limits import DISPLAY
from ui.pilot.cue_display import RESULT_SIGNS, CueDisplay
from ui.pilot.cue_display import TRIM_STATE_SIGNS as STATE_WORDS
from ui.pilot.cue_display_builder import CueDisplayInput, build_cue_display
from ui.pilot.page_state import CardBrowser, DisplayRateLimiter, find_last_flown_card


def sheet(name: str, **more: object) -> CueDisplay:
    return display(STATES[name], **more)


WORDS = {
    "fly": "FLY", "hold": "HOLD", "go": "GO", "gusty": "WAIT", "turn": "TURN", "blind": "NO CUE",
    "input": "INPUT", "hands-off": "HANDS OFF", "too-small": "TOO SMALL", "good": "GOOD",
    "danger": "LAND", "caution": "FLY",
}  # fmt: skip


@pytest.mark.parametrize(("name", "word"), WORDS.items())
def test_each_state_has_its_word(name: str, word: str) -> None:
    shown = sheet(name)
    assert shown.status_text == word
    assert shown.accessible_text.startswith(word)


def test_no_two_states_look_alike_without_color() -> None:
    for table in (STATE_WORDS, RESULT_SIGNS):
        words = [word for word, _, _ in table.values()]
        shapes = [shape for _, shape, _ in table.values()]
        assert len(set(words)) == len(words)
        assert len(set(shapes)) == len(shapes)
    assert set(RESULT_SIGNS) == set(VerdictResult.__args__)


def test_what_is_off_comes_largest_first_with_its_way() -> None:
    shown = sheet("fly")
    assert shown.hints[0].text.endswith("slow")
    assert "left wing low" in shown.hints[1].text
    assert [hint.sign for hint in shown.hints] == ["up", "wing-left"]
    # The large shape is that of the largest.
    assert shown.sign == "up"


def test_a_turn_points_to_a_side_only_where_it_is_known() -> None:
    assert sheet("turn").sign == "turn-right"
    unknown = replace(BASE, trim=cue("turn"))
    assert display(unknown).sign == "turn"


def test_guidance_takes_the_place_of_the_words_it_begins_with() -> None:
    slow = sheet("fly").hints[0].text
    cues = replace(BASE, guidance=f"{slow}: a little power")
    first, second = display(cues).hints
    assert (first.text, first.sign) == (f"{slow}: a little power", "up")
    assert second == sheet("fly").hints[1]


def test_the_test_point_is_a_number_and_a_bar_with_the_wanted_band() -> None:
    (gauge,) = sheet("fly").gauges
    assert (gauge.title, gauge.number, gauge.unit) == ("SPEED", "97", "ft/s")
    assert gauge.target_text == "target 100 ± 5"
    assert gauge.low < gauge.marker < 0.5 < gauge.high
    (metric,) = sheet("fly", units="SI").gauges
    assert (metric.number, metric.unit, metric.target_text) == ("30", "m/s", "target 30 ± 2")


def test_without_airspeed_the_angle_of_attack_is_the_test_point() -> None:
    point = replace(NEXT.point, speed=None, alpha=0.08)
    cues = replace(BASE, speed=None, card=replace(NEXT, point=point))
    (gauge,) = display(cues).gauges
    assert (gauge.title, gauge.number) == ("ALPHA", "4.2")


def test_a_missing_value_is_a_dash_without_a_marker() -> None:
    (gauge,) = sheet("blind").gauges
    assert (gauge.number, gauge.marker) == ("–", None)
    assert gauge.target_text == "target 100 ± 5"


def test_hands_off_counts_down_and_shows_how_large_it_was() -> None:
    counts = []
    for left in (2.4, 1.6, 0.9, 0.1):
        cues = replace(BASE, input_in_progress=moving("hands-off", left))
        shown = display(cues)
        counts.append((shown.count, round(shown.ring, 2)))
    assert counts == [("3", 1.0), ("2", 0.67), ("1", 0.38), ("1", 0.04)]
    aileron, rudder = shown.gauges
    assert (aileron.title, rudder.title) == ("AILERON", "RUDDER")
    # The bar ends at one and a half times the largest that is wanted.
    places = [4 / 13.5, 6.2 / 13.5, 9 / 13.5]
    assert [aileron.low, aileron.marker, aileron.high] == pytest.approx(places)
    assert [rudder.low, rudder.marker, rudder.high] == pytest.approx([7 / 21, 4.9 / 21, 14 / 21])


def test_steering_is_not_shown_as_an_input() -> None:
    small = replace(moving("moving"), amplitudes={"da": 1.0 * DEGREE, "dr": 0.5 * DEGREE})
    go = STATES["go"]
    for cues, word in (
        (replace(go, input_in_progress=moving("moving")), "INPUT"),
        (replace(go, input_in_progress=small), "GO"),
        (replace(STATES["turn"], input_in_progress=moving("moving")), "TURN"),
        (replace(STATES["turn"], input_in_progress=moving("hands-off")), "HANDS OFF"),
        (replace(go, input_in_progress=replace(small, surfaces=("de",))), "INPUT"),
    ):
        assert display(cues).status_text == word


def test_a_verdict_says_what_to_do_next_time_and_is_put_away() -> None:
    shown = sheet("too-small")
    assert shown.hints[0].text == "rudder: 50 % larger, two thirds stick"
    # The band is that of the input, not of the card that comes next.
    assert shown.gauges[1].low is None
    aileron, rudder = sheet("too-small", target_input=WANTED).gauges
    assert aileron.low < aileron.marker < aileron.high
    assert rudder.marker < rudder.low
    assert rudder.target_text == "target 7–14"
    assert sheet("too-small", dismissed_verdict_id=VERDICT.id).status_text == "FLY"
    old = replace(STATES["too-small"], time=VERDICT.given_at + CUES.verdict_display_time + 0.1)
    assert display(old).status_text == "FLY"


def test_a_good_one_says_how_many_there_are() -> None:
    assert sheet("good").hints[0].text == "C1: 2 of 4"


def test_a_good_one_of_another_card_is_not_counted_for_the_next() -> None:
    other = replace(NEXT, card=next(card for card in CARDS.cards if card.id != VERDICT.card))
    for card in (other, None):
        (hint,) = display(replace(STATES["good"], card=card)).hints
        assert hint.text == "aileron and rudder doublet"


def test_before_the_first_samples_there_is_no_cue() -> None:
    shown = display(replace(BASE, trim=None))
    assert (shown.status_text, shown.hints[0].text) == ("NO CUE", "waiting for the first samples")


def test_a_danger_stands_in_place_of_all() -> None:
    assert (sheet("danger").status_text, sheet("danger").hints[0].text) == (
        "LAND",
        "nose sensors lost",
    )
    cues = replace(STATES["hands-off"], alerts=(danger("stall: nose down"),))
    assert display(cues).status_text == "NOSE DOWN"
    assert sheet("caution").hints[-1].text == "yaw gyro clips"
    short = replace(BASE, alerts=(danger("too high"),))
    assert display(short).status_text == "TOO HIGH"


def test_on_the_ground_nothing_is_said_of_flying() -> None:
    ground = replace(BASE, trim=cue("ground"), speed=2.0, guidance="97 ft/s slow: power")
    shown = display(ground)
    assert (shown.status_text, shown.hints) == ("ON THE GROUND", ())


def test_nothing_old_stands_once_no_samples_come() -> None:
    shown = sheet("go", seconds_without_data=2.4)
    assert shown.status_text == "NO DATA"
    assert "2.4 s" in shown.hints[0].text
    assert shown.gauges[0].number == "–"
    assert shown.leg_time_text == "–"


def test_seconds_of_leg_are_rounded_down_and_marked_when_short() -> None:
    assert (sheet("fly").leg_time_text, sheet("fly").leg_short) == ("7", False)
    cues = replace(BASE, trim=replace(cue("go"), leg_time_left=3.9))
    shown = display(cues)
    assert (shown.leg_time_text, shown.leg_short) == ("3", True)
    unknown = replace(BASE, trim=replace(cue("go"), leg_time_left=None))
    assert display(unknown).leg_time_text == "–"


def test_the_next_card_says_what_it_brings_and_what_time_there_is() -> None:
    card = sheet("fly").card
    assert "NEXT C1" in card.heading
    assert card.text == NEXT.text
    assert card.benefit_text.endswith("Cnr from 35 % to 15 %")
    assert (card.time_left_text, card.maneuvers_left_text) == ("04:10 left", "6 maneuvers")
    refused = replace(BASE, card=replace(NEXT, point=None, problem="flies level at 4.2 deg"))
    shown = display(refused).card
    assert (shown.benefit_text, shown.problem) == ("flies level at 4.2 deg", True)
    done = replace(BASE, card=None, outlook=replace(OUTLOOK, time_left=None))
    assert "land" in display(done).card.text
    none = replace(BASE, card=None, requested_repeats=0)
    assert "no test cards" in display(none).card.text


def test_the_small_line_says_what_cannot_be_judged() -> None:
    assert sheet("fly").footer.startswith("Not evaluated")


def test_without_a_flight_or_cues_the_page_says_so() -> None:
    assert build_cue_display(CueDisplayInput()).status_text == "NO FLIGHT"
    assert build_cue_display(CueDisplayInput(is_flight_open=True)).status_text == "NO CUE"


# Calm


class Clock:
    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


@settings(max_examples=60, deadline=None)
@given(
    st.lists(
        st.tuples(st.floats(0.01, 0.3), st.floats(90.0, 110.0), st.sampled_from(["fly", "go"])),
        min_size=2,
        max_size=60,
    )
)
def test_words_change_at_most_twice_a_second_and_states_at_once(
    steps: list[tuple[float, float, str]],
) -> None:
    clock = Clock()
    calm = DisplayRateLimiter(clock)
    shown: CueDisplay | None = None
    changed = -1.0
    for wait, speed, state in steps:
        clock.now += wait
        cues = replace(STATES[state], speed=speed * FOOT)
        made = display(cues)
        before, shown = shown, calm.limit(made)
        assert shown.status_text == made.status_text
        # The marker is never held back.
        assert shown.gauges[0].marker == made.gauges[0].marker
        if before is not None and shown.gauges[0].number != before.gauges[0].number:
            assert (
                clock.now - changed >= DISPLAY.min_text_time
                or shown.status_text != before.status_text
            )
        if before is None or (shown.gauges[0].number, shown.status_text) != (
            before.gauges[0].number,
            before.status_text,
        ):
            changed = clock.now


def test_what_is_held_back_comes_as_soon_as_it_may() -> None:
    """A number that changed is shown half a second after the last, one after a rest at once."""
    clock = Clock()
    calm = DisplayRateLimiter(clock)

    def number(wait: float, speed: float) -> str:
        clock.now += wait
        made = display(replace(BASE, speed=speed * FOOT))
        return calm.limit(made).gauges[0].number

    told = [number(wait, speed) for wait, speed in (
        (0.0, 97.0), (0.3, 98.0), (0.2, 98.0), (0.4, 99.0), (0.1, 99.0), (0.6, 99.0), (0.1, 100.0),
    )]  # fmt: skip
    assert told == ["97", "97", "98", "98", "99", "99", "100"]
    calm.reset()
    assert number(0.01, 80.0) == "80"


# Cards


def test_cards_are_gone_through_around_the_end_and_one_is_taken() -> None:
    choosing = CardBrowser()
    ids = [card.id for card in CARDS.cards]
    here = ids.index(CARD.id)
    assert choosing.selected_card_id(BASE) == CARD.id
    seen = []
    for _ in ids:
        choosing.step(CARDS, BASE, 1)
        card = choosing.browsed_card(CARDS)
        seen.append(card.id if card is not None else CARD.id)
    assert seen == [*ids[here + 1 :], *ids[: here + 1]]
    choosing.step(CARDS, BASE, -1)
    assert choosing.selected_card_id(BASE) == ids[here - 1]
    choosing.reset()
    assert choosing.browsed_card(CARDS) is None
    assert find_last_flown_card(STATES["too-small"], CARDS) == "C1"
    assert find_last_flown_card(BASE, CARDS) == ""


def test_a_card_that_is_looked_at_is_told_from_that_to_be_flown() -> None:
    browsed = next(card for card in CARDS.cards if card.id != "C1")
    card = display(BASE, browsed_card=browsed).card
    assert card.heading == f"SHOWING {browsed.id} · Enter flies it"
    assert card.text == browsed.display_title


def test_the_page_is_made_without_qt() -> None:
    code = (
        "import sys, ui.pilot.page_state; sys.exit(any('PySide6' in name for name in sys.modules))"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_go_without_air_data_leaves_the_speed_to_the_eye() -> None:
    blind = replace(STATES["go"], speed=None, alpha=None)
    told = display(blind)
    assert told.status_text == "GO"
    assert "judge by eye" in told.hints[-1].text
    seen = display(STATES["go"])
    assert len(seen.hints) == 1


def test_go_for_a_surface_that_nobody_sees_says_that_no_verdict_follows() -> None:
    go = STATES["go"]
    told = display(replace(go, unmeasured_surfaces=("da",)))
    assert told.status_text == "GO"
    assert "no verdict" in told.hints[1].text
    assert len(display(replace(go, unmeasured_surfaces=("de",))).hints) == 1
