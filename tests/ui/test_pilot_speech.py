"""What is heard in flight: order, mute, and nothing into the answer of the aircraft."""

from dataclasses import replace

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from PySide6.QtWidgets import QApplication

from gsapp.excitation.announcer import Announcement
from tests.ui.pilot_kit import BASE, moving
from tests.ui.window_kit import Loudspeaker, Mouth
from ui.display_limits import DISPLAY
from ui.pilot.pilot_page import FlightSpeech
from ui.voice.speech_queue import UtterancePriority
from ui.voice.voice import Voice


class Flight:
    """A flight that says things, and what is heard of it."""

    def __init__(self) -> None:
        self.mouth, self.loudspeaker = Mouth(), Loudspeaker()
        self.voice = Voice(player=self.loudspeaker, speaker=self.mouth)
        self.speech = FlightSpeech(self.voice)
        self.said: list[Announcement] = []
        self.time = 100.0

    def hear(self, *, hands_off: bool = False, aloud: bool = True) -> None:
        under_way = moving("hands-off") if hands_off else None
        cues = replace(BASE, time=self.time, input_in_progress=under_way)
        self.speech.speak_new_cues(cues, self.said, aloud=aloud)

    def say(self, text: str, priority: str = "prompt", tone: str = "", ago: float = 0.0) -> None:
        self.said.append(
            Announcement(time=self.time - ago, text=text, priority=priority, tone=tone)  # type: ignore[arg-type]
        )


@pytest.fixture
def flight(qapp: QApplication) -> Flight:
    return Flight()


def test_what_is_new_is_said_once_with_its_tone(flight: Flight) -> None:
    flight.say("go", tone="taken")
    flight.hear()
    flight.hear()
    assert flight.mouth.spoken == ["go"]
    assert flight.loudspeaker.tones == ["taken"]


def test_warnings_come_before_prompts_and_these_before_notes(flight: Flight) -> None:
    flight.say("three feet a second slow")
    flight.hear()
    flight.say("next: rudder doublet", "note")
    flight.say("left wing low")
    flight.say("stall: nose down", "warning", "warning")
    flight.hear()
    flight.mouth.end()
    assert flight.mouth.spoken == ["three feet a second slow", "stall: nose down", "left wing low"]


def test_nothing_is_spoken_into_the_hands_off_interval(flight: Flight) -> None:
    flight.say("three feet a second slow")
    flight.say("left wing low")
    flight.hear()
    flight.say("hands off", tone="steady")
    flight.hear(hands_off=True)
    assert flight.mouth.now.text == "hands off"
    flight.mouth.end()
    flight.voice.say("battery low", UtterancePriority.WARNING)
    flight.voice.say("point taken")
    flight.hear(hands_off=True)
    assert flight.mouth.now is None
    flight.hear()
    assert flight.mouth.spoken[2:] == ["battery low"]


def test_what_was_begun_goes_on_while_the_input_is_made(flight: Flight) -> None:
    flight.say("three feet a second slow")
    flight.hear()
    cues = replace(BASE, time=flight.time, input_in_progress=moving("moving"))
    flight.speech.speak_new_cues(cues, flight.said, aloud=True)
    assert flight.mouth.now is not None
    flight.hear(hands_off=True)
    assert flight.mouth.now is None


def test_a_danger_that_the_pilot_must_act_on_is_spoken_even_there(flight: Flight) -> None:
    flight.hear(hands_off=True)
    flight.say("stall: nose down", "warning", "warning")
    flight.hear(hands_off=True)
    assert flight.mouth.spoken == ["stall: nose down"]


def test_what_was_true_a_while_ago_is_not_said(flight: Flight) -> None:
    flight.say("go", ago=DISPLAY.max_speech_delay + 0.1)
    flight.say("hold", ago=DISPLAY.max_speech_delay - 0.1)
    flight.hear()
    assert flight.mouth.spoken == ["hold"]
    flight.speech.restart(flight.said)
    flight.hear()
    assert flight.mouth.spoken == ["hold"]


def test_mute_is_one_for_words_and_tones(flight: Flight) -> None:
    flight.say("three feet a second slow", tone="note")
    flight.hear()
    flight.voice.set_muted(True)
    assert flight.mouth.now is None
    flight.say("go", tone="taken")
    flight.hear()
    flight.voice.set_muted(False)
    flight.hear()
    assert flight.mouth.spoken == ["three feet a second slow"]
    assert flight.loudspeaker.tones == ["note", "stop"]


def test_a_replay_that_goes_back_says_it_again(flight: Flight) -> None:
    flight.say("go")
    flight.hear()
    flight.mouth.end()
    flight.said.clear()
    flight.hear()
    flight.say("left wing low")
    flight.hear()
    assert flight.mouth.spoken == ["go", "left wing low"]


STEPS = st.lists(
    st.one_of(
        st.tuples(
            st.sampled_from(["slow", "fast", "left wing low", "go", "stall: nose down"]),
            st.sampled_from(["note", "prompt", "warning"]),
        ),
        st.sampled_from(["end", "begins", "over"]),
    ),
    max_size=40,
)


@settings(
    max_examples=50, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(steps=STEPS)
def test_never_more_than_one_sentence_behind(qapp: QApplication, steps: list[object]) -> None:
    flight = Flight()
    hands_off = False
    for step in steps:
        if step == "end":
            flight.mouth.end()
        elif step in ("begins", "over"):
            hands_off = step == "begins"
        else:
            text, priority = step  # type: ignore[misc]
            flight.say(text, priority)
        flight.hear(hands_off=hands_off)
    heard = len(flight.mouth.spoken)
    flight.hear()
    flight.mouth.end()
    flight.mouth.end()
    flight.mouth.end()
    assert len(flight.mouth.spoken) <= heard + 2
    assert flight.mouth.now is None
