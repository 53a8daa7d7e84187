"""The four steps of the story."""

from __future__ import annotations

from dataclasses import dataclass

from ui.translation import QT_TR_NOOP


@dataclass(frozen=True, slots=True, kw_only=True)
class GapStage:
    """One step of the story: its name, and what it answers."""

    id: str
    title: str
    question: str


GAP_STAGES = (
    GapStage(
        id="find",
        title=QT_TR_NOOP("Find"),
        question=QT_TR_NOOP("Where do simulation and flight disagree?"),
    ),
    GapStage(id="name", title=QT_TR_NOOP("Name"), question=QT_TR_NOOP("Which effect is missing?")),
    GapStage(id="add", title=QT_TR_NOOP("Add"), question=QT_TR_NOOP("What is the revised model?")),
    GapStage(
        id="show", title=QT_TR_NOOP("Show"), question=QT_TR_NOOP("How much does the gap shrink?")
    ),
)
