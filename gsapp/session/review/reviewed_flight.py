"""One flight under review: its samples, its maneuvers, and every change of them by hand."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.flight.catalog import Catalog, StoredVerdict, search_verdicts, store_maneuvers
from gsapp.flight.events import EventLog, events_path
from gsapp.flight.flight import Flight
from gsapp.flight.maneuvers import (
    GRADED_BY_PROGRAM,
    DetectedManeuver,
    EditableManeuverList,
    FlightManeuvers,
    Grade,
    ManeuverAssessor,
    ManeuverEditLog,
    apply_edits,
    collect_maneuvers,
)
from gsapp.foundation import FlightError
from gsapp.identification.maneuver import open_flight
from gsapp.quantities.stored_block import block_in_file
from gsapp.session.monitor_settings import MONITORS


def save_maneuvers_to_catalog(
    catalog: Path, flight: Flight, maneuvers: Sequence[DetectedManeuver], aircraft: Aircraft
) -> None:
    """Write the maneuvers of a flight as they stand into a catalog, all or none.

    Parameters
    ----------
    maneuvers : sequence of DetectedManeuver
        In place of those that the catalog had of this flight.

    Raises
    ------
    FlightError
        If the catalog cannot be written.
    """
    catalog.parent.mkdir(parents=True, exist_ok=True)
    with Catalog(catalog) as opened:
        store_maneuvers(opened, flight, maneuvers, aircraft=aircraft)


def load_catalog_verdicts(catalog: Path | None, flight: str) -> tuple[StoredVerdict, ...]:
    """Return what the pilot was told in a flight, by time; nothing where it was not kept.

    Raises
    ------
    FlightError
        If the catalog cannot be read.
    """
    if catalog is None or not catalog.is_file():
        return ()
    with Catalog(catalog) as opened:
        return search_verdicts(opened, flight=flight)


class ReviewedFlight:
    """A flight whose maneuvers are corrected by hand.

    Every change is written among the events of the flight at once, and stands for all who look
    for its maneuvers. Changes can be taken back in the order in which they were made, whoever
    made them.

    Parameters
    ----------
    found : FlightManeuvers
        As the detection gives them, without changes by hand.
    """

    def __init__(
        self,
        flight: Flight,
        aircraft: Aircraft,
        found: FlightManeuvers,
        remarks: Sequence[str] = (),
        verdicts: Sequence[StoredVerdict] = (),
    ) -> None:
        self.flight = flight
        self.aircraft = aircraft
        self.verdicts = tuple(verdicts)
        self._opened = tuple(remarks)
        self._assessor = ManeuverAssessor(flight, aircraft, found.noise)
        self._seen: dict[tuple[float, float], DetectedManeuver] = {}
        self._log = ManeuverEditLog(EventLog(events_path(flight.path)), found.maneuvers)
        self.maneuvers: tuple[DetectedManeuver, ...] = ()
        self._remarks: tuple[str, ...] = ()
        self._apply_edits()

    # What it is

    @property
    def path(self) -> Path:
        return self.flight.path

    @property
    def name(self) -> str:
        return self.flight.name

    @property
    def span(self) -> tuple[float, float]:
        """Return the times of the first and the last sample, s."""
        times = self.flight.block.times
        return float(times[0]), float(times[-1])

    @property
    def sample_period(self) -> float:
        return 1.0 / self.flight.rate

    @property
    def remarks(self) -> tuple[str, ...]:
        """Return what is to be said: of reading the flight, and of changes by hand."""
        return (*self._opened, *self._remarks)

    @property
    def changes(self) -> tuple[str, ...]:
        """Return the changes in force, in words, the oldest first."""
        return tuple(edit.text for edit in self._log.maneuver_list.edits)

    def __getitem__(self, name: str) -> DetectedManeuver:
        """Return the maneuver of that id.

        Raises
        ------
        UnknownNameError
            If none stands under it.
        """
        for maneuver in self.maneuvers:
            if maneuver.id == name:
                return maneuver
        return self._log.maneuver_list[name]

    def is_edited(self, name: str) -> bool:
        """Return whether a person has changed that maneuver, or put it in."""
        return any(one.id == name for edit in self._log.maneuver_list.edits for one in edit.added)

    def in_use(self, maneuver: DetectedManeuver) -> bool:
        """Return whether a maneuver takes part in estimates."""
        return maneuver.is_used(alone=len(self.maneuvers) == 1)

    def verdict(self, maneuver: DetectedManeuver) -> StoredVerdict | None:
        """Return what the pilot was told of the input within a maneuver; None for nothing."""
        for verdict in self.verdicts:
            if maneuver.t_start <= verdict.t_input < maneuver.t_end:
                return verdict
        return None

    def overlapping(self, maneuver: DetectedManeuver) -> tuple[str, ...]:
        """Return the other maneuvers that share samples with one: they count twice in means."""
        return tuple(
            one.id
            for one in self.maneuvers
            if one.id != maneuver.id
            and one.t_start < maneuver.t_end
            and maneuver.t_start < one.t_end
        )

    # Looking

    def snap_to_sample(self, time: float) -> float:
        """Return the time of the nearest sample, s."""
        times = self.flight.block.times
        place = int(np.clip(np.searchsorted(times, time), 1, times.size - 1))
        before, after = float(times[place - 1]), float(times[place])
        return before if time - before <= after - time else after

    def grade_segment(self, name: str, start: float, stop: float) -> DetectedManeuver:
        """Return a stretch (s) as a maneuver, graded; nothing is changed.

        Raises
        ------
        FlightError
            If it lies outside the flight.
        """
        seen = self._seen.get((start, stop))
        if seen is None:
            seen = self._assessor.assess(name, start, stop)
            self._seen[start, stop] = seen
        return replace(seen, id=name)

    def preview_move(self, name: str, start: float, stop: float) -> DetectedManeuver:
        """Return how a maneuver would be graded with other edges (s); nothing is changed.

        Raises
        ------
        FlightError
            If it would be too short, or lie outside the flight.
        """
        start, stop = self._edges(start, stop)
        return self._log.maneuver_list.move(name, self.grade_segment, t_start=start, t_end=stop)[
            name
        ]

    def _edges(self, start: float, stop: float) -> tuple[float, float]:
        start, stop = self.snap_to_sample(start), self.snap_to_sample(stop)
        if not stop - start >= MONITORS.min_maneuver_duration:
            raise FlightError(
                f"from {start:.2f} to {stop:.2f} s is too short for a maneuver; minimum "
                f"{MONITORS.min_maneuver_duration:g} s"
            )
        return start, stop

    # Changes

    def move(self, name: str, start: float, stop: float) -> None:
        """Move the edges of a maneuver to the samples nearest to these times, s.

        Raises
        ------
        FlightError
            If it would be too short, or lie outside the flight.
        """
        start, stop = self._edges(start, stop)
        old = self[name]
        if (start, stop) != (old.t_start, old.t_end):
            self._record(
                self._log.maneuver_list.move(name, self.grade_segment, t_start=start, t_end=stop)
            )

    def add(self, start: float, stop: float) -> str:
        """Add a stretch (s) that the detection did not take for a maneuver; return its id.

        Raises
        ------
        FlightError
            If it is too short, or lies outside the flight.
        """
        start, stop = self._edges(start, stop)
        return self._record(self._log.maneuver_list.add(self.grade_segment, start, stop))

    def remove(self, *names: str) -> None:
        """Take maneuvers out, as one change."""
        self._record(self._log.maneuver_list.remove(*names))

    def merge(self, names: Sequence[str]) -> str:
        """Make one of several, from the first start to the last end; return its id."""
        return self._record(self._log.maneuver_list.merge(names, self.grade_segment))

    def rename(self, name: str, new: str) -> str:
        """Give a maneuver another id; return it.

        Raises
        ------
        FlightError
            If it is empty or taken, or looks as if it named a flight.
        """
        new = new.strip()
        if ":" in new or "," in new:
            raise FlightError(f"a maneuver cannot be called '{new}': ':' and ',' are separators")
        if new == name:
            return name
        return self._record(self._log.maneuver_list.rename(name, new))

    def annotate(self, name: str, note: str) -> None:
        """Write a note beside a maneuver, in place of the former one."""
        if note.strip() != self[name].note:
            self._record(self._log.maneuver_list.annotate(name, note.strip()))

    def set_grade(self, name: str, grade: Grade | None, reason: str = "") -> None:
        """Give a maneuver the grade that a person finds right; None leaves it to the program."""
        old = self[name]
        if grade is None and old.graded_by == GRADED_BY_PROGRAM:
            return
        self._record(self._log.maneuver_list.regrade(name, grade, self.grade_segment, reason))

    def set_in_use(self, name: str, wanted: bool) -> None:
        """Let a maneuver take part in estimates, or not, whatever its grade."""
        if wanted != self.in_use(self[name]):
            self._record(self._log.maneuver_list.set_use(name, wanted))

    @property
    def can_undo(self) -> bool:
        return bool(self._log.maneuver_list.edits)

    @property
    def can_redo(self) -> bool:
        return bool(self._log.maneuver_list.undone)

    @property
    def undo_text(self) -> str:
        """Return the latest change in words; empty for none."""
        return self._log.maneuver_list.edits[-1].text if self.can_undo else ""

    @property
    def redo_text(self) -> str:
        """Return the change that was undone last, in words; empty for none."""
        return self._log.maneuver_list.undone[-1].text if self.can_redo else ""

    def undo(self) -> str:
        """Undo the latest change; return it in words, empty for none."""
        text = self.undo_text
        if text:
            self._record(self._log.maneuver_list.undo())
        return text

    def redo(self) -> str:
        """Make the change again that was taken back last; return it in words, empty for none."""
        text = self.redo_text
        if text:
            self._record(self._log.maneuver_list.redo())
        return text

    def poll(self) -> bool:
        """Take in what other windows changed; return whether the maneuvers may be others now."""
        changed = self._log.poll()
        if changed:
            self._apply_edits()
        return changed

    def _record(self, maneuvers: EditableManeuverList) -> str:
        """Write the latest change; return the id of what it put in, empty for nothing."""
        count = len(self._log.maneuver_list.edits)
        self._log.record(maneuvers)
        self._apply_edits()
        edits = self._log.maneuver_list.edits
        added = edits[-1].added if len(edits) > count else ()
        return added[0].id if added else ""

    def _apply_edits(self) -> None:
        self.maneuvers, self._remarks = apply_edits(self._log, self.grade_segment)


def open_reviewed_flight(
    path: Path,
    *,
    aircraft: str = "",
    channel_map: str = "",
    calibration: str = "",
    catalog: Path | None = None,
    doing: Callable[[str], object] | None = None,
) -> ReviewedFlight:
    """Open a flight for review; for the thread of a work.

    Parameters
    ----------
    aircraft, channel_map, calibration : str
        Names or paths; empty where the flight says it itself.

    Raises
    ------
    GroundStationError
        If the flight or a file cannot be read, or no surface was measured.
    """
    if doing is not None:
        doing(f"reading {path.name}")
    opened = open_flight(
        path,
        aircraft=aircraft or None,
        channel_map=channel_map or None,
        calibration=calibration or None,
    )
    if doing is not None:
        doing(f"looking for maneuvers in {path.name}")
    found = collect_maneuvers(opened.flight, opened.aircraft, as_found=True)
    return ReviewedFlight(
        replace(opened.flight, block=block_in_file(opened.flight.block)),
        opened.aircraft,
        found,
        (*opened.remarks, *found.remarks),
        load_catalog_verdicts(catalog, opened.flight.name),
    )
