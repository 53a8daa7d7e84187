"""The four steps before a flight."""

from __future__ import annotations

from ui.window_frame.page_steps import PageStep

PREFLIGHT_STEPS = (
    PageStep(id="card", title="Flight card", purpose="Aircraft, crew, weight, weather"),
    PageStep(id="calibration", title="Calibration", purpose="Calibrate every instrument"),
    PageStep(id="checklist", title="Checklist", purpose="Checks before take-off"),
    PageStep(id="cards", title="Test cards", purpose="Maneuvers to fly"),
)
"""In the order in which a crew takes them."""
