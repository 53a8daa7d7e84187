"""All keys, from the table of commands."""

from __future__ import annotations

from PySide6.QtCore import QSize, Qt
from PySide6.QtWidgets import (
    QDialogButtonBox,
    QFrame,
    QGridLayout,
    QLineEdit,
    QScrollArea,
    QVBoxLayout,
    QWidget,
)

from ui.commands import COMMANDS, shortcut_text
from ui.dialogs.form_dialog import SelfDeletingDialog
from ui.display_style import DisplayStyle
from ui.translation import QT_TR_NOOP, tr
from ui.widgets.flow_layout import FlowLayout
from ui.widgets.labels import create_label

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


class ShortcutsDialog(SelfDeletingDialog):
    """Every key of the window, to be searched."""

    def __init__(self, look: DisplayStyle, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWindowTitle(tr("All keys"))
        room = self.screen().availableSize() - QSize(32, 64)
        self.resize(QSize(look.px(880), look.px(640)).boundedTo(room))
        column = QVBoxLayout(self)
        column.setContentsMargins(look.px(24), look.px(16), look.px(24), look.px(16))
        column.setSpacing(look.px(8))
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
        self._flow = FlowLayout(body, spacing=look.px(16))
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
            self._flow.addWidget(self._card(menu, lines, look))
        mouse = [(tr(what), tr(how)) for how, what in _MOUSE_ACTIONS]
        self._flow.addWidget(self._card(tr("With the mouse"), mouse, look))
        area.setWidget(body)
        column.addWidget(area, 1)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        buttons.rejected.connect(self.reject)
        column.addWidget(buttons)
        self.search.textChanged.connect(self.filter_rows)
        self.search.setFocus()

    def _card(self, title: str, lines: list[tuple[str, str]], look: DisplayStyle) -> QFrame:
        card = QFrame()
        card.setObjectName("card")
        card.setFixedWidth(min(look.px(392), self.width() - look.px(80)))
        grid = QGridLayout(card)
        grid.setContentsMargins(look.px(16), look.px(12), look.px(16), look.px(12))
        grid.setVerticalSpacing(look.px(4))
        grid.setHorizontalSpacing(look.px(16))
        grid.setColumnStretch(0, 1)
        grid.addWidget(create_label(title, "heading"), 0, 0, 1, 2)
        rows: list[tuple[str, list[QWidget]]] = []
        for row, (text, keys) in enumerate(lines, start=1):
            what, how = create_label(text, wrap=True), create_label(keys, "strong")
            what.setAlignment(Qt.AlignmentFlag.AlignTop)
            how.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignTop)
            grid.addWidget(what, row, 0)
            grid.addWidget(how, row, 1)
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
