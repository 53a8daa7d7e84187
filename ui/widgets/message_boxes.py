"""Message boxes. Names of files and columns stand in them as they are: no text is markup."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QLabel, QMessageBox, QWidget

from ui.translation import tr


def create_message_box(
    parent: QWidget | None, title: str, text: str, consequence: str = ""
) -> QMessageBox:
    """Return a box with a sentence, and what follows from it, without buttons yet."""
    box = QMessageBox(parent)
    box.setWindowTitle(title)
    box.setIcon(QMessageBox.Icon.NoIcon)
    box.setText(text)
    box.setInformativeText(consequence)
    # Its own `setTextFormat` leaves out the label below.
    for label in box.findChildren(QLabel):
        label.setTextFormat(Qt.TextFormat.PlainText)
    return box


def show_warning(parent: QWidget | None, title: str, text: str) -> None:
    """Show a sentence that has to be read before going on."""
    box = create_message_box(parent, title, text)
    box.addButton(tr("Close"), QMessageBox.ButtonRole.AcceptRole)
    box.exec()
    box.deleteLater()
