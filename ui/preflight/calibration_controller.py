"""Which calibrations are meant, and how those just made come in force in what is open."""

from __future__ import annotations

from pathlib import Path

from ui.disk_checks import path_kind
from ui.flight_controller import FlightController
from ui.preflight.calibration_folder import (
    CalibrationFolder,
    find_current_aircraft,
    practice_folder,
)
from ui.preflight.practice_bench import PracticeBench
from ui.settings import SettingsStore, calibrations_path

_DEFAULT_CERTIFICATES = "b777"


class CalibrationController:
    """The calibrations of the current aircraft, and their way into flights.

    Parameters
    ----------
    controller : FlightController
        The open flight.
    store : SettingsStore
        Remembers which certificates flights are made with.
    practice : PracticeBench
        What is calibrated while it runs never counts for an aircraft.
    """

    def __init__(
        self, controller: FlightController, store: SettingsStore, practice: PracticeBench
    ) -> None:
        self._controller = controller
        self._store = store
        self._practice = practice
        self._calibrations: CalibrationFolder | None = None
        self._changed_flight: Path | None = None

    @property
    def folder(self) -> CalibrationFolder:
        """Return the calibrations of the aircraft at hand."""
        name = find_current_aircraft(self._controller.session, self._store.current)
        practices = self._practice.running
        settings = self._store.path
        folder = practice_folder(settings) if practices else calibrations_path(settings)
        calibrations = self._calibrations
        if calibrations is None or (calibrations.folder, calibrations.aircraft) != (folder, name):
            usual = _DEFAULT_CERTIFICATES if practices else self._store.current.calibration
            calibrations = self._calibrations = CalibrationFolder(folder, name, usual)
        return calibrations

    def apply(self, calibrations: CalibrationFolder) -> None:
        """Use these certificates for the open flight and those to come."""
        if calibrations.folder != practice_folder(self._store.path):
            self._store.change(calibration=str(calibrations.write_flight_certificates()))
        session = self._controller.session
        if (
            session is not None
            and session.replay_feed is None
            and path_kind(session.path) == "folder"
            and calibrations is self.folder
            and calibrations.copy_to_flight(session.path)
        ):
            self._changed_flight = session.path

    def reload_flight(self) -> None:
        """Read the open flight with the certificates put in force: as any replay will."""
        session, stale = self._controller.session, self._changed_flight
        self._changed_flight = None
        if session is not None and session.path == stale:
            self._controller.flight_opener.open_flight(stale)
