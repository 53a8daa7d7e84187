"""The four steps of the story."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Chapter:
    """One step of the story: its name, and what it answers."""

    id: str
    title: str
    question: str


CHAPTERS = (
    Chapter(id="find", title="Find", question="Where do simulation and flight disagree?"),
    Chapter(id="name", title="Name", question="Which effect is missing?"),
    Chapter(id="add", title="Add", question="What does the model become?"),
    Chapter(id="show", title="Show", question="How far does the gap shrink?"),
)
