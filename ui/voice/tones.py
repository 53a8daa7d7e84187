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

from ui.voice.speech_queue import UtterancePriority

SAMPLE_RATE = 44_100  # Samples per second.

_FADE = 0.006  # Seconds in which a note swells and dies: cut off, it would click.

_LOUDNESS = 0.6


@dataclass(frozen=True, slots=True, kw_only=True)
class ToneSequence:
    """Notes one after the other."""

    notes: tuple[tuple[float, float], ...]  # Frequency 0 is a pause.
    # A tone is not heard into a more urgent sentence.
    priority: UtterancePriority = UtterancePriority.PROMPT

    @property
    def duration(self) -> float:
        """Return how long it lasts."""
        return sum(length for _, length in self.notes)


TONES: Mapping[str, ToneSequence] = {
    "steady": ToneSequence(notes=((1320.0, 0.07),)),
    "taken": ToneSequence(notes=((880.0, 0.09), (1320.0, 0.13))),
    "moved": ToneSequence(notes=((440.0, 0.06),), priority=UtterancePriority.NOTE),
    "error": ToneSequence(notes=((392.0, 0.14), (262.0, 0.24))),
    "note": ToneSequence(notes=((587.0, 0.08),), priority=UtterancePriority.NOTE),
    "prompt": ToneSequence(notes=((660.0, 0.10),)),
    "caution": ToneSequence(
        notes=((740.0, 0.14), (0.0, 0.06), (740.0, 0.14)), priority=UtterancePriority.WARNING
    ),
    "warning": ToneSequence(
        notes=((988.0, 0.11), (698.0, 0.11)) * 3, priority=UtterancePriority.WARNING
    ),
}
"""Every tone by its name: those of a calibration point, those in place of words, alarms."""

PRIORITY_TONES = {
    UtterancePriority.NOTE: "note",
    UtterancePriority.PROMPT: "prompt",
    UtterancePriority.WARNING: "warning",
}
"""What is heard in place of words where there is no voice."""


def tone_samples(name: str) -> npt.NDArray[np.int16]:
    """Return the samples of a tone, shape (n,), 16 bit, `SAMPLE_RATE` per second."""
    notes = [_note(frequency, seconds) for frequency, seconds in TONES[name].notes]
    return np.concatenate(notes)


def _note(frequency: float, seconds: float) -> npt.NDArray[np.int16]:
    count = round(seconds * SAMPLE_RATE)
    time = np.arange(count) / SAMPLE_RATE
    edge = np.minimum(time, seconds - time) / _FADE
    envelope = np.sin(0.5 * np.pi * np.clip(edge, 0.0, 1.0)) ** 2
    # A little of the octave carries farther outdoors than a pure sine.
    phase = 2.0 * np.pi * frequency * time
    sound = envelope * (0.8 * np.sin(phase) + 0.2 * np.sin(2.0 * phase))
    return np.rint(_LOUDNESS * 32767.0 * sound).astype(np.int16)


def tone_wav(name: str) -> bytes:
    """Return a tone as the content of a ``.wav`` file."""
    content = io.BytesIO()
    with wave.open(content, "wb") as file:
        file.setnchannels(1)
        file.setsampwidth(2)
        file.setframerate(SAMPLE_RATE)
        file.writeframes(tone_samples(name).astype("<i2").tobytes())
    return content.getvalue()
