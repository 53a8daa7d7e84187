"""Which calibrations are meant, and how those just made come in force in what is open."""

from __future__ import annotations

from pathlib import Path

from ui.desk import Desk
from ui.disk_checks import path_kind
from ui.preflight.practice import Practice
from ui.preflight.shelf import Shelf, aircraft_at_hand, practice_path
from ui.settings import SettingsStore, calibrations_path

_USUAL = "b777"


class InForce:
    """The shelf of the aircraft at hand, and the way from it into flights.

    Parameters
    ----------
    desk : Desk
        The open flight.
    store : SettingsStore
        Remembers which certificates flights are made with.
    practice : Practice
        What is calibrated while it runs never counts for an aircraft.
    """

    def __init__(self, desk: Desk, store: SettingsStore, practice: Practice) -> None:
        self._desk = desk
        self._store = store
        self._practice = practice
        self._shelf: Shelf | None = None
        self._stale: Path | None = None

    @property
    def shelf(self) -> Shelf:
        """Return the calibrations of the aircraft at hand."""
        name = aircraft_at_hand(self._desk.session, self._store.current)
        practices = self._practice.running
        settings = self._store.path
        folder = practice_path(settings) if practices else calibrations_path(settings)
        shelf = self._shelf
        if shelf is None or (shelf.folder, shelf.aircraft) != (folder, name):
            usual = _USUAL if practices else self._store.current.calibration
            shelf = self._shelf = Shelf(folder, name, usual)
        return shelf

    def put(self, shelf: Shelf) -> None:
        """Let flights, the open one and those to come, be made with a shelf's certificates."""
        if shelf.folder != practice_path(self._store.path):
            self._store.change(calibration=str(shelf.flight_set()))
        session = self._desk.session
        if (
            session is not None
            and session.replaying is None
            and path_kind(session.path) == "folder"
            and shelf is self.shelf
            and shelf.keep_with(session.path)
        ):
            self._stale = session.path

    def read_anew(self) -> None:
        """Read the open flight with the certificates put in force: as any replay will."""
        session, stale = self._desk.session, self._stale
        self._stale = None
        if session is not None and session.path == stale:
            self._desk.starter.open_flight(stale)
