"""The Help menu: user guide, shortcuts, messages, and the details of errors."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from PySide6.QtCore import QObject
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import QWidget

from ui.dialogs.about import AboutDialog, about_lines
from ui.dialogs.guide import GuideWindow, guide_folder
from ui.dialogs.messages import MessagesDialog
from ui.dialogs.shortcuts import ShortcutsDialog
from ui.display_style import DisplayStyle
from ui.error_reporter import ErrorReporter
from ui.settings import SettingsStore
from ui.translation import tr
from ui.window_frame.banners import BannerStack


class HelpMenuController(QObject):
    """Opens the dialogs of the Help menu over a window."""

    def __init__(
        self,
        window: QWidget,
        look: DisplayStyle,
        store: SettingsStore,
        banners: BannerStack,
        error_reporter: ErrorReporter,
    ) -> None:
        super().__init__(window)
        self._window = window
        self._look = look
        self._store = store
        self._banners = banners
        self._error_reporter = error_reporter

    @property
    def handlers(self) -> Mapping[str, Callable[[], object]]:
        return {
            "keys": lambda: ShortcutsDialog(self._look, self._window).exec(),
            "copy_details": self.copy_details,
            "messages": self.show_messages,
            "about": lambda: AboutDialog(self._look, about_lines(self._store), self._window).exec(),
            "guide": self.show_guide,
        }

    def show_guide(self) -> None:
        folder = guide_folder()
        if folder is None:
            self._banners.show_banner("caution", tr("The user guide is not installed."))
            return
        GuideWindow(self._look, folder, self._window).show()

    def show_messages(self) -> None:
        for former in self._window.findChildren(MessagesDialog):
            former.close()
        MessagesDialog(self._look, self._banners, self._window).show()

    def copy_details(self) -> None:
        report = self._error_reporter.last_report
        if report is None:
            self._banners.show_banner("note", tr("There was no error."))
            return
        QGuiApplication.clipboard().setText(report.details)
        self._banners.show_banner("note", tr("The details of the last error are on the clipboard."))
