"""The first chapter of the review: the maneuvers of all flights, corrected by hand."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path

from PySide6.QtCore import QTimer, Signal
from PySide6.QtGui import QHideEvent, QShowEvent
from PySide6.QtWidgets import QComboBox, QLineEdit, QVBoxLayout, QWidget

from gsapp.flight.maneuvers.detected_maneuver import GRADED_BY_CREW, GRADES, DetectedManeuver, Grade
from gsapp.foundation import GroundStationError
from gsapp.session.review import ManeuverRow, Review, ReviewedFlight
from gsapp.session.review.traces import Traces
from ui.commands import CommandRequirement
from ui.dialogs.form_dialog import FormDialog
from ui.display_style import DisplayStyle
from ui.number_format import count_text
from ui.review.maneuver_editor import ManeuverEditor
from ui.review.maneuver_text import grade_text
from ui.review.maneuvers_panel import ManeuversPanel
from ui.review.review_steps import ReviewContext, ReviewStepPage
from ui.review.reviewed_flights import CatalogWriter, ReviewedFlights
from ui.review.timeline_painter import TimelineSpan
from ui.settings import catalog_path
from ui.translation import tr
from ui.undo import UndoHistory
from ui.window_frame.page_steps import StepStatus


class GradeDialog(FormDialog):
    """A grade from A to D, or the one that the samples give; and a reason."""

    def __init__(
        self,
        style: DisplayStyle,
        name: str,
        maneuver: DetectedManeuver,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(
            tr("Set the grade"),
            tr(
                "Maneuver {name} has grade {grade}. A manual grade stays when the edges "
                "move; unfit (D) excludes it from estimates."
            ).format(name=name, grade=maneuver.grade),
            tr("Grade"),
            style,
            parent,
        )
        self.choice = QComboBox()
        self.choice.setAccessibleName(tr("Grade"))
        for grade, text in GRADES.items():
            self.choice.addItem(f"{grade}  {text.partition(':')[0]}", grade)
        self.choice.addItem(tr("Automatic grade"), "")
        self.choice.setCurrentIndex(list(GRADES).index(maneuver.grade))
        self.reason = QLineEdit(
            "; ".join(maneuver.reasons) if maneuver.graded_by == GRADED_BY_CREW else ""
        )
        self.reason.setAccessibleName(tr("Reason"))
        self.reason.setPlaceholderText(tr("A gust, hands on the sticks …"))
        self.add_row(tr("Grade"), self.choice)
        self.add_row(tr("Reason"), self.reason)
        self.choice.setFocus()
        self.fit_to_content(480)

    @property
    def grade(self) -> Grade | None:
        return self.choice.currentData() or None


_POLL_MS = 1000
"""Milliseconds between looks at what other windows changed."""
_NEW_MANEUVER_SECONDS = 6.0
"""Length of a stretch that is offered where none is marked, s: a doublet and its answer."""


class ManeuversPage(ReviewStepPage):
    """Flights, time line, table; every change is an event of the flight at once."""

    maneuvers_changed = Signal()

    def __init__(self, context: ReviewContext, review: Review) -> None:
        super().__init__(context, tr("Maneuvers"))
        store, selection = context.store, context.selection
        self.review = review
        self.flights = ReviewedFlights(review, store, selection, self)
        self.opening = self.flights.opening
        self.catalog_writer = CatalogWriter(lambda: catalog_path(store.current), self)
        self.editing = ManeuverEditor(self.flights, review, selection, self.catalog_writer, self)
        self.maneuvers_panel = view = ManeuversPanel(context.actions, context.style)
        self.details, self.timeline, self.bar = view.details, view.timeline, view.bar
        self.panel, self.channels, self.table = view.panel, view.channels, view.table
        self.raw_fields = view.raw_fields
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(view)
        self._bind()
        self._poll = QTimer(self)
        self._poll.setInterval(_POLL_MS)
        self._poll.timeout.connect(self.editing.reload)
        self.flights.reopen_last_flights()
        self._refresh()

    def _bind(self) -> None:
        flights, editing, timeline, table = self.flights, self.editing, self.timeline, self.table
        flights.current_flight_changed.connect(self._show_flight)
        flights.opening.opened.connect(self._opened)
        flights.changed.connect(self._flights_changed)
        flights.status_changed.connect(self._show_flights)
        flights.failed.connect(lambda text: self.details.show_message(text, "warning"))
        self._selection.maneuver_changed.connect(self._select)
        editing.changed.connect(self._notify_change)
        editing.message_changed.connect(self.details.show_message)
        self.catalog_writer.failed.connect(
            lambda error: self.details.show_message(
                tr("Not saved in the catalog: {error}").format(error=error), "caution"
            )
        )
        self.panel.flight_selected.connect(
            lambda place: flights.select_flight(self.review.flights[place])
        )
        wanted = self._store.current.review_channels
        self.channels.set_selected_channels(wanted)
        self.channels.selection_changed.connect(self._channels_chosen)
        self.raw_fields.changed.connect(self._show_channels)
        timeline.show_channels(wanted)
        timeline.maneuver_selected.connect(self._pressed)
        timeline.edge_dragged.connect(self._preview_edges)
        timeline.edge_moved.connect(editing.move)
        timeline.drag_cancelled.connect(self._refresh)
        timeline.segment_marked.connect(self.changed)
        timeline.deleted.connect(lambda: editing.remove(()))
        table.maneuver_selected.connect(self._selection.select_maneuver)
        table.opened.connect(self.zoom)
        table.deleted.connect(lambda: editing.remove(table.selected_ids))
        table.renamed.connect(editing.rename)
        table.noted.connect(editing.annotate)
        table.used.connect(editing.set_in_use)

    # Commands

    @property
    def handlers(self) -> Mapping[str, Callable[[], object]]:
        editing, flights, table = self.editing, self.flights, self.table
        edges = {"start_earlier": (-1, 0), "start_later": (1, 0), "end_earlier": (0, -1),
                 "end_later": (0, 1)}  # fmt: skip
        samples = {"start_back": (-1, 0), "start_on": (1, 0), "end_back": (0, -1),
                   "end_on": (0, 1)}  # fmt: skip
        return {
            "review_add_open": flights.add_open_flight,
            "review_add_folder": flights.add_folder,
            "review_add_files": flights.add_files,
            "review_take_out": flights.remove_flight,
            "review_previous_maneuver": lambda: self.step(-1),
            "review_next_maneuver": lambda: self.step(1),
            "review_zoom": self.zoom,
            "review_whole": self.timeline.show_all,
            "review_add_maneuver": self.add,
            "review_remove_maneuver": lambda: editing.remove(table.selected_ids),
            "review_merge": lambda: editing.merge(table.selected_ids),
            "review_rename": lambda: self._type("id"),
            "review_note": lambda: self._type("note"),
            "review_grade": self.grade,
            "review_in_use": self.use,
            **{f"review_{name}": partial(editing.nudge, *by) for name, by in edges.items()},
            **{
                f"review_{name}": partial(editing.nudge_samples, *by)
                for name, by in samples.items()
            },
        }

    @property
    def present(self) -> tuple[CommandRequirement, ...]:
        found: list[CommandRequirement] = ["review_flights"]
        if self.flights.flight is not None:
            found.append("review_flight")
        place, view = self.review.find_maneuver(self._selection.maneuver), self.timeline.view
        if place is not None:
            found.append("review_maneuver")
            if place[1].t_start > view.first or place[1].t_end < view.last:
                found.append("review_part")
        if self.flights.can_add_open_flight:
            found.append("review_open")
        return tuple(found)

    @property
    def state(self) -> StepStatus:
        doing = self.opening.status_text
        if doing:
            return StepStatus(state="unknown", text=tr("opening"), detail=doing)
        rows = self.review.rows()
        if not rows:
            text = tr("no maneuver") if self.review.flights else tr("no flight")
            return StepStatus(state="unknown", text=text)
        used = sum(row.in_use for row in rows)
        text = tr("{used} of {count} used").format(used=used, count=len(rows))
        flights = count_text(len(self.review.flights), "flight")
        return StepStatus(
            state="good" if used else "caution", text=text, detail=f"{flights}: {text}"
        )

    @property
    def undo_history(self) -> UndoHistory | None:
        return None if self.flights.flight is None else self.editing

    def show_restored(self) -> None:
        """Nothing to do: the editor tells what changed."""

    def set_initial_focus(self) -> None:
        known = self.flights.flight is not None
        (self.timeline if known else self.panel.buttons["review_add_folder"]).setFocus()

    def set_open_flight(self, path: Path | None) -> None:
        self.flights.set_open_flight(path)

    # What is looked at

    def _select(self, campaign_id: str) -> None:
        self.details.show_message("")
        self._refresh()
        place = self.review.find_maneuver(campaign_id)
        if place is not None:
            self.timeline.scroll_to(place[1].t_start, place[1].t_end)

    def _pressed(self, name: str) -> None:
        flight = self.flights.flight
        if flight is not None:
            self._selection.select_maneuver(self.review.campaign_id(flight, name))

    def step(self, by: int) -> None:
        ids = [row.id for row in self.review.rows()]
        if ids:
            here = self._selection.maneuver
            place = ids.index(here) + by if here in ids else 0
            self._selection.select_maneuver(ids[min(max(place, 0), len(ids) - 1)])

    def zoom(self) -> None:
        place = self.review.find_maneuver(self._selection.maneuver)
        if place is not None:
            self.timeline.zoom_to(place[1].t_start, place[1].t_end)

    def _channels_chosen(self, channels: Sequence[str]) -> None:
        self._store.change(review_channels=tuple(channels))
        self._show_channels()

    def _show_channels(self) -> None:
        wanted = self._store.current.review_channels
        self.timeline.show_channels((*wanted, *self.raw_fields.shown))

    # Changes

    def _preview_edges(self, name: str, start: float, stop: float) -> None:
        flight = self.flights.flight
        if flight is None:
            return
        try:
            self.details.show_edge_preview(flight.preview_move(name, start, stop))
        except GroundStationError as error:
            self.details.show_message(str(error), "caution")
        else:
            self.details.show_message("")

    def add(self) -> None:
        """Make the marked stretch a maneuver; else one in the middle of what is in sight."""
        view, marked = self.timeline.view, self.timeline.marked_segment
        middle = (view.start + view.stop) / 2.0
        half = min(_NEW_MANEUVER_SECONDS, view.seconds / 2.0) / 2.0
        start, stop = marked or (middle - half, middle + half)
        self.timeline.mark_segment(None)
        self.editing.add(start, stop)

    def _type(self, column: str) -> None:
        self.maneuvers_panel.show_table()
        self.table.edit_cell(self._selection.maneuver, column)

    def use(self) -> None:
        row = self.editing.row
        if row is not None:
            self.editing.set_in_use(row.id, not row.in_use)

    def grade(self) -> None:
        name = self._selection.maneuver
        place = self.review.find_maneuver(name)
        if place is None:
            return
        flight, maneuver = place
        dialog = GradeDialog(self.display_style, name, maneuver, self)
        if dialog.exec():
            # Another may be chosen by now: other windows go on changing the flight meanwhile.
            self.editing.regrade(flight, maneuver.id, dialog.grade, dialog.reason.text())

    # Showing

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        self.editing.reload()
        self._poll.start()

    def hideEvent(self, event: QHideEvent) -> None:
        super().hideEvent(event)
        self._poll.stop()

    def _show_flight(self, flight: ReviewedFlight | None) -> None:
        traces = None if flight is None else Traces(flight.flight)
        self.channels.set_available_channels(() if traces is None else traces.channels)
        self.raw_fields.show_flight(None if flight is None else flight.path, traces)
        self._show_channels()
        self.timeline.show_flight(traces)
        self._refresh()

    def _opened(self, flight: ReviewedFlight) -> None:
        """Keep changes that never reached the catalog: the window was closed too soon."""
        if flight.changes:
            self.catalog_writer.store(flight)

    def _flights_changed(self) -> None:
        if self.flights.flight is not None and self.panel.has_keyboard:
            self.set_initial_focus()
        self._notify_change()

    def _notify_change(self) -> None:
        self._refresh()
        self.maneuvers_changed.emit()

    def _show_flights(self) -> None:
        flights, here = self.review.flights, self.flights.flight
        place = flights.index(here) if here in flights else 0
        self.panel.show_flights(self.review, place, self.opening.status_text)
        self.panel.set_open_flight_available(self.flights.can_add_open_flight)
        self.changed.emit()

    def _hint(self) -> str:
        here = self.flights.flight
        if here is None:
            return tr(
                "Add a flight folder or file. Its maneuvers are detected and graded; correct "
                "them on the time line before estimating."
            )
        found = (
            ""
            if here.maneuvers
            else (
                tr(
                    "No maneuver found: no fast input that returned to trim with a response in the "
                    "air. "
                )
            )
        )
        return tr("{found}Drag across the charts and press Add to create one.").format(found=found)

    def _refresh(self) -> None:
        rows, chosen, here = self.review.rows(), self._selection.maneuver, self.flights.flight
        row = next((one for one in rows if one.id == chosen), None)
        self.table.show_rows(rows)
        self.table.select_maneuver(chosen)
        known = here is not None
        self.maneuvers_panel.set_flight_known(known=known)
        self.details.set_empty_title(
            tr("No maneuver is chosen") if known else tr("No flight is under review")
        )
        self.details.show_row(row, self._hint())
        number = self.review.flights.index(here) + 1 if here in self.review.flights else 0
        spans = [_span(one) for one in rows if one.flight_number == number]
        self.timeline.show_spans(spans, row.maneuver.id if row is not None else "")
        self.bar.set_in_use(row.in_use if row is not None else None)
        self._show_flights()


def _span(row: ManeuverRow) -> TimelineSpan:
    one = row.maneuver
    return TimelineSpan(
        id=one.id,
        start=one.t_start,
        stop=one.t_end,
        label=f"{one.id} {grade_text(one)}",
        grade=one.grade,
        used=row.in_use,
        t_input=one.t_input,
        t_input_end=one.t_input_end,
    )
