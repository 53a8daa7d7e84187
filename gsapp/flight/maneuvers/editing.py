"""Changing the list of maneuvers by hand, with nothing lost: every change can be taken back.

A change takes some maneuvers out of the list and puts others in: moving an edge puts in the same
one with other times, merging puts one in for several. The list as found stays untouched beneath,
so that what stands is the found ones with the changes applied in order. Changes are kept as
events of the flight; every window that follows them shows the same list.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final, Protocol

from gsapp.flight.events import Event, EventLog
from gsapp.flight.maneuvers.found import FoundManeuver
from gsapp.foundation import FlightError, UnknownNameError

EDIT: Final = "maneuver-edit"
UNDO: Final = "maneuver-undo"
REDO: Final = "maneuver-redo"


class Assess(Protocol):
    """Looks at a stretch of the flight; see `gsapp.flight.maneuvers.given.Assessor.assess`."""

    def __call__(self, name: str, start: float, stop: float) -> FoundManeuver:
        """Return the stretch from start to stop, s, as a maneuver."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Edit:
    """One change.

    Attributes
    ----------
    words : str
        What was done, for the history on screen.
    removed : tuple of str
        Ids of the maneuvers taken out.
    added : tuple of FoundManeuver
        Put in.
    """

    words: str
    removed: tuple[str, ...] = ()
    added: tuple[FoundManeuver, ...] = ()

    def to_json(self) -> dict[str, Any]:
        """Return the data of an event."""
        return {
            "removed": list(self.removed),
            "added": [maneuver.to_record() for maneuver in self.added],
        }

    @staticmethod
    def from_json(words: str, data: Any) -> Edit:
        """Return the change that an event tells of.

        Raises
        ------
        FlightError
            If it holds none.
        """
        removed, added = data.get("removed"), data.get("added")
        if not isinstance(removed, list) or not isinstance(added, list):
            raise FlightError(f"the event '{words}' holds no change of maneuvers; leave it out")
        return Edit(
            words=words,
            removed=tuple(str(name) for name in removed),
            added=tuple(FoundManeuver.from_record(record) for record in added),
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class ManeuverBook:
    """The maneuvers of a flight with all changes so far. Each change gives a new book.

    Attributes
    ----------
    found : tuple of FoundManeuver
        As the detection gave them.
    edits : tuple of Edit
        In force, in the order in which they were made.
    undone : tuple of Edit
        Taken back, the latest last; `redo` brings it again.
    """

    found: tuple[FoundManeuver, ...] = ()
    edits: tuple[Edit, ...] = ()
    undone: tuple[Edit, ...] = ()

    @property
    def maneuvers(self) -> tuple[FoundManeuver, ...]:
        """Return what stands, in order of time."""
        standing = {maneuver.id: maneuver for maneuver in self.found}
        for edit in self.edits:
            for name in edit.removed:
                standing.pop(name, None)
            standing.update((maneuver.id, maneuver) for maneuver in edit.added)
        return tuple(sorted(standing.values(), key=lambda one: (one.t_start, one.id)))

    def __getitem__(self, name: str) -> FoundManeuver:
        """Return the maneuver of that id.

        Raises
        ------
        UnknownNameError
            If none stands under it.
        """
        maneuvers = self.maneuvers
        for maneuver in maneuvers:
            if maneuver.id == name:
                return maneuver
        there = ", ".join(maneuver.id for maneuver in maneuvers) or "none"
        raise UnknownNameError(f"there is no maneuver '{name}'; there are {there}")

    # Changes --------------------------------------------------------------------------

    def apply(self, edit: Edit) -> ManeuverBook:
        """Return a book with one change more; what had been taken back is gone."""
        standing = {maneuver.id for maneuver in self.maneuvers}
        missing = [name for name in edit.removed if name not in standing]
        if missing:
            raise UnknownNameError(
                f"'{edit.words}' changes the maneuver '{missing[0]}', which is not there any more"
            )
        taken = standing.difference(edit.removed)
        for maneuver in edit.added:
            if not maneuver.id or maneuver.id in taken:
                raise FlightError(
                    f"'{edit.words}' needs a name of its own; '{maneuver.id}' is taken or empty"
                )
            taken.add(maneuver.id)
        return replace(self, edits=(*self.edits, edit), undone=())

    def move(
        self,
        name: str,
        assess: Assess,
        *,
        t_start: float | None = None,
        t_end: float | None = None,
    ) -> ManeuverBook:
        """Move one or both edges (s); inputs and grade are judged anew.

        Raises
        ------
        FlightError
            If the end would come before the start, or no samples lie between.
        """
        old = self[name]
        start = old.t_start if t_start is None else t_start
        stop = old.t_end if t_end is None else t_end
        new = replace(assess(name, *_in_order(start, stop)), note=old.note)
        words = f"move {name} to {new.t_start:.2f} to {new.t_end:.2f} s"
        return self.apply(Edit(words=words, removed=(name,), added=(new,)))

    def add(self, assess: Assess, t_start: float, t_end: float, name: str = "") -> ManeuverBook:
        """Add a stretch (s) that the detection did not take for a maneuver."""
        given = name or self._free_name()
        new = assess(given, *_in_order(t_start, t_end))
        return self.apply(Edit(words=f"add {given} at {new.t_start:.2f} s", added=(new,)))

    def remove(self, name: str) -> ManeuverBook:
        """Take a maneuver out."""
        return self.apply(Edit(words=f"remove {self[name].id}", removed=(name,)))

    def merge(self, names: Sequence[str], assess: Assess) -> ManeuverBook:
        """Make one of several, from the first start to the last end.

        Raises
        ------
        FlightError
            If there are fewer than two.
        """
        if len(set(names)) < 2:
            raise FlightError("merging takes two maneuvers or more; name them")
        parts = sorted((self[name] for name in dict.fromkeys(names)), key=lambda one: one.t_start)
        new = assess(parts[0].id, parts[0].t_start, max(part.t_end for part in parts))
        notes = "; ".join(part.note for part in parts if part.note)
        words = f"merge {', '.join(part.id for part in parts)}"
        removed = tuple(part.id for part in parts)
        return self.apply(Edit(words=words, removed=removed, added=(replace(new, note=notes),)))

    def rename(self, name: str, new: str) -> ManeuverBook:
        """Give a maneuver another id."""
        renamed = replace(self[name], id=new.strip())
        return self.apply(Edit(words=f"rename {name} to {new}", removed=(name,), added=(renamed,)))

    def annotate(self, name: str, note: str) -> ManeuverBook:
        """Write a note beside a maneuver, in place of the former one."""
        noted = replace(self[name], note=note)
        return self.apply(Edit(words=f"note on {name}", removed=(name,), added=(noted,)))

    def undo(self) -> ManeuverBook:
        """Take the latest change back; the same book where there is none."""
        if not self.edits:
            return self
        return replace(self, edits=self.edits[:-1], undone=(*self.undone, self.edits[-1]))

    def redo(self) -> ManeuverBook:
        """Bring back what was taken back last; the same book where there is none."""
        if not self.undone:
            return self
        return replace(self, edits=(*self.edits, self.undone[-1]), undone=self.undone[:-1])

    def _free_name(self) -> str:
        used = {maneuver.id for maneuver in self.maneuvers}
        number = len(used) + 1
        while str(number) in used:
            number += 1
        return str(number)


class ManeuverLog:
    """The changes of a flight's maneuvers in its events file, for making and following.

    Parameters
    ----------
    log : EventLog
        Of ``events.jsonl``.
    found : sequence of FoundManeuver
        What the detection gives for this flight.

    Attributes
    ----------
    book : ManeuverBook
        As of the last `poll`.
    left_out : int
        Events that could not be applied: damaged, or overtaken by what another window did.
    """

    def __init__(self, log: EventLog, found: Sequence[FoundManeuver] = ()) -> None:
        self._log = log
        self.book = ManeuverBook(found=tuple(found))
        self.left_out = 0
        self.poll()

    def poll(self) -> bool:
        """Take in what was written since; return whether the list may have changed."""
        return self.follow(self._log.poll())

    def follow(self, events: Iterable[Event]) -> bool:
        """Take in events that somebody else polled; return whether the list may have changed."""
        changed = False
        for event in events:
            if event.kind not in (EDIT, UNDO, REDO):
                continue
            try:
                self.book = _after(self.book, event)
                changed = True
            except (FlightError, UnknownNameError):
                self.left_out += 1
        return changed

    def record(self, book: ManeuverBook) -> None:
        """Write the latest change of a book that was made from the present one.

        Raises
        ------
        FlightError
            If the book is not one change, undo or redo away, or the file cannot be written.
        """
        now = self.book
        if book.edits[:-1] == now.edits and book.edits != now.edits and not book.undone:
            edit = book.edits[-1]
            self._log.append(Event(kind=EDIT, text=edit.words, data=edit.to_json()))
        elif book == now.undo():
            self._log.append(Event(kind=UNDO, text=f"take back: {book.undone[-1].words}"))
        elif book == now.redo():
            self._log.append(Event(kind=REDO, text=f"again: {book.edits[-1].words}"))
        else:
            raise FlightError("another window changed the maneuvers meanwhile; look, and try again")
        self.poll()


def _after(book: ManeuverBook, event: Event) -> ManeuverBook:
    if event.kind == UNDO:
        return book.undo()
    if event.kind == REDO:
        return book.redo()
    return book.apply(Edit.from_json(event.text, event.data))


def _in_order(start: float, stop: float) -> tuple[float, float]:
    if not start < stop:
        raise FlightError(
            f"a maneuver from {start:g} to {stop:g} s ends before it begins; swap the edges"
        )
    return start, stop
