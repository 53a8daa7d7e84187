"""The four steps before a flight."""

from __future__ import annotations

from ui.translation import QT_TR_NOOP
from ui.window_frame.page_steps import PageStep

PREFLIGHT_STEPS = (
    PageStep(
        id="card",
        title=QT_TR_NOOP("Flight card"),
        purpose=QT_TR_NOOP("Aircraft, crew, weight, weather"),
    ),
    PageStep(
        id="calibration",
        title=QT_TR_NOOP("Calibration"),
        purpose=QT_TR_NOOP("Calibrate every instrument"),
    ),
    PageStep(
        id="checklist", title=QT_TR_NOOP("Checklist"), purpose=QT_TR_NOOP("Checks before take-off")
    ),
    PageStep(id="cards", title=QT_TR_NOOP("Test cards"), purpose=QT_TR_NOOP("Maneuvers to fly")),
)
"""In the order in which a crew takes them."""
