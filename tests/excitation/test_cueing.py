"""The cues of a whole flight: the same however it comes in, and said in the right order."""

import itertools
import json
import random

import numpy as np
import pytest

from gsapp.excitation.cueing import CueGenerator
from gsapp.excitation.cues import CueSnapshot
from gsapp.excitation.debrief import create_debrief
from gsapp.excitation.settings import INFORMATION
from gsapp.flight.cards import CardSet
from gsapp.foundation import UnknownNameError
from gsapp.quantities import Block
from tests.excitation.cue_kit import AIRCRAFT, CARDS, card, cueing, feed, flown, part

_TWO_PLACES = CardSet(cards=(card("E1"), card("E2", speed=85.0), card("R1", surface="dr")))


def told(cues: CueGenerator) -> tuple[object, ...]:
    return (
        json.dumps([event.to_json() for event in cues.log], sort_keys=True),
        tuple(cues.announcements),
        tuple(json.dumps(one.to_record(), sort_keys=True) for one in cues.maneuvers),
        cues.verdicts,
        cues.card_progress,
    )


def kinds(cues: CueGenerator) -> list[tuple[str, str]]:
    return [(event.kind, event.state) for event in cues.log]


@pytest.fixture(scope="module")
def whole() -> CueGenerator:
    return feed(cueing(), flown())


def test_an_input_in_trim_is_cued_from_go_to_verdict(whole: CueGenerator) -> None:
    events = whole.log
    assert [event.time for event in events] == sorted(event.time for event in events)
    found = kinds(whole)
    order = [("trim", "go"), ("input", "made"), ("hands-off", "ends"), ("verdict", "good")]
    places = [found.index(one) for one in order]
    assert places == sorted(places)
    made, over, verdict = (events[found.index(one)] for one in order[1:])
    assert verdict.data["card"] == "E1"
    assert verdict.data["counts"]
    assert made.time - made.data["t_input"] < 2.0
    assert verdict.time - over.time < 1.0
    snapshot = whole.snapshot()
    assert (snapshot.good_repeats, snapshot.requested_repeats) == (1, 2)
    assert snapshot.card.good_repeats == 1
    assert snapshot.speed == pytest.approx(30.5, abs=4.0)


def test_nothing_is_spoken_from_the_input_to_its_verdict(whole: CueGenerator) -> None:
    made = next(event for event in whole.log if event.kind == "input")
    verdict = next(event for event in whole.log if event.kind == "verdict")
    text = [
        one.text
        for one in whole.announcements
        if made.data["t_input"] < one.time < verdict.time and one.text
    ]
    assert text == ["hands off"]
    after = [one for one in whole.announcements if one.time == verdict.time and one.text]
    assert [one.text for one in after] == ["good"]


def test_what_is_told_does_not_depend_on_how_the_samples_come(whole: CueGenerator) -> None:
    block = flown()
    draw = random.Random(len(block))
    edges = sorted({0, *draw.sample(range(1, len(block)), 150), len(block)})
    slow = ("north", "east", "height", "battery", "throttle", "static_pressure", "temperature")
    quick = [name for name in block.channels if name not in slow]
    cues, late = cueing(), draw.randrange(20)
    for start, stop in itertools.pairwise(edges):
        cues.feed(part(block, start, stop, quick))
        cues.feed(part(block, max(start - late, 0), max(stop - late, 0), slow))
        cues.process_step()
        cues.snapshot()  # whoever looks changes nothing
    cues.feed(part(block, len(block) - late, len(block), slow))
    cues.finish()
    assert told(cues) == told(whole)


def test_the_look_ahead_is_done_in_slices_before_it_is_due() -> None:
    cues = cueing()
    block = flown()
    cues.feed(block)
    cues.process_step()
    given = cues.verdicts[-1].given_at
    assert not cues.has_pending_work(given)
    slices = 0
    while cues.has_pending_work(given + INFORMATION.forecast_delay):
        cues.process_step()
        slices += 1
    assert slices > 10


def test_an_instrument_that_is_not_believed_is_not_shown() -> None:
    block = part(flown(), 0, 700)
    values = np.array(block.values)
    index = block.channels.index("alpha")
    low, high = AIRCRAFT.sensors.alpha_vane.range
    values[400:, index] = high + 0.2 * (high - low)
    cues = cueing(model=None)
    cues.feed(Block(channels=block.channels, times=block.times, values=values))
    cues.process_step()
    snapshot = cues.snapshot()
    assert snapshot.alpha is None
    assert snapshot.speed is not None
    assert any(text.startswith("ignored: ") for text in snapshot.limitations)


@pytest.mark.parametrize(
    ("lost", "state", "said"),
    [
        (("p", "q", "r"), "blind", "roll rate: not measured"),
        (("de", "elevator_left", "elevator_right"), "go", "inputs of elevator: the surface"),
        (("dynamic_pressure", "alpha"), "go", "speed: no airspeed"),
    ],
)
def test_what_is_not_measured_is_said_before_anybody_relies_on_it(
    lost: tuple[str, ...], state: str, said: str
) -> None:
    block = part(flown(), 0, 700)
    cues = cueing(model=None)
    cues.feed(block.select([name for name in block.channels if name not in lost]))
    cues.process_step()
    snapshot = cues.snapshot()
    assert snapshot.trim.state == state
    assert any(text.startswith(said) for text in snapshot.limitations)


def test_other_units_hold_for_cards_and_prospects_from_then_on() -> None:
    """A card in feet is one in meters at once, paused or not, and so is what it would bring."""
    cues = cueing()
    cues.feed(part(flown(), 0, 700))
    cues.process_step()
    before = cues.snapshot()
    assert "100 ft/s" in before.card.text
    cues.use_units("SI")
    at_once = cues.snapshot().card
    assert "30 m/s" in at_once.text
    cues.feed(part(flown(), 700, len(flown())))
    cues.process_step()
    after = cues.snapshot()
    assert all("m/s" in one.text for one in after.outlook.forecasts)
    assert after.outlook.forecasts


def test_a_replay_that_goes_back_tells_the_same_again(whole: CueGenerator) -> None:
    block = flown()
    cues = cueing()
    cues.feed(part(block, 0, 1150))
    cues.process_step()
    assert cues.snapshot().input_in_progress is not None
    cues.reset()
    assert cues.snapshot() == CueSnapshot(
        card=None, limitations=cues.snapshot().limitations, good_repeats=0, requested_repeats=2
    )
    assert told(feed(cues, block)) == told(whole)


def test_a_pause_in_the_record_is_no_maneuver() -> None:
    block = flown()
    times = block.times.copy()
    times[1150:] += 30.0
    late = Block(channels=block.channels, times=times, values=block.values)
    cues = feed(cueing(model=None), late)
    assert len(cues.verdicts) == 1
    assert cues.verdicts[0].t_end < 11.6
    assert all(not 11.6 < event.time < 41.4 for event in cues.log if event.kind != "verdict")


def test_the_crew_chooses_and_a_replay_of_the_choice_tells_the_same() -> None:
    """A choice counts from its time on; what the program would have picked comes after it."""
    block = flown()
    live = cueing(cards=_TWO_PLACES, model=None)
    for start in range(0, 800, 20):
        live.feed(part(block, start, start + 20))
        live.process_step()
    before = live.snapshot().card
    assert (before.card.id, before.reason) == ("E1", "next on the list")
    at = live.select_card("E2")
    for start in range(800, len(block), 20):
        live.feed(part(block, start, min(start + 20, len(block))))
        live.process_step()
    live.finish()
    chosen = live.snapshot().card
    assert (chosen.card.id, chosen.reason) == ("E2", "chosen")
    assert "85 ft/s" in chosen.text
    replayed = cueing(cards=_TWO_PLACES, model=None)
    replayed.select_card("E2", at=at)
    assert told(feed(replayed, block)) == told(live)
    live.select_card("")
    with pytest.raises(UnknownNameError, match="no test card 'X9'"):
        live.select_card("X9")


def test_cards_that_come_later_count_what_was_flown() -> None:
    cues = feed(cueing(cards=None, model=None), flown())
    assert cues.verdicts[0].card == ""
    assert cues.card_progress is None
    cues.use_cards(CARDS)
    assert [one.good_count for one in cues.card_progress.cards] == [1]
    assert cues.snapshot().good_repeats == 1


def test_a_card_that_cannot_be_flown_is_said_and_not_picked() -> None:
    cards = CardSet(cards=(card("S1", speed=30.0), card("E1")))
    cues = cueing(cards=cards)
    cues.feed(part(flown(), 0, 700))
    cues.process_step()
    picked = cues.snapshot().card
    assert picked.card.id == "E1"
    cues.select_card("S1")
    cues.feed(part(flown(), 700, 740))
    cues.process_step()
    refused = cues.snapshot().card
    assert refused.point is None
    assert "30 ft/s" in refused.problem


def test_the_debrief_holds_what_was_wanted_how_it_began_and_the_curves(whole: CueGenerator) -> None:
    debrief = create_debrief("a", whole)
    (one,) = debrief.maneuvers
    assert debrief.score == pytest.approx(0.5)
    assert debrief.results == {"good": 1}
    assert one.go_at is not None
    assert one.target_input is not None
    assert one.point is not None
    assert abs(one.trim_deviations["speed"]) < 1.0
    assert set(one.curves.series) >= {"de", "q", "alpha", "an"}
    elevator = one.curves.series["de"]
    half = 0.5 * float(np.ptp(elevator[np.isfinite(elevator)]))
    assert half == pytest.approx(one.verdict.amplitudes["de"], rel=0.1)
    assert len(elevator) < 300
    cues = debrief.cues_json()
    assert [cue["time"] for cue in cues] == sorted(cue["time"] for cue in cues)
    assert {"trim", "verdict", "spoken", "card"} <= {cue["kind"] for cue in cues}
    json.dumps([debrief.to_json(), cues], allow_nan=False)
