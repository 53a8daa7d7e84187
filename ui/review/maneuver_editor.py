"""What is done to maneuvers on the first page of the review; each change can be undone."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from PySide6.QtCore import QObject, QTimer, Signal

from gsapp.flight.maneuvers.detected_maneuver import Grade
from gsapp.foundation import GroundStationError
from gsapp.session.review import ManeuverRow, Review, ReviewedFlight
from ui.review.review_steps import ReviewSelection
from ui.review.reviewed_flights import CatalogWriter, ReviewedFlights
from ui.translation import tr

NUDGE_SECONDS = 0.1
"""Seconds that an edge moves by with one key; with the other it is a sample."""


class ManeuverEditor(QObject):
    """Changes the maneuvers of the flight on screen."""

    changed = Signal()
    message_changed = Signal(str, str)
    """What came of the last change, and its state; empty for nothing worth saying."""

    def __init__(
        self,
        flights: ReviewedFlights,
        review: Review,
        selection: ReviewSelection,
        catalog_writer: CatalogWriter,
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self._flights = flights
        self._review = review
        self._selection = selection
        self._catalog_writer = catalog_writer

    @property
    def row(self) -> ManeuverRow | None:
        chosen = self._selection.maneuver
        return next((row for row in self._review.rows() if row.id == chosen), None)

    def _edit(
        self,
        change: Callable[[ReviewedFlight], str | None],
        flight: ReviewedFlight | None = None,
    ) -> None:
        """Do something to a flight, by default the one on screen.

        What cannot be is said, and changes nothing. A text that the change returns is the id of
        the maneuver to be looked at.
        """
        flight = flight or self._flights.flight
        if flight is None:
            return
        at = self._current_time()
        try:
            name = change(flight)
        except GroundStationError as error:
            self.message_changed.emit(str(error), "warning")
            flight.poll()
        else:
            self.message_changed.emit("", "")
            self._catalog_writer.store(flight)
            if name:
                self._selection.select_maneuver(self._review.campaign_id(flight, name))
        self._select_nearest(at)

    def reload(self) -> None:
        at = self._current_time()
        try:
            changed = self._review.poll()
        except GroundStationError as error:
            self.message_changed.emit(str(error), "warning")
            return
        if changed:
            self._select_nearest(at)

    def _current_time(self) -> float:
        """Return where the eye is, s, should the chosen maneuver be gone afterwards."""
        row = self.row
        return row.maneuver.t_start if row is not None else 0.0

    def _select_nearest(self, at: float) -> None:
        """Look at what stands; a maneuver that is gone gives its place to the one next to it."""
        flight = self._flights.flight
        if flight is not None and self._review.find_maneuver(self._selection.maneuver) is None:
            near = min(flight.maneuvers, key=lambda one: abs(one.t_start - at), default=None)
            name = "" if near is None else self._review.campaign_id(flight, near.id)
            self._selection.select_maneuver(name)
        self.changed.emit()

    # Edges

    def move(self, name: str, start: float, stop: float) -> None:
        """Move the edges of a maneuver of the flight on screen, s."""
        self._edit(lambda flight: flight.move(name, start, stop))

    def nudge(self, start: int, stop: int) -> None:
        """Move the edges of the chosen maneuver by so many tenths of a second."""
        self._nudge(start * NUDGE_SECONDS, stop * NUDGE_SECONDS)

    def nudge_samples(self, start: int, stop: int) -> None:
        """Move the edges of the chosen maneuver by so many samples."""
        if self._flights.flight is not None:
            step = self._flights.flight.sample_period
            self._nudge(start * step, stop * step)

    def _nudge(self, start: float, stop: float) -> None:
        row = self.row
        if row is not None:
            one = row.maneuver
            self.move(one.id, one.t_start + start, one.t_end + stop)

    # The list

    def add(self, start: float, stop: float) -> None:
        """Make a stretch (s) a maneuver."""
        self._edit(lambda flight: flight.add(start, stop))

    def _target_ids(self, ids: Sequence[str]) -> tuple[str, ...]:
        """Return the ids within the flight on screen that a change is meant for.

        Those picked in the table, if the chosen maneuver is one of them; else that one alone.
        """
        row = self.row
        if row is None:
            return ()
        if row.id not in ids:
            return (row.maneuver.id,)
        return tuple(
            one.maneuver.id
            for one in self._review.rows()
            if one.id in ids and one.flight_number == row.flight_number
        )

    def remove(self, ids: Sequence[str]) -> None:
        """Take out the maneuvers picked, as one change."""
        picked = self._target_ids(ids)
        if picked:
            self._edit(lambda flight: flight.remove(*picked))

    def merge(self, ids: Sequence[str]) -> None:
        """Merge the maneuvers picked; one alone with the next of its flight."""
        picked, flight = self._target_ids(ids), self._flights.flight
        if flight is None or not picked:
            return
        if len(picked) == 1:
            names = [one.id for one in flight.maneuvers]
            index = names.index(picked[0])
            picked = tuple(names[index : index + 2])
        self._edit(lambda flight: flight.merge(picked))

    # What people say of one

    def rename(self, campaign_id: str, new: str) -> None:
        self._edit_later(campaign_id, lambda flight, name: flight.rename(name, new))

    def annotate(self, campaign_id: str, note: str) -> None:
        self._edit_later(campaign_id, lambda flight, name: flight.annotate(name, note))

    def _edit_later(
        self, campaign_id: str, change: Callable[[ReviewedFlight, str], str | None]
    ) -> None:
        place = self._review.find_maneuver(campaign_id)
        if place is None:
            return
        flight, maneuver = place
        # When the editor of the cell has closed: the rows may be others then.
        QTimer.singleShot(
            0, self, lambda: self._edit(lambda flight: change(flight, maneuver.id), flight)
        )

    def regrade(self, flight: ReviewedFlight, name: str, grade: Grade | None, reason: str) -> None:
        self._edit(lambda flight: flight.set_grade(name, grade, reason), flight)

    def set_in_use(self, campaign_id: str, wanted: bool) -> None:
        self._edit_later(campaign_id, lambda flight, name: flight.set_in_use(name, wanted))

    # Undo: the file of the flight keeps the changes

    def canUndo(self) -> bool:
        return self._flights.flight is not None and self._flights.flight.can_undo

    def canRedo(self) -> bool:
        return self._flights.flight is not None and self._flights.flight.can_redo

    def undoText(self) -> str:
        return "" if self._flights.flight is None else self._flights.flight.undo_text

    def redoText(self) -> str:
        return "" if self._flights.flight is None else self._flights.flight.redo_text

    def undo(self) -> None:
        self._restore(tr("Undone"), lambda flight: flight.undo())

    def redo(self) -> None:
        self._restore(tr("Redone"), lambda flight: flight.redo())

    def _restore(self, what: str, act: Callable[[ReviewedFlight], str]) -> None:
        text = ""

        def change(flight: ReviewedFlight) -> None:
            nonlocal text
            text = act(flight)

        self._edit(change)
        if text:
            self.message_changed.emit(f"{what}: {text}.", "")
