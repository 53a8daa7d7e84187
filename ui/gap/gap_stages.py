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
    GapStage(id="add", title="Add", question="What is the revised model?"),
    GapStage(id="show", title="Show", question="How much does the gap shrink?"),
)
