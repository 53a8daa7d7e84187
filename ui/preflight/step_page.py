"""What the pages of the steps have in common."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ui.window_frame.step_page import AbstractStepPage

if TYPE_CHECKING:
    from ui.preflight.preflight_model import PreflightModel


class PreflightStepPage(AbstractStepPage):
    """The page of one step."""

    def set_model(self, model: PreflightModel) -> None:
        """Show what belongs to another flight."""
        raise NotImplementedError
