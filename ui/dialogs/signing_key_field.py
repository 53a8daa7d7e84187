"""The key of MAVLink signatures: a file of the user, or made from a passphrase."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import Signal
from PySide6.QtWidgets import (
    QFileDialog,
    QHBoxLayout,
    QInputDialog,
    QLineEdit,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from gsapp.foundation import LinkError
from gsapp.telemetry.signing import derive_key, read_signing_key, write_signing_key
from ui.dialogs.flight_requests import InputCheck
from ui.dialogs.form_dialog import FieldMessage
from ui.disk_checks import nearest_folder
from ui.display_style import DisplayStyle
from ui.translation import tr
from ui.widgets.flow_layout import arrange

KEY_FILE = "signing.key"


class SigningKeyField(QWidget):
    """The path of a key file, empty for none.

    `folder`: where a key made from a passphrase is kept, in a file that the user alone may read.
    """

    changed = Signal()

    def __init__(self, current: str, folder: Path, style: DisplayStyle) -> None:
        super().__init__()
        self._folder = folder
        self.input_check = InputCheck(message="")
        column = arrange(QVBoxLayout(self), style.px(8))
        row = QHBoxLayout()
        row.setSpacing(style.px(8))
        self.edit = QLineEdit(current)
        self.edit.setPlaceholderText(tr("None: signatures are not checked"))
        self.edit.setAccessibleName(tr("Signing key"))
        self.edit.textChanged.connect(self._validate)
        row.addWidget(self.edit, 1)
        for text, name, slot in (
            (tr("Choose…"), tr("Choose signing key"), self._choose),
            (tr("Passphrase…"), tr("Signing key from a passphrase"), self._ask_passphrase),
        ):
            button = QPushButton(text)
            button.setAccessibleName(name)
            button.clicked.connect(slot)
            row.addWidget(button)
        column.addLayout(row)
        self.message = FieldMessage()
        column.addWidget(self.message)
        self.setFocusProxy(self.edit)
        self._validate()

    @property
    def value(self) -> str:
        """Return the path of the key file; empty for none."""
        return self.edit.text().strip()

    def use_passphrase(self, passphrase: str) -> None:
        """Keep the key of a passphrase in the user's own folder, and take it from there."""
        path = self._folder / KEY_FILE
        try:
            write_signing_key(path, derive_key(passphrase))
        except OSError as error:
            self.message.set_message(
                tr("The key cannot be kept in {path}: {why}").format(path=path, why=error.strerror),
                "warning",
            )
            return
        self.edit.setText(str(path))
        self._validate()

    def _choose(self) -> None:
        start = str(nearest_folder(Path(self.value or "~").expanduser()))
        path, _kind = QFileDialog.getOpenFileName(self, tr("Signing key"), start)
        if path:
            self.edit.setText(path)

    def _ask_passphrase(self) -> None:
        passphrase, agreed = QInputDialog.getText(
            self, tr("Signing key"), tr("Passphrase, as in the autopilot's ground station"),
            QLineEdit.EchoMode.Password,
        )  # fmt: skip
        if agreed and passphrase:
            self.use_passphrase(passphrase)

    def _validate(self) -> None:
        self.input_check = InputCheck(message="")
        if self.value:
            try:
                read_signing_key(self.value)
            except LinkError as error:
                self.input_check = InputCheck(message=str(error), state="warning")
            else:
                self.input_check = InputCheck(
                    message=tr("What is not signed with this key is recorded and ignored."),
                    state="good",
                )
        self.message.set_message(self.input_check.message, self.input_check.state)
        self.changed.emit()
