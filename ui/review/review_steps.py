"""The four chapters of the review."""

from __future__ import annotations

from ui.translation import QT_TR_NOOP
from ui.window_frame.page_steps import PageStep

REVIEW_STEPS = (
    PageStep(
        id="maneuvers",
        title=QT_TR_NOOP("Maneuvers"),
        purpose=QT_TR_NOOP("Detected maneuvers and their limits"),
    ),
    PageStep(
        id="estimate",
        title=QT_TR_NOOP("Estimate"),
        purpose=QT_TR_NOOP("Derivatives with bounds; saved runs"),
    ),
    PageStep(
        id="figures",
        title=QT_TR_NOOP("Figures"),
        purpose=QT_TR_NOOP("Values, fits, histories, linear models"),
    ),
    PageStep(
        id="summary",
        title=QT_TR_NOOP("Summary"),
        purpose=QT_TR_NOOP("Means, outliers, files, report"),
    ),
)
"""In the order in which a crew takes them."""
