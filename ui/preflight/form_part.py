"""What the parts of a form have in common: they show what is on a card, and tell of typing."""

from __future__ import annotations

from typing import Generic, TypeVar

from pydantic import BaseModel
from PySide6.QtCore import Signal
from PySide6.QtWidgets import QVBoxLayout, QWidget

from ui.display_style import DisplayStyle
from ui.preflight.form_editor import FormEditor

T = TypeVar("T", bound=BaseModel)


class FormPart(QWidget, Generic[T]):
    """Part of the form of a file.

    Parameters
    ----------
    look : DisplayStyle
        Colors, sizes, units.

    Attributes
    ----------
    edited : Signal
        The file was changed.
    editing_finished : Signal
        The keyboard went elsewhere.
    """

    edited = Signal()
    editing_finished = Signal()

    def __init__(self, look: DisplayStyle) -> None:
        super().__init__()
        self._look = look
        self._editor: FormEditor[T] | None = None
        self._column = QVBoxLayout(self)
        self._column.setContentsMargins(0, 0, 0, 0)
