"""What speaks and sounds to a crew that looks at the aircraft, not at the screen."""

from __future__ import annotations

from typing import Protocol


class Prompter(Protocol):
    """Says short sentences and gives tones; mute is its own affair."""

    def say(self, words: str) -> None:
        """Say words; what waits to be said and is out of date by now is dropped."""

    def play_tone(self, name: str) -> None:
        """Give a tone: ``steady``, ``taken``, ``moved``, ``error``."""


class SilentPrompter:
    """Says nothing."""

    def say(self, words: str) -> None:
        """Say nothing."""

    def play_tone(self, name: str) -> None:
        """Give no tone."""
