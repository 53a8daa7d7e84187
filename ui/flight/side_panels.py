"""Panels beside the charts: values at the cursors, marks, alarms, messages of the aircraft."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QPushButton, QStackedLayout, QVBoxLayout, QWidget

from ui.commands import shortcut_text
from ui.display_style import DisplayStyle
from ui.translation import QT_TR_NOOP, tr
from ui.widgets.flow_layout import FlowLayout, arrange
from ui.widgets.labels import create_label, plain_tooltip
from ui.widgets.row_model import TableRow, TableRowModel
from ui.widgets.table_view import WIDEST_TIME_TEXT, TableRowView

_NO_MARK_TEXT = QT_TR_NOOP("Choose a mark first")


class ListPanel(QWidget):
    """A table with a sentence in its place while it is empty, and a row of buttons below.

    `empty`: what is said while there is nothing.
    """

    def __init__(self, view: TableRowView, style: DisplayStyle, empty: str) -> None:
        super().__init__()
        self._style = style
        self.view = view
        # It has the focus itself while the table is hidden.
        self.setAccessibleName(view.accessibleName())
        self.setAccessibleDescription(empty)
        column = arrange(QVBoxLayout(self), 0)
        self.head = QVBoxLayout()
        column.addLayout(self.head)
        holder = QWidget()
        self._pile = QStackedLayout(holder)
        self._empty = create_label(empty, "muted", wrap=True)
        self._empty.setAlignment(Qt.AlignmentFlag.AlignTop)
        self._empty.setContentsMargins(16, 16, 16, 16)
        self._pile.addWidget(self._empty)
        self._pile.addWidget(view)
        column.addWidget(holder, 1)
        foot = QWidget()
        self._foot = FlowLayout(foot, spacing=4)
        self._foot.setContentsMargins(8, 8, 8, 8)
        column.addWidget(foot)
        self._foot_widget = foot
        foot.hide()
        self._of_row: list[tuple[QPushButton, str, str]] = []
        view.selectionModel().currentChanged.connect(lambda *_: self._enable())
        view.model().modelReset.connect(self._enable)

    def add_button(self, text: str, name: str, why: str = "") -> QPushButton:
        """Add a button below the table, also to the menu of its rows.

        `text`, `name`: on it, and what it does as a tool tip. `why`: why it is gray while no row
        is chosen; empty for a button that is about all rows.
        """
        button = QPushButton(text)
        button.setAccessibleName(name)
        button.setToolTip(plain_tooltip(name))
        self._foot.addWidget(button)
        self._foot_widget.show()
        self.view.menu.add_command(text, button.click, button)
        if why:
            self._of_row.append((button, name, why))
            self._enable()
        return button

    def _enable(self) -> None:
        chosen = self.view.current_key() is not None
        for button, name, why in self._of_row:
            button.setEnabled(chosen)
            button.setToolTip(plain_tooltip(name if chosen else why))

    def show_rows(self, lines: Sequence[TableRow]) -> None:
        """Show the lines, or the sentence if there are none."""
        self.view.row_model.set_rows(lines)
        self._pile.setCurrentIndex(1 if lines else 0)
        # The stub lacks None, which Qt takes.
        self.setFocusProxy(self.view if lines else None)  # type: ignore[arg-type]

    def set_empty_text(self, text: str) -> None:
        self._empty.setText(text)
        self.setAccessibleDescription(text)


class ValuesPanel(ListPanel):
    """All charted channels at the cursor and at A and B, with the difference."""

    def __init__(self, style: DisplayStyle) -> None:
        model = TableRowModel(
            style, ("", tr("Cursor"), "A", "B", tr("B − A")), right=frozenset({1, 2, 3, 4})
        )
        view = TableRowView(
            model,
            style,
            tr("Values at the cursors"),
            stretch=0,
            widths={1: 62, 2: 62, 3: 62, 4: 62},
            wrap=False,
        )
        super().__init__(
            view, style, tr("No cursor. Point at the charts or press C; A and B set two times.")
        )
        self.times = create_label("")
        self.times.setProperty("role", "label")
        self.times.setContentsMargins(8, 8, 8, 4)
        self.times.setWordWrap(True)
        self.head.addWidget(self.times)

    def show_columns(self, cursors: Iterable[str]) -> None:
        """Show the columns of the cursors that are set."""
        there = set(cursors)
        for column, needed in enumerate(({"cursor"}, {"a"}, {"b"}, {"a", "b"}), start=1):
            self.view.setColumnHidden(column, not needed <= there)

    def show_times(self, text: str) -> None:
        self.times.setText(text)
        self.times.setVisible(bool(text))


class MarksPanel(ListPanel):
    """Marks and notes; Enter jumps, the text is edited in place."""

    jump_requested = Signal(object)  # Key of a mark to go to.
    edited = Signal(object, str)  # Key of a mark and its new text.
    deleted = Signal(object)  # Key of a mark to take away; it can be brought back.
    edit_ended = Signal()  # A text was typed, or left as it was.

    def __init__(self, style: DisplayStyle) -> None:
        model = TableRowModel(
            style, (tr("Time"), tr("Mark")), right=frozenset({0}), editable=frozenset({1})
        )
        view = TableRowView(
            model, style, tr("Marks and notes"), stretch=1, widths={0: WIDEST_TIME_TEXT}
        )
        super().__init__(
            view, style, tr("No marks yet. M marks this moment, N also asks for a few words.")
        )
        model.edited.connect(self.edited)
        view.opened.connect(self.jump_requested)
        view.itemDelegate().closeEditor.connect(lambda *_: self.edit_ended.emit())
        go = self.add_button(tr("Go to"), tr("Go to the selected mark (Enter)"), tr(_NO_MARK_TEXT))
        go.clicked.connect(lambda: self._with_current(self.jump_requested.emit))
        edit = self.add_button(
            tr("Edit text"), tr("Edit the text of the selected mark"), tr(_NO_MARK_TEXT)
        )
        edit.clicked.connect(lambda: self._with_current(self.begin_edit))
        tip = tr("Delete the selected mark (Delete); {keys} restores it").format(
            keys=shortcut_text("Ctrl+Z")
        )
        delete = self.add_button(tr("Delete"), tip, tr(_NO_MARK_TEXT))
        delete.clicked.connect(lambda: self._with_current(self.deleted.emit))
        view.deleted.connect(self.deleted)

    def _with_current(self, act: Callable[[object], None]) -> None:
        key = self.view.current_key()
        if key is not None:
            act(key)

    def begin_edit(self, key: object) -> None:
        """Let the user type the text of a mark."""
        self.view.edit_row(key, 1)


class AlarmsPanel(ListPanel):
    """The log of all alarms, newest first; a press on a title sorts."""

    acknowledged = Signal()  # The user has seen them.
    jump_requested = Signal(object)  # Key of an alarm to go to.

    def __init__(self, style: DisplayStyle) -> None:
        titles = (tr("Start"), tr("Alarm"), tr("Value"), tr("Duration"), tr("Ack."))
        model = TableRowModel(style, titles, right=frozenset({2, 3}))
        widths = {0: WIDEST_TIME_TEXT, 2: "< 100.0 °", 3: tr("Duration"), 4: tr("crew, Alarms")}
        view = TableRowView(
            model, style, tr("Alarms"), stretch=1, widths=widths, least=140, sortable=True
        )
        super().__init__(view, style, tr("No alarms."))
        # To find them ahead takes a whole pass through the cues, minutes for a flight of an hour.
        self.cues_note = create_label(
            tr("In a replay, cue alarms appear as they are reached."), "hint", wrap=True
        )
        self.cues_note.setContentsMargins(8, 8, 8, 4)
        self.cues_note.hide()
        self.head.addWidget(self.cues_note)
        view.opened.connect(self.jump_requested)
        self._acknowledge = self.add_button(tr("Acknowledge (K)"), "")
        self._acknowledge.clicked.connect(self.acknowledged)
        self.set_unacknowledged_count(0)
        go = self.add_button(
            tr("Go to"), tr("Go to the selected alarm (Enter)"), tr("Choose an alarm first")
        )
        go.clicked.connect(self._go)

    def set_unacknowledged_count(self, count: int) -> None:
        """Gray the button where no alarm waits to be acknowledged."""
        self._acknowledge.setEnabled(count > 0)
        self._acknowledge.setToolTip(
            tr("Acknowledge the alarms (K)") if count else tr("No alarm to acknowledge")
        )

    def _go(self) -> None:
        key = self.view.current_key()
        if key is not None:
            self.jump_requested.emit(key)


class MessagesPanel(ListPanel):
    """What the aircraft said, newest first."""

    jump_requested = Signal(object)

    def __init__(self, style: DisplayStyle) -> None:
        model = TableRowModel(style, (tr("Time"), tr("Message")), right=frozenset({0}))
        view = TableRowView(
            model, style, tr("Status messages"), stretch=1, widths={0: WIDEST_TIME_TEXT}
        )
        super().__init__(view, style, tr("No status messages received."))
        view.opened.connect(self.jump_requested)
        view.menu.add_command(tr("Go to"), lambda: self.jump_requested.emit(view.current_key()))
