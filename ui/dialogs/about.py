"""What this program is: versions, license, and where it keeps its files."""

from __future__ import annotations

import platform
import sys
from importlib.metadata import PackageNotFoundError, metadata

from PySide6 import __version__
from PySide6.QtCore import Qt, qVersion
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import QDialogButtonBox, QVBoxLayout, QWidget

from ui.dialogs.form_dialog import SelfDeletingDialog
from ui.display_style import DisplayStyle
from ui.settings import SettingsStore, log_path, recording_folder
from ui.translation import QT_TR_NOOP, tr
from ui.widgets.labels import create_label

_PACKAGE = "gsapp-ground-station"
_LICENSE = "BSD-3-Clause"
_PURPOSE = QT_TR_NOOP(
    "Ground station for flight-testing remotely piloted research aircraft: records, shows and "
    "replays flights, calibrates sensors, estimates derivatives and finds missing model effects."
)


def about_lines(store: SettingsStore) -> tuple[tuple[str, str], ...]:
    """Return what a report of a problem needs, as name and value."""
    try:
        found = metadata(_PACKAGE)
        version, terms = found["Version"], found["License-Expression"] or _LICENSE
    except PackageNotFoundError:
        version, terms = tr("not installed"), _LICENSE
    return (
        (tr("Version"), version),
        ("Python", f"{platform.python_version()} ({sys.executable})"),
        ("Qt", tr("{qt} (PySide6 {pyside})").format(qt=qVersion(), pyside=__version__)),
        (tr("System"), platform.platform()),
        (tr("License"), tr("{terms}. Qt, PySide6 and pymavlink: LGPL.").format(terms=terms)),
        (tr("Settings"), str(store.path)),
        (tr("Log"), str(log_path())),
        (tr("Flights"), str(recording_folder(store.current))),
    )


class AboutDialog(SelfDeletingDialog):
    """Shows it, and copies it for a report."""

    def __init__(
        self, look: DisplayStyle, lines: tuple[tuple[str, str], ...], parent: QWidget | None = None
    ) -> None:
        super().__init__(parent)
        self.setWindowTitle(tr("About"))
        column = QVBoxLayout(self)
        column.setContentsMargins(*[look.px(24)] * 4)
        column.setSpacing(look.px(12))
        column.addWidget(create_label(tr("Ground station"), "title"))
        column.addWidget(create_label(tr(_PURPOSE), "muted", wrap=True))
        self.text = "\n".join(f"{name}: {value}" for name, value in lines)
        shown = create_label(self.text, wrap=True)
        shown.setTextFormat(Qt.TextFormat.PlainText)
        shown.setAccessibleName(tr("Versions and folders"))
        shown.setTextInteractionFlags(
            Qt.TextInteractionFlag.TextSelectableByMouse
            | Qt.TextInteractionFlag.TextSelectableByKeyboard
        )
        column.addWidget(shown)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        self.copy = buttons.addButton(tr("Copy"), QDialogButtonBox.ButtonRole.ActionRole)
        self.copy.clicked.connect(lambda: QGuiApplication.clipboard().setText(self.text))
        buttons.rejected.connect(self.reject)
        column.addWidget(buttons)
        self.resize(look.px(560), look.px(320))
