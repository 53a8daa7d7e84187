"""The four steps of the story."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class GapStage:
    """One step of the story: its name, and what it answers."""

    id: str
    title: str
    question: str


GAP_STAGES = (
    GapStage(id="find", title="Find", question="Where do simulation and flight disagree?"),
    GapStage(id="name", title="Name", question="Which effect is missing?"),
    GapStage(id="add", title="Add", question="What does the model become?"),
    GapStage(id="show", title="Show", question="How far does the gap shrink?"),
)
