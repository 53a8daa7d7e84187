"""The key of MAVLink signatures: a file of the user, or made from a passphrase."""

from __future__ import annotations

from dataclasses import dataclass
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


@dataclass(frozen=True, slots=True, kw_only=True)
class KeyPurpose:
    """What a key is for, in words."""

    title: str
    file_name: str  # Of a key made from a passphrase.
    without: str  # What happens without a key.
    effect: str  # What it does.
    passphrase: str  # What is asked for.


def signing_purpose() -> KeyPurpose:
    """Return what a key of MAVLink signatures is for."""
    return KeyPurpose(
        title=tr("Signing key"),
        file_name=KEY_FILE,
        without=tr("None: signatures are not checked"),
        effect=tr("What is not signed with this key is recorded and ignored."),
        passphrase=tr("Passphrase, as in the autopilot's ground station"),
    )


def sharing_purpose() -> KeyPurpose:
    """Return what a key for other computers is for."""
    return KeyPurpose(
        title=tr("Sharing key"),
        file_name="sharing.key",
        without=tr("The signing key, if any"),
        effect=tr("Another computer needs this key to copy the flight."),
        passphrase=tr("Passphrase, the same on both computers"),
    )


class SigningKeyField(QWidget):
    """The path of a key file, empty for none.

    `folder`: where a key made from a passphrase is kept, in a file that the user alone may read.
    """

    changed = Signal()

    def __init__(
        self,
        current: str,
        folder: Path,
        style: DisplayStyle,
        purpose: KeyPurpose | None = None,
    ) -> None:
        super().__init__()
        self._purpose = purpose or signing_purpose()
        self._path = folder / self._purpose.file_name
        self.input_check = InputCheck(message="")
        column = arrange(QVBoxLayout(self), style.px(8))
        row = QHBoxLayout()
        row.setSpacing(style.px(8))
        self.edit = QLineEdit(current)
        self.edit.setPlaceholderText(self._purpose.without)
        self.edit.setAccessibleName(self._purpose.title)
        self.edit.textChanged.connect(self._validate)
        row.addWidget(self.edit, 1)
        for text, name, slot in (
            (tr("Choose…"), tr("{key}: choose a file"), self._choose),
            (tr("Passphrase…"), tr("{key}: from a passphrase"), self._ask_passphrase),
        ):
            button = QPushButton(text)
            button.setAccessibleName(name.format(key=self._purpose.title))
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
        path = self._path
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
        path, _kind = QFileDialog.getOpenFileName(self, self._purpose.title, start)
        if path:
            self.edit.setText(path)

    def _ask_passphrase(self) -> None:
        passphrase, agreed = QInputDialog.getText(
            self, self._purpose.title, self._purpose.passphrase,
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
                self.input_check = InputCheck(message=self._purpose.effect, state="good")
        self.message.set_message(self.input_check.message, self.input_check.state)
        self.changed.emit()
