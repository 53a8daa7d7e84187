"""Changing the list of maneuvers by hand, with nothing lost: every change can be taken back.

A change takes some maneuvers out of the list and puts others in: moving an edge puts in the same
one with other times, merging puts one in for several. The list as found stays untouched beneath,
so that what stands is the found ones with the changes applied in order. Changes are kept as
events of the flight; every window that follows them shows the same list.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final, Protocol

from gsapp.flight.events import Event, EventLog
from gsapp.flight.maneuvers.detected_maneuver import (
    GRADED_BY_CREW,
    GRADED_BY_PROGRAM,
    GRADES,
    DetectedManeuver,
    Grade,
)
from gsapp.flight.maneuvers.settings import DETECTION
from gsapp.foundation import FlightError, UnknownNameError


class AssessFunction(Protocol):
    """Assesses a time window of the flight; see `ManeuverAssessor.assess`."""

    def __call__(self, name: str, start: float, stop: float) -> DetectedManeuver:
        """Return the stretch from start to stop, s, as a maneuver."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ManeuverEdit:
    """One change."""

    text: str
    """What was done, for the history on screen."""
    removed: tuple[str, ...] = ()
    """Ids of the maneuvers taken out."""
    added: tuple[DetectedManeuver, ...] = ()
    """Put in."""
    segments: tuple[tuple[float, float], ...] = ()
    """Where each of those taken out lay, s; empty in files of former versions."""
    number: int = field(default=0, compare=False)
    """Which change of the events file it is, from 1; 0 before it was written."""
    remark: str = field(default="", compare=False)
    """What had to be done to apply it to a list that was found otherwise; empty for nothing."""

    def to_json(self) -> dict[str, Any]:
        return {
            "removed": list(self.removed),
            "stretches": [list(stretch) for stretch in self.segments],
            "added": [maneuver.to_record() for maneuver in self.added],
        }

    @staticmethod
    def from_json(text: str, data: Any) -> ManeuverEdit:
        """Return the change that an event tells of."""
        removed, added = data.get("removed"), data.get("added")
        if not isinstance(removed, list) or not isinstance(added, list):
            raise FlightError(f"the event '{text}' contains no maneuver edit; remove it")
        try:
            stretches = tuple((float(low), float(high)) for low, high in data.get("stretches", ()))
        except (TypeError, ValueError) as error:
            raise FlightError(
                f"the event '{text}' does not locate its maneuvers; remove it"
            ) from error
        return ManeuverEdit(
            text=text,
            removed=tuple(str(name) for name in removed),
            added=tuple(DetectedManeuver.from_record(record) for record in added),
            segments=stretches if len(stretches) == len(removed) else (),
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class EditableManeuverList:
    """The maneuvers of a flight with all changes so far. Each change gives a new book."""

    detected: tuple[DetectedManeuver, ...] = ()
    """As the detection gave them."""
    edits: tuple[ManeuverEdit, ...] = ()
    """In force, in the order in which they were made."""
    undone: tuple[ManeuverEdit, ...] = ()
    """Taken back, the latest last; `redo` brings it again."""

    @property
    def maneuvers(self) -> tuple[DetectedManeuver, ...]:
        """Return what stands, in order of time."""
        standing = {maneuver.id: maneuver for maneuver in self.detected}
        for edit in self.edits:
            for name in edit.removed:
                standing.pop(name, None)
            standing.update((maneuver.id, maneuver) for maneuver in edit.added)
        return tuple(sorted(standing.values(), key=lambda one: (one.t_start, one.id)))

    def __getitem__(self, name: str) -> DetectedManeuver:
        """Return the maneuver of that id."""
        maneuvers = self.maneuvers
        for maneuver in maneuvers:
            if maneuver.id == name:
                return maneuver
        there = ", ".join(maneuver.id for maneuver in maneuvers) or "none"
        raise UnknownNameError(f"there is no maneuver '{name}'; there are {there}")

    # Changes --------------------------------------------------------------------------

    def apply(self, edit: ManeuverEdit) -> EditableManeuverList:
        """Return a book with one change more; what had been taken back is gone."""
        standing = {maneuver.id: maneuver for maneuver in self.maneuvers}
        missing = [name for name in edit.removed if name not in standing]
        if missing:
            raise UnknownNameError(
                f"'{edit.text}' changes the maneuver '{missing[0]}', which no longer exists"
            )
        taken = set(standing).difference(edit.removed)
        for maneuver in edit.added:
            if not maneuver.id or maneuver.id in taken:
                raise FlightError(
                    f"'{edit.text}' needs a unique name; '{maneuver.id}' is taken or empty"
                )
            taken.add(maneuver.id)
        if not edit.segments:
            lay = tuple((standing[name].t_start, standing[name].t_end) for name in edit.removed)
            edit = replace(edit, segments=lay)
        return replace(self, edits=(*self.edits, edit), undone=())

    def move(
        self,
        name: str,
        assess: AssessFunction,
        *,
        t_start: float | None = None,
        t_end: float | None = None,
    ) -> EditableManeuverList:
        """Move one or both edges (s); inputs and grade, but one by the crew, are judged anew."""
        old = self[name]
        start = old.t_start if t_start is None else t_start
        stop = old.t_end if t_end is None else t_end
        new = _with_crew_entries(assess(name, *_check_order(start, stop)), old)
        text = f"move {name} to {new.t_start:.2f} to {new.t_end:.2f} s"
        return self.apply(ManeuverEdit(text=text, removed=(name,), added=(new,)))

    def add(
        self, assess: AssessFunction, t_start: float, t_end: float, name: str = ""
    ) -> EditableManeuverList:
        """Add a stretch (s) that the detection did not take for a maneuver."""
        given = name or self.unused_id()
        new = assess(given, *_check_order(t_start, t_end))
        return self.apply(ManeuverEdit(text=f"add {given} at {new.t_start:.2f} s", added=(new,)))

    def remove(self, *names: str) -> EditableManeuverList:
        found = tuple(self[name].id for name in dict.fromkeys(names))
        return self.apply(ManeuverEdit(text=f"remove {', '.join(found)}", removed=found))

    def merge(self, names: Sequence[str], assess: AssessFunction) -> EditableManeuverList:
        """Make one of several, from the first start to the last end."""
        if len(set(names)) < 2:
            raise FlightError("merging needs two or more maneuvers")
        parts = sorted((self[name] for name in dict.fromkeys(names)), key=lambda one: one.t_start)
        new = assess(parts[0].id, parts[0].t_start, max(part.t_end for part in parts))
        notes = "; ".join(part.note for part in parts if part.note)
        text = f"merge {', '.join(part.id for part in parts)}"
        removed = tuple(part.id for part in parts)
        return self.apply(
            ManeuverEdit(text=text, removed=removed, added=(replace(new, note=notes),))
        )

    def rename(self, name: str, new: str) -> EditableManeuverList:
        """Give a maneuver another id."""
        renamed = replace(self[name], id=new.strip())
        return self.apply(
            ManeuverEdit(text=f"rename {name} to {new}", removed=(name,), added=(renamed,))
        )

    def annotate(self, name: str, note: str) -> EditableManeuverList:
        noted = replace(self[name], note=note)
        return self.apply(ManeuverEdit(text=f"note on {name}", removed=(name,), added=(noted,)))

    def regrade(
        self, name: str, grade: Grade | None, assess: AssessFunction, reason: str = ""
    ) -> EditableManeuverList:
        """Give a maneuver the grade that a person finds right; None leaves it to the program."""
        old = self[name]
        if grade is None:
            mine = replace(old, graded_by=GRADED_BY_PROGRAM)
            new = self.reassess(mine, assess)
            text = f"grade {name} automatically"
        elif grade in GRADES:
            reasons = (reason.strip(),) if reason.strip() else ()
            new = replace(old, grade=grade, reasons=reasons, graded_by=GRADED_BY_CREW)
            text = f"grade {name} {grade}"
        else:
            raise FlightError(f"there is no grade '{grade}'; grades are {', '.join(GRADES)}")
        return self.apply(ManeuverEdit(text=text, removed=(name,), added=(new,)))

    def set_use(self, name: str, use: bool) -> EditableManeuverList:
        """Let a maneuver take part in estimates, or not, whatever its grade.

        A decision that says no more than the grade is none, and does not outlast it.
        """
        old = self[name]
        alone = len(self.maneuvers) == 1
        by_grade = replace(old, use=None).is_used(alone=alone)
        decided = replace(old, use=None if use == by_grade else use)
        text = f"use {name} in estimates" if use else f"exclude {name} from estimates"
        return self.apply(ManeuverEdit(text=text, removed=(name,), added=(decided,)))

    def reassess(self, maneuver: DetectedManeuver, assess: AssessFunction) -> DetectedManeuver:
        """Return a maneuver as the samples show it now, with what people wrote of it.

        One with edges as they were found is what the detection says; others are looked at anew.
        """
        for one in self.detected:
            edges = (one.t_start - maneuver.t_start, one.t_end - maneuver.t_end)
            if max(map(abs, edges)) <= DETECTION.same_edge_tolerance:
                return _with_crew_entries(one, maneuver)
        return _with_crew_entries(assess(maneuver.id, maneuver.t_start, maneuver.t_end), maneuver)

    def undo(self) -> EditableManeuverList:
        """Take the latest change back; the same book where there is none."""
        if not self.edits:
            return self
        return replace(self, edits=self.edits[:-1], undone=(*self.undone, self.edits[-1]))

    def redo(self) -> EditableManeuverList:
        """Bring back what was taken back last; the same book where there is none."""
        if not self.undone:
            return self
        return replace(self, edits=(*self.edits, self.undone[-1]), undone=self.undone[:-1])

    def unused_id(self, names: Iterable[str] = ()) -> str:
        """Return an id that neither a maneuver here has nor one of these."""
        # Nor one that was taken out: what was estimated from it keeps its name.
        ever = (*self.detected, *(one for edit in self.edits for one in edit.added))
        used = {maneuver.id for maneuver in ever}.union(names)
        number = len(used) + 1
        while str(number) in used:
            number += 1
        return str(number)


def _with_crew_entries(maneuver: DetectedManeuver, former: DetectedManeuver) -> DetectedManeuver:
    """Return a maneuver with what people say of it: id, note, use, and the grade they gave."""
    kept = replace(maneuver, id=former.id, note=former.note, use=former.use)
    if former.graded_by == GRADED_BY_PROGRAM:
        return kept
    return replace(kept, grade=former.grade, reasons=former.reasons, graded_by=former.graded_by)


def _check_order(start: float, stop: float) -> tuple[float, float]:
    if not start < stop:
        raise FlightError(
            f"a maneuver from {start:g} to {stop:g} s ends before it begins; swap the edges"
        )
    return start, stop


def localize_edit(book: EditableManeuverList, edit: ManeuverEdit) -> ManeuverEdit:
    """Return a change with the ids that its maneuvers have in a book.

    One that is not found any more stays as it was put in; there is nothing to take out then.
    `ManeuverEdit.remark` tells what is otherwise. `UnknownNameError` if a change before it has
    taken the maneuver out.
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

    `maneuver_list` is as of the last `poll`; `skipped_count` counts the events that could not be
    applied: damaged, or overtaken by what another window did.
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
        """Write the latest change, undo or redo by which a book differs from the present one."""
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
    """Return what stands by time, as the samples show it now, and what is to be said.

    The record may have become better since a change was made: the on-board log came, or the
    detection and the grades. A maneuver that lies outside the record is left out.
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
