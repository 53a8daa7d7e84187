"""The flights that were open last, for the start page."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path

from PySide6.QtCore import QObject

from gsapp.flight.folder import FlightFolder
from ui.background_job import BackgroundJob
from ui.flight_controller import FlightController
from ui.settings import RecentFlight, SettingsStore
from ui.translation import tr


class RecentFlights(QObject):
    """Keeps in the settings which flights were open, with what the start page says of them."""

    def __init__(self, controller: FlightController, store: SettingsStore) -> None:
        super().__init__(controller)
        self._controller = controller
        self._store = store
        controller.changed.connect(self._opened)
        controller.about_to_close.connect(self._left)

    def remove(self, path: str) -> None:
        """Forget a flight; its files stay as they are."""
        known = self._store.current.recent_flights
        self._store.change(recent_flights=[one.model_dump() for one in known if one.path != path])

    def _opened(self) -> None:
        session = self._controller.session
        if session is None:
            return
        path = session.path.absolute()
        self._store_flight(
            RecentFlight(path=str(path), name=session.name, aircraft=self._aircraft())
        )
        work = BackgroundJob(
            tr("Reading the date of {name}").format(name=path.name),
            lambda _progress: _date(path),
            self,
        )
        work.done.connect(lambda date: self._update_flight(str(path), date=date))
        work.start()

    def _left(self) -> None:
        session = self._controller.session
        if session is not None:
            replay = session.replay_feed
            first, last = (0.0, session.now) if replay is None else (replay.start, replay.end)
            if first is not None and last is not None:
                path = str(session.path.absolute())
                self._update_flight(path, duration=last - first, aircraft=self._aircraft())

    def _aircraft(self) -> str:
        session = self._controller.session
        return "" if session is None or session.aircraft is None else session.aircraft.name

    def _store_flight(self, flight: RecentFlight) -> None:
        known = self._store.current.recent_flights
        former = next((one for one in known if one.path == flight.path), flight)
        kept = former.model_copy(update={"name": flight.name, "aircraft": flight.aircraft})
        self._store.replace(self._store.current.with_flight(kept))

    def _update_flight(self, path: str, **values: object) -> None:
        flights = tuple(
            one.model_copy(update=values) if one.path == path else one
            for one in self._store.current.recent_flights
        )
        self._store.change(recent_flights=[one.model_dump() for one in flights])


def _date(path: Path) -> str:
    """Return when a flight was recorded, or written, as ``2026-05-12 14:03``."""
    info = FlightFolder(path=path).info() if path.is_dir() else None
    date = info.date if info is not None else None
    when = date or datetime.fromtimestamp(path.stat().st_mtime, UTC)
    return when.astimezone().strftime("%Y-%m-%d %H:%M")
