"""What several dialogs share: a shipped file or a file of one's own; where to record."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime
from pathlib import Path

from PySide6.QtCore import QTimer, Signal
from PySide6.QtWidgets import QComboBox, QFileDialog, QLineEdit, QSizePolicy, QVBoxLayout, QWidget

from gsapp.foundation import FlightError
from ui.dialogs.flight_requests import InputCheck, check_folder, next_flight_name
from ui.dialogs.form_dialog import FieldMessage, FormDialog, PathField
from ui.disk_checks import nearest_folder, path_kind
from ui.display_style import DisplayStyle
from ui.settings import writable_folder
from ui.translation import QT_TR_NOOP, tr
from ui.widgets.flow_layout import arrange

_OTHER_FILE = QT_TR_NOOP("Other file…")
_RETRY_MS = 1000


class ShippedFileField(QComboBox):
    """A file by name, or one of the user's own.

    `none`: words for going without one; empty if there must be one.
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
        if current and current not in shipped and path_kind(current) in ("file", "folder"):
            self.addItem(current, current)
        self.addItem(tr("Other folder…") if folder else tr(_OTHER_FILE), None)
        place = self.findData(current)
        self.setCurrentIndex(max(place, 0))
        self._kept = self.currentIndex()
        self.activated.connect(self._activated)

    def _activated(self, index: int) -> None:
        if self.itemData(index) is not None:
            self._kept = index
            return
        # Where Qt was last may be a disk that does not respond.
        start = str(nearest_folder(Path(str(self.itemData(self._kept) or "~")).expanduser()))
        if self._folder:
            path = QFileDialog.getExistingDirectory(self, self._name, start)
        else:
            path, _kind = QFileDialog.getOpenFileName(self, self._name, start, tr("TOML (*.toml)"))
        if path:
            self.insertItem(index, path, path)
            self._kept = index
        self.setCurrentIndex(self._kept)

    def add_names(self, names: Sequence[str]) -> None:
        """Offer further names, before the last line."""
        for name in names:
            if self.findData(name) < 0:
                self.insertItem(self.count() - 1, name, name)
        self._kept = self.currentIndex()

    def show_value(self, value: str) -> None:
        """Show a name or path, offered from now on if it was not."""
        self.add_names((value,))
        self.setCurrentIndex(self.findData(value))
        self._kept = self.currentIndex()

    @property
    def value(self) -> str:
        return str(self.currentData() or "")


class FlightFolderField(QWidget):
    """Title and folder of a new flight, with a sentence about them.

    `parent_folder`: where flights are recorded; the usual folder takes its place if it cannot be
    written. `proposed_parent`: folder of the flights, as proposed.
    """

    changed = Signal()  # Something else is typed now.

    def __init__(self, parent_folder: Path, style: DisplayStyle) -> None:
        super().__init__()
        column = arrange(QVBoxLayout(self), style.px(8))
        self.title = QLineEdit()
        self.title.setPlaceholderText(tr("Title (optional)"))
        self.title.setAccessibleName(tr("Title of the flight"))
        self.name = QLineEdit()
        self.name.setAccessibleName(tr("Name of the flight folder"))
        self.name.setToolTip(tr("Folder of this flight: its date and a letter"))
        self.parent_folder = PathField(tr("Folder of the flights"), style)
        self.message = FieldMessage()
        for field in (self.title, self.name, self.parent_folder, self.message):
            column.addWidget(field)
        self.proposed_parent, self._why_other = writable_folder(parent_folder)
        self.parent_folder.edit.setText(str(self.proposed_parent))
        today = datetime.now().astimezone().date()
        self.name.setText(next_flight_name(self.proposed_parent, today))
        self.name.textChanged.connect(self._validate)
        self.parent_folder.edit.textChanged.connect(self._validate)
        self.setFocusProxy(self.title)
        # A disk that spins up answers later.
        self._again = QTimer(self, singleShot=True, interval=_RETRY_MS)
        self._again.timeout.connect(self._validate)
        self.input_check = InputCheck(message="")
        self._validate()

    def _validate(self) -> None:
        parent = self.parent_folder.edit.text()
        self.input_check = verdict = check_folder(parent, self.name.text())
        state, text = verdict.state, verdict.message
        if self._why_other and verdict.is_valid and Path(parent) == self.proposed_parent:
            state, text = "caution", f"{self._why_other} {text}"
        self.message.set_message(text, state)
        if not verdict.is_valid:
            self._again.start()
        self.changed.emit()

    @property
    def folder(self) -> Path:
        return Path(self.parent_folder.edit.text()).expanduser() / self.name.text().strip()


class RecordingDialog(FormDialog):
    """Asks for a flight to be recorded, and stays open until its recording has begun.

    `folder_field`: title and folder of the flight. `is_connecting`: whether the recording is about
    to begin.
    """

    # The user wants the flight. The dialog stays until it is accepted once more, or told of a
    # refusal.
    submitted = Signal()

    def add_folder_field(self, flights: Path) -> None:
        """Add the last rows: title and folder of the flight, and what went wrong."""
        self.is_connecting = False
        self.folder_field = FlightFolderField(flights, self.display_style)
        self.add_row(tr("Flight"), self.folder_field)
        self.error = FieldMessage()
        self.add_row("", self.error)
        self.folder_field.changed.connect(self._validate)
        self._validate()

    @property
    def is_valid(self) -> bool:
        return self.folder_field.input_check.is_valid

    def _validate(self) -> None:
        self.error.set_message("")
        self.button.setEnabled(self.is_valid and not self.is_connecting)

    def accept(self) -> None:
        if self.is_connecting:
            super().accept()
            return
        self.is_connecting = True
        self._validate()
        self.error.set_message(tr("Starting the recording…"))
        self.submitted.emit()

    def cancel_submission(self) -> None:
        """Take back what was submitted; all that was typed stays."""
        self.is_connecting = False
        self._validate()

    def show_error(self, error: Exception) -> None:
        """Say beside the field at fault why nothing is recorded; all that was typed stays."""
        self.cancel_submission()
        self._sentence_of(error).set_message(str(error), "warning")

    def _sentence_of(self, error: Exception) -> FieldMessage:
        at_place = isinstance(error, FlightError) or str(self.folder_field.folder) in str(error)
        return self.folder_field.message if at_place else self.error
