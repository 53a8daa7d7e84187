"""The four steps before a flight."""

from __future__ import annotations

from ui.frame.steps import Step

STEPS = (
    Step(id="card", title="Flight card", purpose="Who flies what, how heavy, in what air"),
    Step(id="calibration", title="Calibration", purpose="Volts of every instrument to angles"),
    Step(id="checklist", title="Checklist", purpose="What must be green before take-off"),
    Step(id="cards", title="Test cards", purpose="The maneuvers that are to be flown"),
)
"""In the order in which a crew takes them."""
