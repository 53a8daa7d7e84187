"""What the steps before a flight work on: the open flight's, or what waits for the next one."""

from __future__ import annotations

import time
from collections.abc import Mapping

from calibration import load_certificates
from calibration.validity import CalibrationInForce
from calibration.wizard import has_unfinished_calibration
from gsapp.aircraft import Aircraft, load_aircraft
from gsapp.flight.folder import FlightFolder
from gsapp.flight.info import FlightInfo
from gsapp.flight.info_checks import check_flight_info
from gsapp.flight.toml_document import FlightInfoFile
from gsapp.foundation import GroundStationError
from gsapp.session import Session
from ui.disk_checks import may_block
from ui.preflight.calibration_controller import (
    CalibrationFolder,
    current_local_time,
    find_current_aircraft,
)
from ui.preflight.card_set_model import CardSetModel
from ui.preflight.checklist_model import ChecklistModel
from ui.preflight.flight_card_fields import card_state, describe_card_owner
from ui.preflight.form_editor import FormEditor
from ui.settings import SettingsStore, calibrations_path, checklist_path, next_flight_path
from ui.translation import tr
from ui.window_frame.page_steps import StepStatus

_CHECK_INTERVAL_SECONDS = 0.4


class PreflightModel:
    """Card, checklist and test cards that belong together."""

    def __init__(self, store: SettingsStore) -> None:
        self._store = store
        self.session: Session | None = None
        self.card: FormEditor[FlightInfo] | None = None
        self.card_owner_text = ""
        self.aircraft: Aircraft | None = None
        self.folder = next_flight_path(store.path)
        self.checklist = ChecklistModel(checklist_path(store.path))
        self.cards = CardSetModel()
        self._planned: CalibrationInForce | None = None
        self._calibration_problem = ""
        self._calibration_begun = False
        self._looked = 0.0

    def set_session(self, session: Session | None) -> None:
        """Take what belongs to another flight, or to the next one."""
        self.session = session
        own = session is not None and session.path.is_dir()
        self.folder = (
            session.path if session is not None and own else next_flight_path(self._store.path)
        )
        self.aircraft = self._aircraft_of(session)
        self.read_calibration()
        self.card = None
        folder = FlightFolder(path=self.folder)
        try:
            self.card = FormEditor(FlightInfoFile(folder))
            self.card_owner_text = describe_card_owner(
                self.card.file.model,
                session.name if session is not None else "",
                next_flight=not own,
                file_name=session.path.name if session is not None else "",
            )
        except GroundStationError:
            self.card_owner_text = tr(
                "The card {info_file} cannot be read; correct or remove that file, then return."
            ).format(info_file=folder.info_file)
            raise
        finally:
            self.cards.set_flight(session, self.folder, self.aircraft)
            self.checklist.set_flight(session, self.folder, self._info, self.aircraft)

    def _info(self) -> FlightInfo | None:
        """Return the card as it stands, what is being typed included."""
        return None if self.card is None else self.card.file.model

    def _aircraft_of(self, session: Session | None) -> Aircraft | None:
        if session is not None:
            return session.aircraft
        if may_block(self._store.current.aircraft):
            return None
        try:
            return load_aircraft(self._store.current.aircraft)
        except GroundStationError:
            # Said where an aircraft is connected with it.
            return None

    def update_checklist(self) -> None:
        """See how the checklist stands, a few times a second at most."""
        now = time.monotonic()
        if now - self._looked >= _CHECK_INTERVAL_SECONDS:
            self._looked = now
            self.checklist.update_items(self._store.current.units)

    def step_states(self) -> Mapping[str, StepStatus]:
        """Return how the steps stand."""
        return {
            "card": self._card_state(),
            "calibration": self._calibration_state(),
            "checklist": self.checklist.state,
            "cards": self.cards.state,
        }

    def read_calibration(self) -> None:
        """See which certificates are in force: for the open flight, or for those to come."""
        session, settings = self.session, self._store.current
        if session is None and may_block(settings.calibration):
            self._calibration_problem = tr(
                "{calibration} does not respond; choose other certificates when connecting"
            ).format(calibration=settings.calibration)
            return
        kept = calibrations_path(self._store.path)
        if may_block(kept):
            self._calibration_problem = tr("{kept} does not respond").format(kept=kept)
            return
        calibrations = CalibrationFolder(kept, find_current_aircraft(session, settings))
        self._planned, self._calibration_begun = (
            None,
            has_unfinished_calibration(calibrations.journal),
        )
        self._calibration_problem = ""
        try:
            failed = calibrations.store.failed_checks()
            if session is not None:
                session.failed_checks = failed
                return
            certificates = load_certificates(settings.calibration)
            planned = calibrations.load_plan_in_use().select_kinds(("surface", "vane")).channels
        except GroundStationError as error:
            self._calibration_problem = str(error)
            return
        self._planned = CalibrationInForce(
            certificates=certificates,
            flight_date=current_local_time(),
            missing=[name for name in planned if name not in certificates],
            failed_checks=failed,
        )

    def _calibration_state(self) -> StepStatus:
        in_force = self._planned if self.session is None else self.session.calibration_in_force
        if self._calibration_problem or in_force is None:
            detail = self._calibration_problem
            return StepStatus(state="warning", text=tr("cannot be read"), detail=detail)
        status = in_force.evaluate()
        begun = tr(". A calibration is not finished") if self._calibration_begun else ""
        return StepStatus(state=status.state, text=status.summary, detail=f"{status.detail}{begun}")

    def _card_state(self) -> StepStatus:
        card = self.card
        if card is None:
            return StepStatus(
                state="warning", text=tr("cannot be read"), detail=self.card_owner_text
            )
        info = card.file.model
        return card_state(
            info,
            tuple(card.problems.values()),
            check_flight_info(info, self.aircraft, system=self._store.current.units),
        )
