"""The checklist as the crew goes through it: which list, how it stands, what was ticked. No Qt."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from datetime import datetime
from pathlib import Path

from gsapp.aircraft import Aircraft
from gsapp.flight.folder import FlightFolder
from gsapp.flight.info import FlightInfo
from gsapp.foundation import GroundStationError
from gsapp.foundation.files import FileStamp, file_stamp, write_atomically
from gsapp.session import Session
from gsapp.session.checklist import (
    SHIPPED_CHECKLISTS,
    ChecklistFile,
    EvaluatedItem,
    SessionChecklist,
    load_checklist,
    shipped_checklists,
)
from gsapp.session.checklist.session_checklist import PendingChecklist
from ui.number_format import count_text
from ui.translation import tr
from ui.undo import UndoCommand, UndoStack
from ui.window_frame.page_steps import StepStatus

Ticks = frozenset[str]


class ChecklistModel:
    """One checklist and its ticks.

    Parameters
    ----------
    own : Path
        The crew's own list; the shipped one counts until it is there.
    """

    def __init__(self, own: Path) -> None:
        self.own = own
        self.items: tuple[EvaluatedItem, ...] = ()
        self.own_list_error = ""
        self._file: ChecklistFile | None = None
        self._session: Session | None = None
        self._folder = own.parent
        self._card: Callable[[], FlightInfo | None] = lambda: None
        self._aircraft: Aircraft | None = None
        self._going: SessionChecklist | PendingChecklist | None = None
        self.undo_stack = UndoStack()
        self._read_stamp: FileStamp | None = None
        self._system = "US"

    # Which list

    def set_flight(
        self,
        session: Session | None,
        folder: Path,
        card: Callable[[], FlightInfo | None],
        aircraft: Aircraft | None,
    ) -> None:
        """Go through the list for another flight, or for the next one."""
        self._session, self._folder = session, folder
        self._card, self._aircraft = card, aircraft
        self.read()

    def read(self) -> None:
        """Read the list again, after it was edited or for another aircraft; ticks stay."""
        self._read_stamp = file_stamp(self.own)
        try:
            self._file = load_checklist(self.own if self.own.is_file() else self.shipped)
            self.own_list_error = ""
        except GroundStationError as error:
            self.own_list_error = str(error)
            self._file = self._file or load_checklist(self.shipped)
        if self._session is not None:
            self._going = SessionChecklist(self._session, self._file, card=self._card)
        else:
            log = FlightFolder(path=self._folder).events
            self._going = PendingChecklist(
                log, self._file, card=self._card, aircraft=self._aircraft
            )
        self.update_items()
        self.undo_stack.clear()

    def read_if_changed(self) -> bool:
        """Read the list again if its file is another; return whether it was."""
        if file_stamp(self.own) == self._read_stamp:
            return False
        self.read()
        return True

    @property
    def shipped(self) -> str:
        """Return the name of the list that comes with the program for this aircraft."""
        names = shipped_checklists()
        name = "" if self._aircraft is None else self._aircraft.name.casefold()
        return name if name in names else names[0]

    @property
    def name(self) -> str:
        return self._file.name if self._file is not None else ""

    def create_own_list(self) -> Path:
        """Return the crew's own list, made from the shipped one if there is none yet."""
        if not self.own.is_file():
            write_atomically(self.own, SHIPPED_CHECKLISTS.find(self.shipped).read_bytes())
        return self.own

    # How it stands

    def update_items(self, system: str = "") -> None:
        """See how the items stand now; `system` are the units of the sentences from here on."""
        if self._going is not None:
            self._system = system or self._system
            self._going.system = self._system
            self.items = self._going.update()

    @property
    def accepts_ticks(self) -> bool:
        """Return whether ticks are of use: not in a replay of a flight that was."""
        return self._session is None or self._session.replay_feed is None

    @property
    def ticks(self) -> Ticks:
        return frozenset(self._going.checklist.ticks) if self._going is not None else frozenset()

    @property
    def open_items(self) -> tuple[EvaluatedItem, ...]:
        return tuple(item for item in self.items if item.state != "green")

    @property
    def started_text(self) -> str:
        """Return how this flight was started, by this or another window; empty before."""
        going = self._going
        event = going.start_event if isinstance(going, SessionChecklist) else None
        if event is None:
            return ""
        at = datetime.fromtimestamp(event.host_time_us / 1e6).astimezone()
        left = sum(len(event.data.get(state, ())) for state in ("red", "amber", "open"))
        if not left:
            return tr("Flight started at {at:%H:%M}, all green. Recorded.").format(at=at)
        items = count_text(left, "item")
        return tr("Flight started at {at:%H:%M} anyway, {items} not green. Recorded.").format(
            at=at, items=items
        )

    @property
    def state(self) -> StepStatus:
        left = self.open_items
        if not self.accepts_ticks:
            return StepStatus(
                state="plain",
                text=tr("a replay"),
                detail=tr("{count} not green in this replay").format(count=len(left)),
            )
        if not left:
            return StepStatus(state="good", text=tr("all green"))
        detail = tr("Not green: {items}").format(items=", ".join(item.text for item in left))
        return StepStatus(
            state="warning", text=tr("{count} not green").format(count=len(left)), detail=detail
        )

    # What the crew does

    def toggle(self, item_id: str) -> bool:
        """Tick an item, or take its tick back; return whether it can be ticked."""
        item = next((one for one in self.items if one.id == item_id), None)
        if item is None or not item.can_tick or not self.accepts_ticks:
            return False
        former = self.ticks
        self._set(former ^ {item_id})
        self._push(tr("untick") if item_id in former else tr("tick"), former)
        return True

    def restart(self) -> None:
        """Begin anew: no tick stands and nothing was seen."""
        if self._going is not None and self.accepts_ticks:
            former = self.ticks
            self._going.restart()
            self.update_items()
            if self.ticks != former:
                self._push(tr("restart"), former)

    def _push(self, text: str, former: Ticks) -> None:
        now = self.ticks
        self.undo_stack.push(UndoCommand(text, lambda: self._set(former), lambda: self._set(now)))

    def _set(self, wanted: Ticks) -> None:
        going = self._going
        if going is None:
            return
        for item_id in sorted(wanted - self.ticks):
            going.tick(item_id)
        for item_id in sorted(self.ticks - wanted):
            going.untick(item_id)
        self.update_items()

    def record_start(self) -> str:
        """Record that the flight begins as the list stands; return that in words, else nothing."""
        if not isinstance(self._going, SessionChecklist) or not self.accepts_ticks:
            return ""
        self._going.start()
        self.update_items()
        return self.started_text


def describe_summary(items: Sequence[EvaluatedItem]) -> str:
    """Return the one line on top: ``3 not green``."""
    left = [item for item in items if item.state != "green"]
    return (
        tr("{count} not green").format(count=len(left))
        if left
        else tr("All green: {items}").format(items=count_text(len(items), "item"))
    )
