"""Words and tones as the window makes them heard: real processes, real samples, one mute."""

import io
import sys
import wave
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from gsapp.session import Alarm, Severity
from tests.ui.window_kit import Loudspeaker, Mouth, until
from ui.main_window import MainWindow
from ui.voice.sound_output import (
    Beeper,
    CommandSpeaker,
    CommandTonePlayer,
    ToneSpeaker,
    WindowsTonePlayer,
    create_speaker,
    create_tone_player,
)
from ui.voice.speech_queue import UtterancePriority
from ui.voice.tones import SAMPLE_RATE, TONES, tone_samples, tone_wav
from ui.voice.voice import Voice

# A program that speaks: it writes what it reads to a file, and takes its time over "long" words.
_SPEAKING = (
    "import sys, time\n"
    "words = sys.stdin.read().strip()\n"
    "out = open(sys.argv[1], 'a')\n"
    "print('begins', words, file=out, flush=True)\n"
    "time.sleep(30 if 'long' in words else 0)\n"
    "print('ends', words, file=out, flush=True)\n"
)


@pytest.fixture
def speaking(tmp_path: Path) -> tuple[list[str], Callable[[], list[str]]]:
    out = tmp_path / "spoken.txt"
    out.touch()
    return [sys.executable, "-c", _SPEAKING, str(out)], lambda: out.read_text().splitlines()


@pytest.mark.parametrize("name", sorted(TONES))
def test_tones_are_what_their_table_says(name: str) -> None:
    """Length, no clicks at either end, no clipping, and the note of the table is the loudest."""
    samples = tone_samples(name)
    assert samples.size == pytest.approx(SAMPLE_RATE * TONES[name].duration, abs=3)
    assert abs(int(samples[0])) < 50
    assert abs(int(samples[-1])) < 50
    assert 0.2 * 32767 < np.abs(samples.astype(float)).max() < 0.75 * 32767
    frequency, seconds = TONES[name].notes[0]
    first = samples[: round(seconds * SAMPLE_RATE)].astype(float)
    loudest = np.argmax(np.abs(np.fft.rfft(first, 8 * first.size))) * SAMPLE_RATE / (8 * first.size)
    assert loudest == pytest.approx(frequency, abs=12.0)


def test_tones_that_mean_different_things_sound_different() -> None:
    assert len({TONES[name].notes for name in TONES}) == len(TONES)


def test_a_tone_is_a_sound_file_that_can_be_read() -> None:
    with wave.open(io.BytesIO(tone_wav("taken"))) as file:
        assert (file.getnchannels(), file.getsampwidth(), file.getframerate()) == (
            1,
            2,
            SAMPLE_RATE,
        )
        played = np.frombuffer(file.readframes(file.getnframes()), dtype="<i2")
    assert np.array_equal(played, tone_samples("taken"))


def test_sentences_are_spoken_in_order_by_a_program(
    qtbot: QtBot, speaking: tuple[list[str], Callable[[], list[str]]]
) -> None:
    command, spoken = speaking
    voice = Voice(player=Loudspeaker(), speaker=CommandSpeaker(command))
    voice.say("plus ten")
    voice.say("four points left", UtterancePriority.NOTE)
    voice.say("hold still")
    until(qtbot, lambda: "ends hold still" in spoken())
    assert spoken() == ["begins plus ten", "ends plus ten", "begins hold still", "ends hold still"]


@pytest.mark.parametrize("how", ["mute", "warning"])
def test_what_is_spoken_is_cut_off_at_once(
    qtbot: QtBot, speaking: tuple[list[str], Callable[[], list[str]]], how: str
) -> None:
    """The program is killed: its 30 s of words never end."""
    command, spoken = speaking
    speaker = CommandSpeaker(command)
    voice = Voice(player=Loudspeaker(), speaker=speaker)
    voice.say("a long story")
    until(qtbot, lambda: bool(spoken()))
    process = speaker._running
    with qtbot.waitSignal(process.finished, timeout=5000):
        if how == "mute":
            voice.set_muted(True)
        else:
            voice.say("link lost", UtterancePriority.WARNING)
    if how == "mute":
        assert spoken() == ["begins a long story"]
    else:
        until(qtbot, lambda: "ends link lost" in spoken())
        voice.set_muted(True)  # ends the story, which waits


@pytest.mark.parametrize("command", [["/nowhere/speaks"], [sys.executable, "-c", "exit(3)"]])
def test_a_voice_that_fails_gives_way_to_tones(qtbot: QtBot, command: list[str]) -> None:
    loud = Loudspeaker()
    voice = Voice(player=loud, speaker=CommandSpeaker(command))
    voice.say("plus ten")
    until(qtbot, lambda: loud.tones == ["prompt"])
    voice.say("link lost", UtterancePriority.WARNING)
    until(qtbot, lambda: "warning" in loud.tones)


def test_without_a_voice_tones_say_how_urgent_it_is_and_none_comes_twice(qtbot: QtBot) -> None:
    loud = Loudspeaker()
    voice = Voice(player=loud)
    voice._set_speaker(ToneSpeaker(voice._sound, voice))
    voice.play_tone("warning")
    voice.say("link lost", UtterancePriority.WARNING)
    assert loud.tones == ["warning"]
    voice.say("plus ten")
    until(qtbot, lambda: loud.tones == ["warning", "prompt"])


def test_a_tone_is_not_heard_into_a_more_urgent_sentence() -> None:
    loud, mouth = Loudspeaker(), Mouth()
    voice = Voice(player=loud, speaker=mouth)
    voice.say("link lost", UtterancePriority.WARNING)
    voice.play_tone("taken")
    assert loud.tones == []
    mouth.end()
    voice.play_tone("taken")
    assert loud.tones == ["taken"]


def test_muted_means_neither_words_nor_tones() -> None:
    loud, mouth = Loudspeaker(), Mouth()
    voice = Voice(player=loud, speaker=mouth, muted=True)
    voice.say("link lost", UtterancePriority.WARNING)
    voice.play_tone("warning")
    assert (loud.tones, mouth.spoken) == ([], [])


def test_a_player_that_cannot_play_beeps(qtbot: QtBot, monkeypatch: pytest.MonkeyPatch) -> None:
    beeps: list[int] = []
    monkeypatch.setattr(QApplication, "beep", lambda: beeps.append(1))
    player = CommandTonePlayer([sys.executable, "-c", "exit(1)"])
    player.play("taken")
    until(qtbot, lambda: beeps == [1])


def test_a_tone_reaches_the_program_that_plays_it(qtbot: QtBot, tmp_path: Path) -> None:
    copy = f"import sys, shutil; shutil.copy(sys.argv[1], {str(tmp_path / 'played.wav')!r})"
    player = CommandTonePlayer([sys.executable, "-c", copy])
    player.play("steady")
    until(qtbot, lambda: (tmp_path / "played.wav").exists() and player._running is None)
    assert (tmp_path / "played.wav").read_bytes() == tone_wav("steady")


def test_a_computer_without_any_sound_still_works(
    qtbot: QtBot, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("PySide6.QtMultimedia", "PySide6.QtTextToSpeech", "winsound"):
        monkeypatch.setitem(sys.modules, name, None)
    monkeypatch.setattr("shutil.which", lambda _name: None)
    assert isinstance(create_tone_player(), Beeper)
    assert isinstance(create_speaker(lambda _name: None), ToneSpeaker)
    voice = Voice()
    voice.say("plus ten")
    voice.play_tone("taken")


def test_alarms_of_the_window_are_heard_in_words_and_muted_with_one_key(
    window: MainWindow, monkeypatch: pytest.MonkeyPatch
) -> None:
    loud, mouth = Loudspeaker(), Mouth()
    window.voice._player = loud
    window.voice._set_speaker(mouth)
    alarm = Alarm(
        key="recorder", severity=Severity.WARNING, current=Severity.WARNING, time=3.0,
        message="recorder stopped",
    )  # fmt: skip
    monkeypatch.setattr(window.flight_controller, "unacknowledged_alarms", lambda: (alarm,))
    window.crew.sound_alarms()
    assert (loud.tones, mouth.spoken) == ([], [])  # muted, as the settings of the test say
    window.commands.actions["mute"].trigger()
    assert (loud.tones, mouth.spoken) == (["warning"], ["recorder stopped"])
    window.crew.sound_alarms()
    assert mouth.spoken == ["recorder stopped"]
    window.crew._sounded -= 3.0
    window.voice._toned = ("", 0.0)
    window.crew.sound_alarms()
    assert loud.tones == ["warning", "warning"]
    window.commands.actions["mute"].trigger()
    assert mouth.now is None
    assert loud.tones[-1] == "stop"
    window.close()


def test_windows_without_a_loudspeaker_beeps(
    qapp: QApplication, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(_sound: str | None, _how: int) -> None:
        raise RuntimeError("Failed to play sound")

    flags = {"SND_FILENAME": 0x20000, "SND_ASYNC": 1, "SND_NODEFAULT": 2}
    windows = SimpleNamespace(PlaySound=refuse, **flags)
    monkeypatch.setitem(sys.modules, "winsound", windows)
    beeps: list[bool] = []
    monkeypatch.setattr(QApplication, "beep", lambda: beeps.append(True))
    player = WindowsTonePlayer()
    player.play(next(iter(TONES)))
    player.stop()
    assert beeps == [True]
