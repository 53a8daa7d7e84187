"""The four chapters of the review."""

from __future__ import annotations

from ui.frame.steps import Step

CHAPTERS = (
    Step(id="maneuvers", title="Maneuvers", purpose="What was flown, cut where it should be"),
    Step(id="estimate", title="Estimate", purpose="Derivatives with their bounds; runs kept"),
    Step(id="figures", title="Figures", purpose="Values, fits, histories, linear models"),
    Step(id="summary", title="Summary", purpose="Means, outliers, files, report"),
)
"""In the order in which a crew takes them."""
