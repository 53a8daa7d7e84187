"""The four steps before a flight, and what their pages have in common."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QTimer

from gsapp.foundation import GroundStationError
from ui.display_style import DisplayStyle
from ui.translation import QT_TR_NOOP
from ui.window_frame.page_steps import PageStep
from ui.window_frame.step_page import AbstractStepPage

if TYPE_CHECKING:
    from ui.preflight.form_editor import FormEditor
    from ui.preflight.preflight_model import PreflightModel


_SAVE_MS = 400
"""Quiet after which what was typed goes to the disk."""
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


class PreflightStepPage(AbstractStepPage):
    """The page of one step."""

    def set_model(self, model: PreflightModel) -> None:
        """Show what belongs to another flight."""
        raise NotImplementedError


class SavingStepPage(PreflightStepPage):
    """The page of a step whose file is saved as it is typed."""

    def __init__(
        self, style: DisplayStyle, name: str, fail: Callable[[BaseException], object]
    ) -> None:
        super().__init__(style, name)
        self._fail = fail
        self._save_timer = QTimer(self)
        self._save_timer.setSingleShot(True)
        self._save_timer.setInterval(_SAVE_MS)
        self._save_timer.timeout.connect(self.flush)

    @property
    def form_editor(self) -> FormEditor[Any] | None:
        """Return what is typed into; None where it cannot be read."""
        raise NotImplementedError

    def show_save_state(self) -> None:
        """Say whether everything is on the disk."""
        raise NotImplementedError

    def flush(self) -> None:
        """Write what was typed to the disk."""
        self._save_timer.stop()
        editor = self.form_editor
        if editor is None or editor.file.is_saved:
            return
        try:
            editor.save()
        except GroundStationError as error:
            self._fail(error)
        self.show_save_state()
