"""Fields that several dialogs use: a shipped file or a file of one's own; where to record."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime
from pathlib import Path

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QComboBox, QFileDialog, QLineEdit, QSizePolicy, QVBoxLayout, QWidget

from ui.dialogs.form import PathField, Sentence
from ui.dialogs.requests import Verdict, check_folder, next_flight_name
from ui.look import Look

_OWN = "Other file…"


class ShippedField(QComboBox):
    """A file by name, or one of the user's own.

    Parameters
    ----------
    name : str
        What it is.
    shipped : sequence of str
        Names that come with the program.
    none : str
        Words for going without one; empty if there must be one.
    """

    def __init__(
        self,
        name: str,
        shipped: Sequence[str],
        current: str,
        *,
        none: str = "",
        folder: bool = False,
    ) -> None:
        super().__init__()
        self._name = name
        self._folder = folder
        self.setAccessibleName(name)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        if none:
            self.addItem(none, "")
        for known in shipped:
            self.addItem(known, known)
        if current and current not in shipped and Path(current).exists():
            self.addItem(current, current)
        self.addItem("Other folder…" if folder else _OWN, None)
        place = self.findData(current)
        self.setCurrentIndex(max(place, 0))
        self._kept = self.currentIndex()
        self.activated.connect(self._activated)

    def _activated(self, index: int) -> None:
        if self.itemData(index) is not None:
            self._kept = index
            return
        if self._folder:
            path = QFileDialog.getExistingDirectory(self, self._name)
        else:
            path, _kind = QFileDialog.getOpenFileName(self, self._name, "", "TOML (*.toml)")
        if path:
            self.insertItem(index, path, path)
            self._kept = index
        self.setCurrentIndex(self._kept)

    def offer(self, names: Sequence[str]) -> None:
        """Offer further names, before the last line."""
        for name in names:
            if self.findData(name) < 0:
                self.insertItem(self.count() - 1, name, name)
        self._kept = self.currentIndex()

    def show_value(self, value: str) -> None:
        """Show a name or path, offered from now on if it was not."""
        self.offer((value,))
        self.setCurrentIndex(self.findData(value))
        self._kept = self.currentIndex()

    @property
    def value(self) -> str:
        """Return the name or path chosen; empty for none."""
        return str(self.currentData() or "")


class FlightPlace(QWidget):
    """Name and place of a new flight, with a sentence about them.

    Attributes
    ----------
    changed : Signal
        Something else is typed now.
    """

    changed = Signal()

    def __init__(self, parent_folder: Path, look: Look) -> None:
        super().__init__()
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(look.px(8))
        self.name = QLineEdit()
        self.name.setAccessibleName("Name of the flight")
        self.parent_folder = PathField("Folder of the flights", look)
        self.parent_folder.edit.setText(str(parent_folder))
        self.sentence = Sentence()
        column.addWidget(self.name)
        column.addWidget(self.parent_folder)
        column.addWidget(self.sentence)
        today = datetime.now().astimezone().date()
        self.name.setText(next_flight_name(parent_folder, today))
        self.name.textChanged.connect(self._judge)
        self.parent_folder.edit.textChanged.connect(self._judge)
        self.setFocusProxy(self.name)
        self.verdict = Verdict(sentence="")
        self._judge()

    def _judge(self) -> None:
        self.verdict = check_folder(self.parent_folder.edit.text(), self.name.text())
        self.sentence.say(self.verdict.sentence, self.verdict.state)
        self.changed.emit()

    @property
    def folder(self) -> Path:
        """Return the flight folder."""
        return Path(self.parent_folder.edit.text()).expanduser() / self.name.text().strip()
