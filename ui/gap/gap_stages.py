"""The four steps of the story."""

from __future__ import annotations

from ui.translation import QT_TR_NOOP
from ui.window_frame.page_steps import PageStep

GAP_STAGES = (
    PageStep(
        id="find",
        title=QT_TR_NOOP("Find"),
        purpose=QT_TR_NOOP("Where do simulation and flight disagree?"),
    ),
    PageStep(id="name", title=QT_TR_NOOP("Name"), purpose=QT_TR_NOOP("Which effect is missing?")),
    PageStep(id="add", title=QT_TR_NOOP("Add"), purpose=QT_TR_NOOP("What is the revised model?")),
    PageStep(
        id="show", title=QT_TR_NOOP("Show"), purpose=QT_TR_NOOP("How much does the gap shrink?")
    ),
)
