"""The four steps before a flight."""

from __future__ import annotations

from ui.window_frame.page_steps import PageStep

PREFLIGHT_STEPS = (
    PageStep(id="card", title="Flight card", purpose="Who flies what, how heavy, in what air"),
    PageStep(id="calibration", title="Calibration", purpose="Volts of every instrument to angles"),
    PageStep(id="checklist", title="Checklist", purpose="What must be green before take-off"),
    PageStep(id="cards", title="Test cards", purpose="The maneuvers that are to be flown"),
)
"""In the order in which a crew takes them."""
