"""What is heard, when, and what is forgotten: the rule of the speech queue, without Qt."""

import subprocess
import sys
from collections.abc import Iterator

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ui.display_limits import DISPLAY
from ui.voice.speech_queue import SpeechQueue, UtterancePriority

NOTE, PROMPT, WARNING = UtterancePriority.NOTE, UtterancePriority.PROMPT, UtterancePriority.WARNING


class Clock:
    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def queue(clock: Clock) -> SpeechQueue:
    return SpeechQueue(clock)


def heard(queue: SpeechQueue) -> Iterator[str]:
    while queue.speaking is not None:
        yield queue.speaking.text
        queue.finished(queue.speaking)


def words(queue: SpeechQueue) -> tuple[str | None, str | None]:
    return tuple(  # type: ignore[return-value]
        None if each is None else each.text for each in (queue.speaking, queue.waiting)
    )


@pytest.mark.parametrize(
    ("offered", "said"),
    [
        ([(f"point {number}", PROMPT) for number in range(10)], ["point 0", "point 9"]),
        ([("plus ten", PROMPT), ("link lost", WARNING)], ["link lost", "plus ten"]),
        (
            [("plus ten", PROMPT), ("plus fifteen", PROMPT), ("link lost", WARNING)],
            ["link lost", "plus fifteen"],
        ),
        (
            [("plus ten", PROMPT), ("hold still", PROMPT), ("four points left", NOTE)],
            ["plus ten", "hold still"],
        ),
        (
            [("plus ten", PROMPT), ("four points left", NOTE), ("hold still", PROMPT)],
            ["plus ten", "hold still"],
        ),
        (
            [("link lost", WARNING), ("plus ten", PROMPT), ("disk full", WARNING)],
            ["link lost", "disk full"],
        ),
        ([("  ", WARNING)], []),
    ],
    ids=[
        "never more than one behind", "a warning cuts in, the prompt is said again",
        "newer than what was cut off", "the lesser gives way to what waits",
        "a prompt in place of a note", "a second warning before a prompt", "nothing",
    ],
)  # fmt: skip
def test_the_more_urgent_and_then_the_newer_is_heard(
    queue: SpeechQueue, offered: list[tuple[str, UtterancePriority]], said: list[str]
) -> None:
    for text, priority in offered:
        queue.enqueue(text, priority)
    assert list(heard(queue)) == said


def test_no_repeats_until_time_or_other_words_are_between(queue: SpeechQueue, clock: Clock) -> None:
    queue.enqueue("hold still", PROMPT)
    queue.enqueue("hold still", PROMPT)
    assert list(heard(queue)) == ["hold still"]
    clock.now += DISPLAY.repeat_interval - 0.1
    queue.enqueue("hold still", PROMPT)
    assert list(heard(queue)) == []
    clock.now += 0.2
    queue.enqueue("hold still", PROMPT)
    assert list(heard(queue)) == ["hold still"]
    queue.enqueue("taken", PROMPT)
    queue.enqueue("hold still", PROMPT)
    assert list(heard(queue)) == ["taken", "hold still"]


def test_words_are_apart_from_the_end_of_what_was_said(queue: SpeechQueue, clock: Clock) -> None:
    queue.enqueue("hold still", PROMPT)
    clock.now += 2.0 * DISPLAY.repeat_interval
    assert list(heard(queue)) == ["hold still"]
    clock.now += DISPLAY.repeat_interval - 0.1
    queue.enqueue("hold still", PROMPT)
    assert list(heard(queue)) == []


def test_a_warning_that_waits_as_a_hush_begins_is_heard_after_it(queue: SpeechQueue) -> None:
    queue.enqueue("link lost", WARNING)
    queue.enqueue("disk full", WARNING)
    queue.set_quiet(True)
    assert list(heard(queue)) == ["link lost"]
    queue.set_quiet(False)
    assert list(heard(queue)) == ["disk full"]


def test_mute_silences_at_once_and_nothing_old_is_heard_after(queue: SpeechQueue) -> None:
    queue.enqueue("link lost", WARNING)
    queue.enqueue("plus ten", PROMPT)
    queue.set_muted(True)
    assert words(queue) == (None, None)
    queue.enqueue("disk full", WARNING)
    queue.set_muted(False)
    assert words(queue) == (None, None)
    queue.enqueue("link lost", WARNING)  # still so: said again although it was said just now
    assert words(queue) == ("link lost", None)


def test_the_late_end_of_what_was_cut_off_changes_nothing(queue: SpeechQueue) -> None:
    queue.enqueue("plus ten", PROMPT)
    cut_off = queue.speaking
    queue.enqueue("link lost", WARNING)
    assert cut_off is not None
    queue.finished(cut_off)
    assert words(queue) == ("link lost", "plus ten")


def test_a_hush_cuts_off_all_but_warnings_and_forgets_the_rest(queue: SpeechQueue) -> None:
    queue.enqueue("left wing low", PROMPT)
    queue.enqueue("three feet slow", PROMPT)
    queue.set_quiet(True)
    assert words(queue) == (None, None)
    queue.enqueue("plus ten", PROMPT)
    queue.enqueue("hands off", PROMPT, through=True)
    assert words(queue) == ("hands off", None)
    queue.finished(queue.speaking)
    queue.set_quiet(False)
    assert words(queue) == (None, None)


def test_a_warning_waits_for_the_end_of_a_hush_unless_it_belongs_to_it(queue: SpeechQueue) -> None:
    queue.set_quiet(True)
    queue.enqueue("battery low", WARNING)
    assert words(queue) == (None, "battery low")
    queue.enqueue("stall, nose down", WARNING, through=True)
    queue.finished(queue.speaking)
    assert words(queue) == (None, "battery low")
    queue.set_quiet(False)
    assert words(queue) == ("battery low", None)


OFFERS = st.tuples(st.sampled_from("abcd"), st.sampled_from(list(UtterancePriority)))


@settings(max_examples=80, deadline=None)
@given(st.lists(st.one_of(OFFERS, st.just("end"), st.just("mute"), st.just("unmute"))))
def test_whatever_happens_the_rule_holds(steps: list[object]) -> None:
    queue = SpeechQueue(Clock())
    for step in steps:
        before = queue.speaking
        if step == "end":
            if before is not None:
                queue.finished(before)
        elif step in ("mute", "unmute"):
            queue.set_muted(step == "mute")
        else:
            offered, priority = step  # type: ignore[misc]
            queue.enqueue(offered, priority)
            if priority is WARNING and not queue.is_muted and before is not None:
                # Nothing lesser is spoken into a warning, nor goes on when one came.
                assert queue.speaking is before or queue.speaking.text == offered
                if before.priority < WARNING and before.text != offered:
                    waited = queue.waiting
                    assert queue.speaking.priority is WARNING or (
                        waited is not None and waited.text == offered
                    )
        if queue.waiting is not None:
            assert queue.waiting.priority <= queue.speaking.priority
            assert queue.waiting.text != queue.speaking.text


@settings(max_examples=80, deadline=None)
@given(
    st.lists(
        st.one_of(
            st.tuples(
                st.sampled_from("abcd"), st.sampled_from(list(UtterancePriority)), st.booleans()
            ),
            st.sampled_from(["end", "hush", "over"]),
        )
    )
)
def test_whatever_happens_a_hush_is_kept(steps: list[object]) -> None:
    queue = SpeechQueue(Clock())
    for step in steps:
        before = queue.speaking
        if step == "end":
            if before is not None:
                queue.finished(before)
        elif step in ("hush", "over"):
            queue.set_quiet(step == "hush")
        else:
            offered, priority, through = step  # type: ignore[misc]
            queue.enqueue(offered, priority, through=through)
        if queue.is_quiet and queue.speaking is not None and queue.speaking is not before:
            assert queue.speaking.allowed_in_quiet
        if not queue.is_quiet and queue.waiting is not None:
            assert queue.speaking is not None


def test_the_rule_and_the_tones_know_nothing_of_qt() -> None:
    code = (
        "import sys, ui.voice.speech_queue, ui.voice.tones; "
        "sys.exit(any('PySide6' in name for name in sys.modules))"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
