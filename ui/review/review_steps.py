"""The four chapters of the review."""

from __future__ import annotations

from ui.window_frame.page_steps import PageStep

REVIEW_STEPS = (
    PageStep(id="maneuvers", title="Maneuvers", purpose="Detected maneuvers and their limits"),
    PageStep(id="estimate", title="Estimate", purpose="Derivatives with bounds; saved runs"),
    PageStep(id="figures", title="Figures", purpose="Values, fits, histories, linear models"),
    PageStep(id="summary", title="Summary", purpose="Means, outliers, files, report"),
)
"""In the order in which a crew takes them."""
