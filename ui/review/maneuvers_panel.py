"""The parts of the page of maneuvers beside time line and table, and how it is laid out."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QAction
from PySide6.QtWidgets import (
    QCheckBox,
    QPushButton,
    QSizePolicy,
    QVBoxLayout,
    QWidget,
)

from gsapp.flight.maneuvers.detected_maneuver import DetectedManeuver
from gsapp.quantities import channel, trace_color
from gsapp.session.review.review import ManeuverRow, Review
from gsapp.session.review.reviewed_flight import ReviewedFlight
from ui.commands import action_hint
from ui.dialogs.form_dialog import FieldMessage, repolish
from ui.display_style import DisplayStyle
from ui.number_format import count_text, join_sentences, symbol_text
from ui.review.maneuver_text import (
    GRADE_STATES,
    condition_text,
    grade_counts_text,
    grade_text,
    reasons_text,
    remarks_text,
    times_text,
    title_text,
)
from ui.review.maneuvers_table import ManeuversTable
from ui.review.raw_field_picker import RawFieldPicker
from ui.review.timeline import Timeline
from ui.review.timeline_painter import TIMELINE_CHANNELS
from ui.translation import QT_TR_NOOP, tr
from ui.widgets.flow_layout import FlowLayout
from ui.widgets.labels import create_label, plain_tooltip
from ui.widgets.layout_widgets import ScrollingPage, StackingColumns, add_widgets, create_button_row
from ui.widgets.row_model import TableRow
from ui.widgets.table_view import BoxedListView


class ChannelToggles(QWidget):
    """Toggles that break into rows where the window is narrow."""

    selection_changed = Signal(object)
    """The channels to be shown, whether measured in this flight or not."""

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__()
        self._style = style
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(style.px(6))
        column.addWidget(create_label(tr("Channels"), "heading"))
        holder = QWidget()
        flow = FlowLayout(holder, spacing=style.px(10))
        self.boxes: dict[str, QCheckBox] = {}
        for name in TIMELINE_CHANNELS:
            spec = channel(name)
            box = QCheckBox(symbol_text(spec.symbol))
            box.setAccessibleName(tr("Show {title}").format(title=spec.title.lower()))
            box.setToolTip(spec.title)
            box.toggled.connect(self._toggled)
            flow.addWidget(box)
            self.boxes[name] = box
        column.addWidget(holder)
        style.changed.connect(self._restyle)
        self._restyle()

    def _restyle(self) -> None:
        for name, box in self.boxes.items():
            color = self._style.theme.trace(trace_color(name))
            box.setStyleSheet(f"QCheckBox {{ color: {color}; font-weight: 600; }}")

    def set_selected_channels(self, channels: Collection[str]) -> None:
        """Show which channels are wanted; says nothing."""
        for name, box in self.boxes.items():
            box.blockSignals(True)
            box.setChecked(name in channels)
            box.blockSignals(False)

    def set_available_channels(self, channels: Collection[str]) -> None:
        for name, box in self.boxes.items():
            box.setVisible(name in channels)

    def _toggled(self) -> None:
        self.selection_changed.emit(
            tuple(name for name, box in self.boxes.items() if box.isChecked())
        )


class ManeuverDetails(QWidget):
    """Title, grade with its reasons, remarks; while an edge is dragged what it would be."""

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__()
        self._style = style
        self._row: ManeuverRow | None = None
        self._hint = ""
        self._nothing = tr("No maneuver is chosen")
        self.setAccessibleName(tr("Selected maneuver"))
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        self._column = column
        holder = QWidget()
        self._line = FlowLayout(holder, spacing=style.px(12))
        policy = QSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Minimum)
        policy.setHeightForWidth(True)
        holder.setSizePolicy(policy)
        self.title = create_label("", "heading")
        self.grade = create_label("", "heading")
        self.times = create_label("", "number")
        for one in (self.title, self.grade, self.times):
            self._line.addWidget(one)
        column.addWidget(holder)
        self.reasons = create_label("", wrap=True, remarks_in=style)
        self.reasons.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        column.addWidget(self.reasons)
        self.remarks = create_label("", "muted", wrap=True, remarks_in=style)
        column.addWidget(self.remarks)
        self.message = FieldMessage()
        column.addWidget(self.message)
        self.message.hide()
        style.changed.connect(self._restyle)
        self._restyle()

    def _restyle(self) -> None:
        self._column.setSpacing(self._style.px(2))
        self._line.setSpacing(self._style.px(12))
        self.show_row(self._row, self._hint)

    def show_row(self, row: ManeuverRow | None, hint: str = "") -> None:
        """Show a maneuver as it stands; None where none is looked at, with what to do then."""
        self._row, self._hint = row, hint
        if row is None:
            self.title.setText(self._nothing)
            for empty in (self.grade, self.times, self.remarks):
                empty.setText("")
            self.reasons.setText(hint)
        else:
            self._show(row.id, row.maneuver)
            self.remarks.setText(remarks_text(row))
        self.remarks.setVisible(bool(self.remarks.text()))

    def set_empty_title(self, title: str) -> None:
        self._nothing = title

    def show_edge_preview(self, maneuver: DetectedManeuver) -> None:
        self._show(maneuver.id if self._row is None else self._row.id, maneuver)

    def _show(self, name: str, maneuver: DetectedManeuver) -> None:
        self.title.setText(title_text(name, maneuver))
        self.grade.setText(tr("Grade {grade}").format(grade=grade_text(maneuver)))
        state = GRADE_STATES[maneuver.grade]
        if self.grade.property("state") != state:
            self.grade.setProperty("state", state)
            repolish(self.grade)
        self.times.setText(times_text(maneuver))
        condition = condition_text(maneuver, self._style.units)
        self.reasons.setText(f"{reasons_text(maneuver)} {condition}".strip())
        text = f"{self.title.text()}, {self.grade.text()}, {self.times.text()}. "
        self.setAccessibleDescription(text + self.reasons.text())

    def show_message(self, text: str, state: str = "") -> None:
        self.message.set_message(text, state)
        self.message.setVisible(bool(text))


_MAX_REMARKS = 3
"""Remarks on a flight in sight; the others are in the tool tip."""


class FlightsPanel(QWidget):
    """The flights with their maneuvers and grades, what is to be said of the one chosen."""

    flight_selected = Signal(int)

    def __init__(self, actions: Mapping[str, QAction], style: DisplayStyle) -> None:
        super().__init__()
        self._style = style
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        self._column = column
        column.addWidget(create_label(tr("Flights"), "heading"))
        self.flights = BoxedListView(style, tr("Flights under review"))
        self.flights.row_changed.connect(self.flight_selected.emit)
        column.addWidget(self.flights)
        self.status = create_label("", "muted", wrap=True, remarks_in=style)
        column.addWidget(self.status)
        self.buttons: dict[str, QPushButton] = {}
        names = ("review_add_open", "review_add_folder", "review_add_files", "review_take_out",
                 "review_trial")  # fmt: skip
        for name in names:
            self.buttons[name] = create_command_button(actions[name])
        column.addWidget(create_button_row(style, *self.buttons.values()))
        column.addStretch(1)
        self.flights.deleted.connect(lambda _key: actions["review_take_out"].trigger())
        style.changed.connect(self._fit)
        self._fit()

    def _fit(self) -> None:
        self._column.setSpacing(self._style.px(6))

    def show_flights(self, review: Review, place: int, doing: str) -> None:
        """Show the flights, one of them chosen, and what is being opened."""
        flights = review.flights
        rows = []
        for row, flight in enumerate(flights):
            count = count_text(len(flight.maneuvers), "maneuver")
            text = f"{row + 1}  {review.title(flight)}   {count}"
            detail = f"{flight.path}\n{count}: {grade_counts_text(flight.maneuvers)}"
            rows.append(TableRow(key=row, cells=(text,), detail=detail))
        self.flights.blockSignals(True)
        self.flights.show_rows(rows)
        if self.flights.current_key() != place:
            self.flights.select_row(place)
        self.flights.blockSignals(False)
        self.flights.setVisible(bool(flights))
        self.buttons["review_trial"].setVisible(not flights)
        if doing:
            self._set_status(doing)
        elif not flights:
            self._set_status(
                tr("No flight yet. Add one: a flight folder, or a file (tlog, bin, ulg, csv, mat).")
            )
        else:
            self._show_remarks(flights[place])

    def _show_remarks(self, flight: ReviewedFlight) -> None:
        """Tell grades and the latest remarks: what was changed by hand is said last."""
        grades = grade_counts_text(flight.maneuvers)
        said = flight.remarks[::-1]
        more = max(len(said) - _MAX_REMARKS, 0)
        lines = (
            tr("grades: {grades}").format(grades=grades) if grades else "",
            *said[:_MAX_REMARKS],
            tr("{remarks} more").format(remarks=count_text(more, "remark")) if more else "",
        )
        self._set_status(join_sentences(lines), flight.remarks)

    def _set_status(self, text: str, remarks: Sequence[str] = ()) -> None:
        self.status.setText(text)
        self.status.setToolTip(plain_tooltip("\n".join(remarks)))
        self.status.setAccessibleDescription(join_sentences(remarks))

    def set_open_flight_available(self, offered: bool) -> None:
        self.buttons["review_add_open"].setVisible(offered)

    @property
    def has_keyboard(self) -> bool:
        return any(button.hasFocus() for button in self.buttons.values())


def create_command_button(action: QAction, *, quiet: bool = False) -> QPushButton:
    """Return a button that does what a command does, gray when the command is."""
    text = action.text()
    button = QPushButton(text)
    button.setAccessibleName(text.rstrip("…"))
    if quiet:
        button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
    button.clicked.connect(action.trigger)

    def follow() -> None:
        button.setEnabled(action.isEnabled())
        button.setToolTip(action_hint(action))

    action.changed.connect(follow)
    follow()
    return button


_BUTTONS = (
    ("review_zoom", QT_TR_NOOP("Zoom")),
    ("review_add_maneuver", QT_TR_NOOP("Add")),
    ("review_remove_maneuver", QT_TR_NOOP("Remove")),
    ("review_merge", QT_TR_NOOP("Merge")),
    ("review_rename", QT_TR_NOOP("Rename")),
    ("review_note", QT_TR_NOOP("Note")),
    ("review_grade", QT_TR_NOOP("Grade…")),
)


class ManeuverToolbar(QWidget):
    """Buttons of the commands, and whether the maneuver takes part in estimates."""

    def __init__(self, actions: Mapping[str, QAction], style: DisplayStyle) -> None:
        super().__init__()
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        self.use = QCheckBox(tr("Use in the estimate"))
        self._in_use = actions["review_in_use"]
        self.use.clicked.connect(actions["review_in_use"].trigger)
        self.buttons = {}
        for name, text in _BUTTONS:
            button = create_command_button(actions[name], quiet=True)
            button.setText(tr(text))
            self.buttons[name] = button
        self._style = style
        column.addWidget(create_button_row(style, *self.buttons.values(), self.use))

        style.changed.connect(self._restyle)
        self._restyle()

    def _restyle(self) -> None:
        # As high as the buttons beside it.
        self.use.setMinimumHeight(self._style.px(30))

    def set_in_use(self, used: bool | None) -> None:
        self.use.setEnabled(used is not None)
        known = used is not None
        self.use.setToolTip(self._in_use.text() if known else tr("Choose a maneuver first"))
        self.use.setChecked(bool(used))


_MENU_COMMANDS = (
    "review_zoom", "review_in_use", "review_grade", "review_rename", "review_note", "review_merge",
    "review_remove_maneuver",
)  # fmt: skip
"""Commands in the menu of a maneuver."""


class ManeuversPanel(ScrollingPage):
    """All parts of the page; it scrolls where the window is small for its scale."""

    def __init__(self, actions: Mapping[str, QAction], style: DisplayStyle) -> None:
        super().__init__()
        self._style = style
        self.details = ManeuverDetails(style)
        self.timeline = Timeline(style)
        self.bar = ManeuverToolbar(actions, style)
        self.panel = FlightsPanel(actions, style)
        self.channels = ChannelToggles(style)
        self.raw_fields = RawFieldPicker(style)
        self.table = ManeuversTable(style, [actions[name] for name in _MENU_COMMANDS])
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAsNeeded)
        # What one works on stands first, also where the window is narrow.
        pair = StackingColumns(style, (7, 2))
        pair.left.addWidget(self.details)
        pair.left.addWidget(self.timeline, 1)
        pair.left.addWidget(self.bar)
        add_widgets(pair.right, self.panel, self.channels, self.raw_fields)
        pair.right.addStretch(1)
        self.column.addWidget(pair, 3)
        self.column.addWidget(self.table, 1)
        self._rest = QWidget()
        pair.left.addWidget(self._rest, 1)
        style.changed.connect(self._restyle)
        self._restyle()

    def _restyle(self) -> None:
        px = self._style.px
        self.column.setContentsMargins(px(16), px(10), px(16), px(10))
        self.column.setSpacing(px(8))

    def set_flight_known(self, *, known: bool) -> None:
        """Show the parts that work on a flight, where one is known: empty ones say nothing."""
        for part in (self.timeline, self.bar, self.channels, self.table):
            part.setVisible(known)
        self._rest.setVisible(not known)

    def show_table(self) -> None:
        bar = self.verticalScrollBar()
        bar.setValue(bar.maximum())
