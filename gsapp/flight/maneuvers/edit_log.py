"""Changes of a flight's maneuvers in its events file: made, followed, and applied everywhere."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Final

from gsapp.flight.events import Event, EventLog
from gsapp.flight.maneuvers.detected_maneuver import DetectedManeuver
from gsapp.flight.maneuvers.maneuver_list import AssessFunction, EditableManeuverList, ManeuverEdit
from gsapp.flight.maneuvers.settings import DETECTION
from gsapp.foundation import FlightError, UnknownNameError


def localize_edit(book: EditableManeuverList, edit: ManeuverEdit) -> ManeuverEdit:
    """Return a change with the ids that its maneuvers have in a book.

    One that is not found any more stays as it was put in; there is nothing to take out then.
    `ManeuverEdit.remark` tells what is otherwise.

    Raises
    ------
    UnknownNameError
        If a change before it has taken the maneuver out.
    """
    if len(edit.segments) != len(edit.removed):
        return edit
    standing = {maneuver.id: maneuver for maneuver in book.maneuvers}
    known = (*book.detected, *(one for former in book.edits for one in former.added))
    names: dict[str, str] = {}
    stretches: list[tuple[float, float]] = []
    remarks: list[str] = []
    for name, stretch in zip(edit.removed, edit.segments, strict=True):
        now = _overlapping_maneuver_id(standing.values(), name, stretch)
        if now is not None:
            names[name] = now
            stretches.append(stretch)
            del standing[now]
        elif _overlapping_maneuver_id(known, name, stretch) is not None:
            raise UnknownNameError(
                f"'{edit.text}' changes the maneuver '{name}', which no longer exists"
            )
        else:
            remarks.append(
                f"maneuver {name} at {stretch[0]:.1f} s, changed by hand ('{edit.text}'), is no "
                f"longer detected{'; the edited version is kept' if edit.added else ''}"
            )
    added = []
    for maneuver in edit.added:
        wanted = names.get(maneuver.id, maneuver.id)
        called = wanted if wanted not in standing else book.unused_id(standing)
        if called != maneuver.id:
            remarks.append(
                f"maneuver {maneuver.id} at {maneuver.t_start:.1f} s, changed by hand "
                f"('{edit.text}'), is now called {called}: detection now gives different "
                "maneuvers"
            )
        standing[called] = maneuver
        added.append(replace(maneuver, id=called))
    return replace(
        edit,
        removed=tuple(names.values()),
        segments=tuple(stretches),
        added=tuple(added),
        remark="; ".join(remarks),
    )


def _overlapping_maneuver_id(
    maneuvers: Iterable[DetectedManeuver], name: str, stretch: tuple[float, float]
) -> str | None:
    """Return the id of the maneuver that lies at a stretch; the one of that name before others."""
    best, most = None, -math.inf
    for one in maneuvers:
        common = min(one.t_end, stretch[1]) - max(one.t_start, stretch[0])
        lengths = (one.t_end - one.t_start, stretch[1] - stretch[0])
        if common < DETECTION.same_maneuver_share * min(lengths):
            continue
        if one.id == name:
            return name
        if common / max(lengths) > most:
            best, most = one.id, common / max(lengths)
    return best


EDIT_EVENT: Final = "maneuver-edit"
UNDO_EVENT: Final = "maneuver-undo"
REDO_EVENT: Final = "maneuver-redo"


class ManeuverEditLog:
    """The changes of a flight's maneuvers in its events file, for making and following.

    Parameters
    ----------
    log : EventLog
        Of ``events.jsonl``.
    found : sequence of DetectedManeuver
        What the detection gives for this flight.

    Attributes
    ----------
    maneuver_list : EditableManeuverList
        As of the last `poll`.
    skipped_count : int
        Events that could not be applied: damaged, or overtaken by what another window did.
    """

    def __init__(self, log: EventLog, found: Sequence[DetectedManeuver] = ()) -> None:
        self._log = log
        self._count = 0
        self.maneuver_list = EditableManeuverList(detected=tuple(found))
        self.skipped_count = 0
        self.poll()

    @property
    def remarks(self) -> tuple[str, ...]:
        """Return what is to be said of the changes, in sentences."""
        said = []
        count = len(self.maneuver_list.edits)
        if count:
            said.append(f"maneuvers with {_change_count_text(count)} (manual)")
        said += [edit.remark for edit in self.maneuver_list.edits if edit.remark]
        if self.skipped_count:
            said.append(
                f"{_change_count_text(self.skipped_count)} of maneuvers could not be applied "
                f"and {'is' if self.skipped_count == 1 else 'are'} excluded"
            )
        return tuple(said)

    def poll(self) -> bool:
        """Take in what was written since; return whether the list may have changed."""
        return self.process_events(self._log.poll())

    def process_events(self, events: Iterable[Event]) -> bool:
        """Take in events that somebody else polled; return whether the list may have changed."""
        changed = False
        for event in events:
            if event.kind not in (EDIT_EVENT, UNDO_EVENT, REDO_EVENT):
                continue
            if event.kind == EDIT_EVENT:
                self._count += 1
            try:
                self.maneuver_list = self._after(event)
                changed = True
            except (FlightError, UnknownNameError):
                self.skipped_count += 1
        return changed

    def _after(self, event: Event) -> EditableManeuverList:
        """Return the book after an event; what is taken back or brought again is told by number."""
        book = self.maneuver_list
        if event.kind == EDIT_EVENT:
            edit = ManeuverEdit.from_json(event.text, event.data)
            return book.apply(localize_edit(book, replace(edit, number=self._count)))
        undoes = event.kind == UNDO_EVENT
        stack = book.edits if undoes else book.undone
        number = event.data.get("change")
        if number is not None and (not stack or stack[-1].number != number):
            # Of a change that was left out, or that another window was quicker with.
            return book
        return book.undo() if undoes else book.redo()

    def record(self, book: EditableManeuverList) -> None:
        """Write the latest change of a book that was made from the present one.

        Raises
        ------
        FlightError
            If the book is not one change, undo or redo away, or the file cannot be written.
        """
        now = self.maneuver_list
        if book.edits[:-1] == now.edits and book.edits != now.edits and not book.undone:
            edit = book.edits[-1]
            self._log.append(Event(kind=EDIT_EVENT, text=edit.text, data=edit.to_json()))
        elif now.edits and book == now.undo():
            edit = now.edits[-1]
            text = f"undo: {edit.text}"
            self._log.append(Event(kind=UNDO_EVENT, text=text, data={"change": edit.number}))
        elif now.undone and book == now.redo():
            edit = now.undone[-1]
            text = f"again: {edit.text}"
            self._log.append(Event(kind=REDO_EVENT, text=text, data={"change": edit.number}))
        else:
            raise FlightError("another window changed the maneuvers; review and try again")
        self.poll()


def apply_edits(
    log: ManeuverEditLog, assess: AssessFunction
) -> tuple[tuple[DetectedManeuver, ...], tuple[str, ...]]:
    """Return what stands with all changes, as the samples show it now, and what is to be said.

    The record may have become better since a change was made: the on-board log came, or the
    detection and the grades. A maneuver that lies outside the record is left out.

    Returns
    -------
    maneuvers : tuple of DetectedManeuver
        In order of time.
    remarks : tuple of str
    """
    book = log.maneuver_list
    maneuvers, outside = [], []
    found = set(map(id, book.detected))
    for maneuver in book.maneuvers:
        if id(maneuver) in found:
            maneuvers.append(maneuver)
            continue
        try:
            maneuvers.append(book.reassess(maneuver, assess))
        except FlightError as error:
            outside.append(f"maneuver {maneuver.id}, put in by hand, is left out: {error}")
    return tuple(maneuvers), (*log.remarks, *outside)


def _change_count_text(count: int) -> str:
    return "1 change" if count == 1 else f"{count} changes"
