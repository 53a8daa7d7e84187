"""Short tones by name, as samples. No Qt.

What goes up is good, what goes down is not; warnings alternate, which nothing else does.
"""

from __future__ import annotations

import io
import wave
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ui.voice.queue import Priority

RATE = 44_100
"""Samples per second."""

_FADE = 0.006
"""Seconds in which a note swells and dies: cut off, it would click."""

_LOUDNESS = 0.6


@dataclass(frozen=True, slots=True, kw_only=True)
class Tone:
    """Notes one after the other.

    Attributes
    ----------
    notes : tuple of (Hz, s)
        Frequency 0 is a pause.
    priority : Priority
        A tone is not heard into a more urgent sentence.
    """

    notes: tuple[tuple[float, float], ...]
    priority: Priority = Priority.PROMPT

    @property
    def seconds(self) -> float:
        """Return how long it lasts."""
        return sum(length for _, length in self.notes)


TONES: Mapping[str, Tone] = {
    "steady": Tone(notes=((1320.0, 0.07),)),
    "taken": Tone(notes=((880.0, 0.09), (1320.0, 0.13))),
    "moved": Tone(notes=((440.0, 0.06),), priority=Priority.NOTE),
    "error": Tone(notes=((392.0, 0.14), (262.0, 0.24))),
    "note": Tone(notes=((587.0, 0.08),), priority=Priority.NOTE),
    "prompt": Tone(notes=((660.0, 0.10),)),
    "caution": Tone(notes=((740.0, 0.14), (0.0, 0.06), (740.0, 0.14)), priority=Priority.WARNING),
    "warning": Tone(notes=((988.0, 0.11), (698.0, 0.11)) * 3, priority=Priority.WARNING),
}
"""Every tone by its name: those of a calibration point, those in place of words, alarms."""

TONE_OF = {Priority.NOTE: "note", Priority.PROMPT: "prompt", Priority.WARNING: "warning"}
"""What is heard in place of words where there is no voice."""


def tone_samples(name: str) -> npt.NDArray[np.int16]:
    """Return the samples of a tone, shape (n,), 16 bit, `RATE` per second.

    Raises
    ------
    KeyError
        If there is no such tone.
    """
    notes = [_note(frequency, seconds) for frequency, seconds in TONES[name].notes]
    return np.concatenate(notes)


def _note(frequency: float, seconds: float) -> npt.NDArray[np.int16]:
    count = round(seconds * RATE)
    time = np.arange(count) / RATE
    edge = np.minimum(time, seconds - time) / _FADE
    envelope = np.sin(0.5 * np.pi * np.clip(edge, 0.0, 1.0)) ** 2
    # A little of the octave carries farther outdoors than a pure sine.
    phase = 2.0 * np.pi * frequency * time
    sound = envelope * (0.8 * np.sin(phase) + 0.2 * np.sin(2.0 * phase))
    return np.rint(_LOUDNESS * 32767.0 * sound).astype(np.int16)


def tone_wave(name: str) -> bytes:
    """Return a tone as the content of a ``.wav`` file."""
    content = io.BytesIO()
    with wave.open(content, "wb") as file:
        file.setnchannels(1)
        file.setsampwidth(2)
        file.setframerate(RATE)
        file.writeframes(tone_samples(name).astype("<i2").tobytes())
    return content.getvalue()
