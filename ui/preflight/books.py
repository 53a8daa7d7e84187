"""What the steps before a flight work on: the open flight's, or what waits for the next one."""

from __future__ import annotations

from collections.abc import Mapping

from gsapp.aircraft import Aircraft, load_aircraft
from gsapp.flight.card_checks import check_card
from gsapp.flight.card_file import CardFile
from gsapp.flight.folder import FlightFolder
from gsapp.foundation import GroundStationError
from gsapp.session import Session
from ui.preflight.card_editor import CardEditor
from ui.preflight.card_words import card_state, home_words
from ui.preflight.steps import StepState
from ui.settings import SettingsStore, next_flight_path


class Books:
    """Card, checklist and test cards that belong together.

    Parameters
    ----------
    store : SettingsStore
        Beside it lies what waits for the next flight; names the aircraft where no flight does.

    Attributes
    ----------
    card : CardEditor or None
        None where the card cannot be read.
    home : str
        Whose card that is, in words.
    aircraft : Aircraft or None
        What it is held against.
    folder : Path
        Where everything lies.
    """

    def __init__(self, store: SettingsStore) -> None:
        self._store = store
        self.session: Session | None = None
        self.card: CardEditor | None = None
        self.home = ""
        self.aircraft: Aircraft | None = None
        self.folder = next_flight_path(store.path)

    def follow(self, session: Session | None) -> None:
        """Take what belongs to another flight, or to the next one.

        Raises
        ------
        GroundStationError
            If the card holds mistakes; there is none then.
        """
        self.session = session
        own = session is not None and session.path.is_dir()
        self.folder = (
            session.path if session is not None and own else next_flight_path(self._store.path)
        )
        self.aircraft = self._aircraft_of(session)
        self.home = home_words(
            session.name if session is not None else "",
            next_flight=not own,
            file_name=session.path.name if session is not None else "",
        )
        self.card = None
        try:
            self.card = CardEditor(CardFile(FlightFolder(path=self.folder)))
        except GroundStationError:
            self.home = (
                f"The card {FlightFolder(path=self.folder).info_file} cannot be read; mend or "
                "remove that file, then come back."
            )
            raise

    def _aircraft_of(self, session: Session | None) -> Aircraft | None:
        if session is not None:
            return session.aircraft
        try:
            return load_aircraft(self._store.current.aircraft)
        except GroundStationError:
            # Said where an aircraft is connected with it.
            return None

    def states(self) -> Mapping[str, StepState]:
        """Return how the steps stand."""
        return {"card": self._card_state()}

    def _card_state(self) -> StepState:
        card = self.card
        if card is None:
            return StepState(state="warning", words="cannot be read", detail=self.home)
        info = card.file.info
        return card_state(info, tuple(card.problems.values()), check_card(info, self.aircraft))
