"""What is said aloud: in order, short, not twice, and never into a hands-off interval."""

from collections.abc import Sequence
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gsapp.excitation.alerts.alert import Alert, AlertLevel
from gsapp.excitation.announcer import Announcement, Announcer, spell_out_units
from gsapp.excitation.cues import CueEvent, EventKind
from gsapp.excitation.trim.trim_cue import TrimCue, TrimDeviation, TrimState


def trim(
    time: float, state: TrimState, speed: float = 0.0, quantity: str = "speed", share: float = 2.0
) -> TrimCue:
    off = TrimDeviation(quantity=quantity, amount=speed, tolerance_ratio=share, channel="V")
    return TrimCue(time=time, state=state, since=time, deviations=(off,) if state == "fly" else ())


def event(time: float, kind: EventKind, state: str, text: str = "", **data: object) -> CueEvent:
    return CueEvent(time=time, kind=kind, state=state, text=text, data=data)


def danger(key: str, spoken: str, urgency: AlertLevel = AlertLevel.WARNING) -> Alert:
    return Alert(key=key, level=urgency, since=0.0, text=f"{spoken}, at once", spoken_text=spoken)


def arose(time: float, one: Alert) -> CueEvent:
    state = "warning" if one.level is AlertLevel.WARNING else "caution"
    return event(time, "danger", state, one.spoken_text, key=one.key)


def words(said: Sequence[Announcement]) -> list[str]:
    return [one.text for one in said if one.text]


def nag(announcer: Announcer, start: float, stop: float, cue: TrimCue) -> list[float]:
    ticks = range(round(20 * start), round(20 * stop))
    return [k / 20 for k in ticks if words(announcer.update(k / 20, (), cue))]


def test_go_is_a_tone_and_one_word_and_its_loss_says_why() -> None:
    """Said once for each GO, not again while it stands."""
    voice = Announcer()
    assert words(voice.update(0.0, (), trim(0.0, "hold"))) == []
    (go,) = voice.update(1.0, (), trim(1.0, "go"))
    assert (go.text, go.priority, go.tone) == ("go", "prompt", "taken")
    assert voice.update(1.05, (), trim(1.0, "go")) == ()
    (lost,) = voice.update(2.0, (), trim(2.0, "fly", -0.91))
    assert (lost.text, lost.tone) == ("3 feet a second slow", "moved")
    voice.update(3.0, (), trim(3.0, "go"))
    (held,) = voice.update(4.0, (), trim(4.0, "hold"))
    assert (held.text, held.tone) == ("hold", "moved")


def test_the_same_is_repeated_ever_more_rarely_and_news_at_once() -> None:
    voice = Announcer()
    assert nag(voice, 0.0, 60.0, trim(0.0, "fly", -0.91)) == [0.0, 5.0, 15.0, 35.0]
    assert nag(voice, 60.0, 62.0, trim(0.0, "fly", -1.83)) == [60.0]
    assert nag(voice, 62.0, 63.0, trim(0.0, "fly", 0.1, "bank")) == [62.0]
    # Back within its old size it is no news: it waits for its turn.
    assert nag(voice, 63.0, 68.0, trim(0.0, "fly", 0.1, "bank")) == [67.0]


def test_two_things_that_take_turns_do_not_chatter() -> None:
    voice = Announcer()
    said = []
    for k in range(200):
        cue = trim(0.0, "fly", 1.0, "speed" if k % 4 < 2 else "climb")
        said += [k / 20] * len(words(voice.update(k / 20, (), cue)))
    gaps = [after - before for before, after in pairwise(said)]
    assert min(gaps) >= 1.5


def test_a_pilot_on_his_way_is_not_nagged() -> None:
    voice = Announcer()
    far = trim(0.0, "fly", -10.0, share=6.0)
    assert nag(voice, 0.0, 60.0, far) == []
    voice.update(61.0, (), trim(61.0, "go"))
    assert words(voice.update(62.0, (), far)) == ["33 feet a second slow"]


def test_who_rolls_out_of_a_turn_is_left_alone() -> None:
    voice = Announcer()
    voice.update(0.0, (), trim(0.0, "turn"))
    assert nag(voice, 1.0, 5.0, trim(0.0, "fly", 0.1, "bank")) == [3.0]


def test_a_hands_off_interval_is_silent_from_the_first_move_to_the_verdict() -> None:
    """Trim, cautions and cards wait; the verdict comes first, then what still stands."""
    voice = Announcer()
    slow = trim(0.0, "fly", -0.91)
    weak = danger("battery", "battery low", AlertLevel.CAUTION)
    gone = danger("clip.q", "pitch gyro clips", AlertLevel.CAUTION)
    voice.update(9.0, (), trim(9.0, "go"))
    assert voice.update(10.0, (), slow, moving=True) == ()
    begins = event(11.0, "hands-off", "begins", "hands off")
    assert words(voice.update(11.0, [begins], slow)) == ["hands off"]
    card = event(11.5, "card", "next", "elevator doublet at 85 ft/s")
    (tone,) = voice.update(12.0, [arose(12.0, weak), card], slow, [weak])
    assert (tone.text, tone.tone) == ("", "caution")
    (tone,) = voice.update(12.5, [arose(12.5, gone)], slow, [weak, gone])
    assert tone.text == ""
    over = event(13.0, "danger", "over", key="clip.q")
    assert voice.update(13.0, [over], slow, [weak]) == ()
    ends = event(15.0, "hands-off", "ends")
    assert words(voice.update(15.0, [ends], slow, [weak])) == []
    verdict = event(15.5, "verdict", "too-small", "rudder doublet too small: 50 % larger")
    heard = words(voice.update(15.5, [verdict], slow, [weak]))
    assert heard == ["rudder doublet too small: 50 percent larger", "battery low"]
    later = []
    for k in range(310, 500):
        later += words(voice.update(k / 20, (), slow, [weak]))
    assert "pitch gyro clips" not in later
    assert later[0] == "elevator doublet at 85 feet a second"
    assert "3 feet a second slow" in later


def test_go_is_said_anew_after_each_input() -> None:
    voice = Announcer()
    heard: list[tuple[float, str]] = []
    happens = {
        2.0: event(2.0, "hands-off", "begins"),
        4.0: event(4.0, "hands-off", "ends"),
        4.5: event(4.5, "verdict", "good", "good"),
    }
    for k in range(200):
        now = k / 20
        events = [happens[now]] if now in happens else []
        said = voice.update(now, events, trim(0.0, "go"), moving=1.5 <= now < 2.0)
        heard += [(now, each) for each in words(said)]
    assert [each for _, each in heard] == ["go", "hands off", "good", "go"]
    assert heard[0][0] == 0.0
    assert 4.5 < heard[3][0] < 9.0


def test_only_what_calls_for_the_ground_breaks_the_silence() -> None:
    voice = Announcer()
    stall, fence = danger("stall", "stall: nose down"), danger("fence", "fence ahead: turn")
    voice.update(0.0, [event(0.0, "hands-off", "begins")], None)
    (spoken,) = voice.update(1.0, [arose(1.0, stall)], None, [stall])
    assert (spoken.text, spoken.priority) == ("stall: nose down", "warning")
    (tone,) = voice.update(1.5, [arose(1.5, fence)], None, [stall, fence])
    assert (tone.text, tone.tone, tone.priority) == ("", "warning", "warning")
    verdict = event(3.0, "verdict", "good", "good")
    said = voice.update(3.0, [verdict], None, [fence])
    assert [(one.text, one.priority) for one in said] == [
        ("fence ahead: turn", "warning"), ("good", "prompt"),
    ]  # fmt: skip


def test_an_input_without_a_verdict_does_not_silence_the_rest_of_the_flight() -> None:
    voice = Announcer()
    voice.update(0.0, [event(0.0, "hands-off", "begins")], None)
    voice.update(1.0, [event(1.0, "hands-off", "broken")], None)
    assert nag(voice, 1.0, 4.0, trim(0.0, "fly", -0.91)) == [2.5]


_EVENTS = st.sampled_from(
    [
        ("hands-off", "begins"), ("hands-off", "ends"), ("verdict", "good"), ("danger", "warning"),
        ("danger", "caution"), ("card", "next"), ("trim", "fly"), ("none", ""),
    ]
)  # fmt: skip


@given(
    story=st.lists(_EVENTS, max_size=40),
    states=st.lists(st.sampled_from(["go", "hold", "fly", "gusty", "turn"]), min_size=40),
)
def test_whatever_happens_it_is_said_in_order_and_not_into_the_silence(
    story: list[tuple[EventKind, str]], states: list[TrimState]
) -> None:
    voice = Announcer()
    silent = False
    for k, (kind, state) in enumerate(story):
        happened = []
        if (kind, state) == ("hands-off", "begins"):
            happened.append(event(k, "hands-off", "begins", "hands off"))
            silent = True
        elif kind != "none":
            happened.append(event(k, kind, state, f"{kind} {k}", key=f"{k}"))
        said = voice.update(float(k), happened, trim(float(k), states[k], -0.91))
        ranks = [("warning", "prompt", "note").index(one.priority) for one in said]
        assert ranks == sorted(ranks)
        if kind == "verdict" or (kind, state) == ("hands-off", "ends"):
            silent = False
        if silent:
            assert words(said) in ([], ["hands off"])
        assert len(words(said)) <= 3


@pytest.mark.parametrize(
    ("written", "heard"),
    [
        ("3 ft/s slow", "3 feet a second slow"),
        ("left wing low 6 deg", "left wing low 6 degrees"),
        ("hold longer: 0.4 s each way", "hold longer: 0.4 seconds each way"),
        ("throttle back, then 40 %", "throttle back, then 40 percent"),
        ("at 100 ft/s, half stick", "at 100 feet a second, half stick"),
        ("climbing -2 m/s", "climbing -2 meters a second"),
        ("good", "good"),
        ("go s m deg", "go s m deg"),
    ],
)
def test_units_are_spoken_in_full_behind_numbers_only(written: str, heard: str) -> None:
    assert spell_out_units(written) == heard
