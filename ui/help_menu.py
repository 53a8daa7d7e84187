"""The Help menu: user guide, all keys, messages, versions, and the details of errors."""

from __future__ import annotations

import platform
import sys
from collections.abc import Callable, Mapping
from importlib.metadata import PackageNotFoundError, metadata
from pathlib import Path

from PySide6 import __version__
from PySide6.QtCore import QObject, QSize, Qt, QUrl, qVersion
from PySide6.QtGui import QDesktopServices, QGuiApplication, QPalette, QTextDocument
from PySide6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QFrame,
    QGridLayout,
    QHBoxLayout,
    QLineEdit,
    QListWidget,
    QListWidgetItem,
    QScrollArea,
    QTextBrowser,
    QVBoxLayout,
    QWidget,
)

from gsapp.quantities import convert_text_units
from ui.commands import COMMANDS, shortcut_text
from ui.dialogs.form_dialog import SelfDeletingDialog
from ui.display_style import DisplayStyle
from ui.error_reporter import ErrorReporter
from ui.flight.side_panels import ListPanel
from ui.icons import IndicatorState
from ui.settings import SettingsStore, log_path, recording_folder
from ui.translation import QT_TR_NOOP, tr
from ui.widgets.flow_layout import FlowLayout, arrange
from ui.widgets.labels import create_label, plain_tooltip
from ui.widgets.row_model import TableRow, TableRowModel
from ui.widgets.table_view import TableRowView
from ui.window_frame.banners import LEVEL_TITLES, BannerMessage, BannerStack

_PACKAGE = "gsapp-ground-station"
_LICENSE = "BSD-3-Clause"
_PROGRAM_PURPOSE = QT_TR_NOOP(
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
        self, style: DisplayStyle, lines: tuple[tuple[str, str], ...], parent: QWidget | None = None
    ) -> None:
        super().__init__(parent)
        self.setWindowTitle(tr("About"))
        column = arrange(QVBoxLayout(self), style.px(12), *[style.px(24)] * 4)
        content = QWidget()
        content.setObjectName("page")
        text = arrange(QVBoxLayout(content), style.px(12))
        text.addWidget(create_label(tr("Ground station"), "title"))
        text.addWidget(create_label(tr(_PROGRAM_PURPOSE), "muted", wrap=True))
        self.text = "\n".join(f"{name}: {value}" for name, value in lines)
        shown = create_label(self.text, wrap=True)
        shown.setAccessibleName(tr("Versions and folders"))
        shown.setTextInteractionFlags(
            Qt.TextInteractionFlag.TextSelectableByMouse
            | Qt.TextInteractionFlag.TextSelectableByKeyboard
        )
        text.addWidget(shown)
        text.addStretch(1)
        area = QScrollArea()
        area.setProperty("role", "read")
        area.setAccessibleName(tr("About"))
        area.setWidgetResizable(True)
        area.setWidget(content)
        column.addWidget(area, 1)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        self.copy = buttons.addButton(tr("Copy"), QDialogButtonBox.ButtonRole.ActionRole)
        self.copy.clicked.connect(lambda: QGuiApplication.clipboard().setText(self.text))
        buttons.rejected.connect(self.reject)
        column.addWidget(buttons)
        room = self.screen().availableSize() - QSize(32, 64)
        self.resize(QSize(style.px(560), style.px(320)).boundedTo(room))


_KINDS = ("how-to", "reference", "explanation")
"""Folders of pages, in the order of the list; the tutorial comes first."""


def guide_folder() -> Path | None:
    """Return where the documents are: beside the source, or where an installation puts them.

    ``pip install --target`` and ``--user`` put ``share`` elsewhere than into ``sys.prefix``, but
    always beside or above the packages.
    """
    above = Path(__file__).parents[1:]
    places = (above[0] / "docs", *(folder / "share/doc/gsapp" for folder in above))
    return next((place for place in places if (place / "tutorial.md").is_file()), None)


def guide_pages(folder: Path) -> tuple[tuple[str, Path], ...]:
    """Return title and file of each page: tutorial, how-to, reference, explanation, the rest."""
    tutorial = folder / "tutorial.md"
    kinds = (path for kind in _KINDS for path in sorted((folder / kind).glob("*.md")))
    rest = (path for path in sorted(folder.glob("*.md")) if path != tutorial)
    return tuple((_title(path), path) for path in (tutorial, *kinds, *rest))


def _title(path: Path) -> str:
    with path.open(encoding="utf-8") as lines:
        return next((line[2:].strip() for line in lines if line.startswith("# ")), path.stem)


class GuideWindow(QDialog):
    """Pages on the left, the chosen one on the right. Stays open beside the window."""

    def __init__(self, style: DisplayStyle, folder: Path, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWindowTitle(tr("User guide"))
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.resize(style.px(960), style.px(720))
        row = arrange(QHBoxLayout(self), 0)
        self.pages = QListWidget()
        self.pages.setAccessibleName(tr("Pages of the guide"))
        self.pages.setFixedWidth(style.px(240))
        self.browser = QTextBrowser()
        self.browser.setAccessibleName(tr("Page of the guide"))
        self.browser.setOpenLinks(False)
        palette = self.browser.palette()
        palette.setColor(QPalette.ColorRole.Link, style.color("target"))
        self.browser.setPalette(palette)
        self._margin = style.px(24)
        self.browser.anchorClicked.connect(self._open_link)
        row.addWidget(self.pages)
        row.addWidget(self.browser, 1)
        for title, path in guide_pages(folder):
            item = QListWidgetItem(title)
            item.setToolTip(plain_tooltip(title))
            item.setData(Qt.ItemDataRole.UserRole, path)
            self.pages.addItem(item)
        self.pages.currentItemChanged.connect(
            lambda item, _former: self.show_page(item.data(Qt.ItemDataRole.UserRole))
        )
        self.pages.setCurrentRow(0)
        self.pages.setFocus()

    def show_page(self, path: Path) -> None:
        self.browser.setSource(
            QUrl.fromLocalFile(str(path)), QTextDocument.ResourceType.MarkdownResource
        )
        self.browser.document().setDocumentMargin(self._margin)

    def _open_link(self, link: QUrl) -> None:
        target = self.browser.source().resolved(link)
        if not target.isLocalFile():
            QDesktopServices.openUrl(target)
            return
        for row in range(self.pages.count()):
            if str(self.pages.item(row).data(Qt.ItemDataRole.UserRole)) == target.toLocalFile():
                self.pages.setCurrentRow(row)
                if target.fragment():
                    self.browser.scrollToAnchor(target.fragment())
                return
        if target.toLocalFile() == self.browser.source().toLocalFile():
            self.browser.scrollToAnchor(target.fragment())
            return
        path = Path(target.toLocalFile())
        if not path.exists():
            # An installation has the license beside the pages, not above them.
            path = Path(self.browser.source().toLocalFile()).with_name(path.name)
        if path.suffix in ("", ".md") and path.is_file():
            self.show_page(path)


_STATES: dict[str, IndicatorState] = {"caution": "caution", "warning": "warning"}


class MessagesDialog(QDialog):
    """The list, newest first. Stays open beside the window."""

    def __init__(
        self, style: DisplayStyle, banners: BannerStack, parent: QWidget | None = None
    ) -> None:
        super().__init__(parent)
        self._style, self._banners = style, banners
        self.setWindowTitle(tr("Messages"))
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.resize(style.px(720), style.px(440))
        column = arrange(
            QVBoxLayout(self), style.px(8), style.px(16), style.px(16), style.px(16), style.px(16)
        )
        model = TableRowModel(style, (tr("Time"), tr("Kind"), tr("Message")))
        widths = {0: "00:00:00", 1: max(map(tr, LEVEL_TITLES.values()), key=len)}
        self.view = TableRowView(model, style, tr("Messages"), stretch=2, widths=widths)
        self.panel = ListPanel(self.view, style, tr("No message yet."))
        self.show_again_button = self.panel.add_button(
            tr("Show again"),
            tr("Show the message again below the page"),
            tr("Choose a message first"),
        )
        self.show_again_button.clicked.connect(self._show_again)
        self.view.opened.connect(lambda _key: self._show_again())
        column.addWidget(self.panel, 1)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        buttons.rejected.connect(self.reject)
        column.addWidget(buttons)
        banners.changed.connect(self.refresh)
        style.changed.connect(self.refresh)
        self.refresh()

    def refresh(self) -> None:
        self.panel.show_rows(
            [_message_row(message, self._style.units) for message in self._banners.messages]
        )

    def _show_again(self) -> None:
        message = self.view.current_key()
        if isinstance(message, BannerMessage):
            self._banners.show_again(message)


def _message_row(message: BannerMessage, units: str) -> TableRow:
    return TableRow(
        key=message,
        cells=(
            message.time.strftime("%H:%M:%S"),
            tr(LEVEL_TITLES[message.level]),
            convert_text_units(message.text, units),
        ),
        state=_STATES.get(message.level, "plain"),
        colored=frozenset({1}),
    )


_MOUSE_ACTIONS = (
    (QT_TR_NOOP("Click on the charts"), QT_TR_NOOP("Cursor with all values at that time")),
    (QT_TR_NOOP("Double-click"), QT_TR_NOOP("Enlarge one chart, or show all again")),
    (QT_TR_NOOP("Wheel"), QT_TR_NOOP("Zoom in or out in time")),
    (QT_TR_NOOP("Shift and wheel"), QT_TR_NOOP("Scroll in time")),
    (
        QT_TR_NOOP("Wheel over a value axis, or Ctrl and wheel"),
        QT_TR_NOOP("Scale the values of that chart"),
    ),
    (QT_TR_NOOP("Drag a value axis"), QT_TR_NOOP("Shift the values of that chart")),
    (QT_TR_NOOP("Double-click on a value axis"), QT_TR_NOOP("Autoscale that chart")),
    (
        QT_TR_NOOP("Right-click on charts and tables"),
        QT_TR_NOOP("Menu: copy, limits, range, marks, export"),
    ),
)

_FOCUS_KEYS = (
    ("Tab", QT_TR_NOOP("Next control; with Shift: previous control")),
    ("Alt", QT_TR_NOOP("Menu bar")),
    ("Shift+F10", QT_TR_NOOP("Context menu of the chart, figure or table; also the menu key")),
    (QT_TR_NOOP("Arrows"), QT_TR_NOOP("Pages, steps, status bar: next and previous")),
    (
        QT_TR_NOOP("Arrows"),
        QT_TR_NOOP("Figures, time line: move and zoom; next and previous point"),
    ),
    ("Home", QT_TR_NOOP("Figures, time line: show everything")),
    ("C", QT_TR_NOOP("Figures, time line: cursor with values; arrows move it")),
    ("A", QT_TR_NOOP("Time line, after C: begin a selection; arrows extend it")),
)
"""What the control with the focus does with keys that no menu lists."""


_KEY_SHARE = 0.45
"""Share of the width of a card that keys may take beside their words; longer ones stand below."""


class ShortcutsDialog(SelfDeletingDialog):
    """Every key of the window, to be searched."""

    def __init__(self, style: DisplayStyle, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWindowTitle(tr("All keys"))
        room = self.screen().availableSize() - QSize(32, 64)
        self.resize(QSize(style.px(880), style.px(640)).boundedTo(room))
        column = arrange(
            QVBoxLayout(self), style.px(8), style.px(24), style.px(16), style.px(24), style.px(16)
        )
        self.search = QLineEdit()
        self.search.setPlaceholderText(tr("Search keys or actions"))
        self.search.setAccessibleName(tr("Search the keys"))
        self.search.setClearButtonEnabled(True)
        column.addWidget(self.search)
        area = QScrollArea()
        area.setProperty("role", "read")
        area.setAccessibleName(tr("Keys"))
        area.setWidgetResizable(True)
        area.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        body = QWidget()
        body.setObjectName("page")
        self._flow = FlowLayout(body, spacing=style.px(16))
        self._cards: list[tuple[QFrame, list[tuple[str, list[QWidget]]]]] = []
        for place in dict.fromkeys((known.menu, known.submenu) for known in COMMANDS):
            commands = [
                known
                for known in COMMANDS
                if (known.menu, known.submenu) == place and known.shortcuts
            ]
            menu = ": ".join(tr(title) for title in place if title)
            if not commands:
                continue
            lines = [
                (
                    tr(known.text).rstrip("…"),
                    tr("  or  ").join(shortcut_text(key) for key in known.shortcuts),
                )
                for known in commands
            ]
            self._flow.addWidget(self._card(menu, lines, style))
        focus = [(tr(what), tr(key)) for key, what in _FOCUS_KEYS]
        self._flow.addWidget(self._card(tr("Control with the focus"), focus, style))
        mouse = [(tr(what), tr(how)) for how, what in _MOUSE_ACTIONS]
        self._flow.addWidget(self._card(tr("With the mouse"), mouse, style))
        area.setWidget(body)
        column.addWidget(area, 1)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        buttons.rejected.connect(self.reject)
        column.addWidget(buttons)
        self.search.textChanged.connect(self.filter_rows)
        self.search.setFocus()

    def _card(self, title: str, lines: list[tuple[str, str]], style: DisplayStyle) -> QFrame:
        card = QFrame()
        card.setObjectName("card")
        wide = min(style.px(392), self.width() - style.px(80))
        card.setFixedWidth(wide)
        grid = QGridLayout(card)
        grid.setContentsMargins(style.px(16), style.px(12), style.px(16), style.px(12))
        grid.setVerticalSpacing(style.px(4))
        grid.setHorizontalSpacing(style.px(16))
        grid.setColumnStretch(0, 1)
        grid.addWidget(create_label(title, "heading", wrap=True), 0, 0, 1, 2)
        rows: list[tuple[str, list[QWidget]]] = []
        for row, (text, keys) in enumerate(lines, start=1):
            what = create_label(text, wrap=True)
            how = create_label(keys, "strong")
            is_below = how.sizeHint().width() > _KEY_SHARE * (wide - style.px(48))
            how.setWordWrap(is_below)
            what.setAlignment(Qt.AlignmentFlag.AlignTop)
            grid.addWidget(what, 2 * row, 0)
            if is_below:
                grid.addWidget(how, 2 * row + 1, 0, 1, 2)
            else:
                how.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignTop)
                grid.addWidget(how, 2 * row, 1)
            rows.append((f"{title} {text} {keys}".lower(), [what, how]))
        self._cards.append((card, rows))
        return card

    def filter_rows(self, words: str) -> None:
        """Show only the rows that hold all the words."""
        wanted = words.lower().split()
        for card, rows in self._cards:
            count = 0
            for text, widgets in rows:
                fits = all(word in text for word in wanted)
                count += fits
                for widget in widgets:
                    widget.setVisible(fits)
            card.setVisible(count > 0)
        self._flow.invalidate()

    def rows(self) -> tuple[str, ...]:
        """Return what is on screen, one text for each row."""
        return tuple(
            text for _card, rows in self._cards for text, parts in rows if not parts[0].isHidden()
        )


class HelpMenuController(QObject):
    """Opens the dialogs of the Help menu over a window."""

    def __init__(
        self,
        window: QWidget,
        style: DisplayStyle,
        store: SettingsStore,
        banners: BannerStack,
        error_reporter: ErrorReporter,
    ) -> None:
        super().__init__(window)
        self._window = window
        self._style = style
        self._store = store
        self._banners = banners
        self._error_reporter = error_reporter

    @property
    def handlers(self) -> Mapping[str, Callable[[], object]]:
        return {
            "keys": lambda: ShortcutsDialog(self._style, self._window).exec(),
            "copy_details": self.copy_details,
            "messages": self.show_messages,
            "about": lambda: AboutDialog(
                self._style, about_lines(self._store), self._window
            ).exec(),
            "guide": self.show_guide,
        }

    def show_guide(self) -> None:
        folder = guide_folder()
        if folder is None:
            self._banners.show_banner("caution", tr("The user guide is not installed."))
            return
        GuideWindow(self._style, folder, self._window).show()

    def show_messages(self) -> None:
        for former in self._window.findChildren(MessagesDialog):
            former.close()
        MessagesDialog(self._style, self._banners, self._window).show()

    def copy_details(self) -> None:
        report = self._error_reporter.last_report
        if report is None:
            self._banners.show_banner("note", tr("There was no error."))
            return
        QGuiApplication.clipboard().setText(report.details)
        self._banners.show_banner("note", tr("The details of the last error are on the clipboard."))
