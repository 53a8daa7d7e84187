"""The test cards of a flight: planned, changed, and compared with what was flown. No Qt."""

from __future__ import annotations

from pathlib import Path

from gsapp.aircraft import Aircraft
from gsapp.flight.cards import CardProgress, CardSet, CardSetProgress, match_cards, shipped_cards
from gsapp.flight.file_names import CARDS_FILE
from gsapp.flight.flight import Flight
from gsapp.flight.maneuvers import DetectedManeuver, collect_maneuvers
from gsapp.flight.toml_document import CardSetFile
from gsapp.foundation import FlightError, GroundStationError
from gsapp.session import Session
from ui.preflight.card_editor_fields import find_cards_state
from ui.preflight.form_editor import FormEditor
from ui.translation import tr
from ui.window_frame.page_steps import StepStatus

_CARDS = ("cards",)


class CardSetModel:
    """One set of cards.

    Attributes
    ----------
    editor : FormEditor or None
        The cards and what is being typed into them; None where they cannot be read.
    session : Session or None
        The open flight.
    flown : CardSetProgress or None
        What was flown for them; None before anybody looked.
    read_error : str
        Why the cards cannot be read.
    """

    def __init__(self) -> None:
        self.editor: FormEditor[CardSet] | None = None
        self.session: Session | None = None
        self.flown: CardSetProgress | None = None
        self.read_error = ""
        self._aircraft: Aircraft | None = None
        self._maneuvers: tuple[DetectedManeuver, ...] | None = None

    def set_flight(self, session: Session | None, folder: Path, aircraft: Aircraft | None) -> None:
        """Take the cards of another flight, or of the next one."""
        self.session, self._aircraft = session, aircraft
        self.flown = self._maneuvers = None
        self.read_error = ""
        names = shipped_cards()
        name = "" if aircraft is None else aircraft.name.casefold()
        try:
            file = CardSetFile(folder / CARDS_FILE, name if name in names else names[0])
        except GroundStationError as error:
            self.editor = None
            self.read_error = str(error)
        else:
            self.editor = FormEditor(file)

    @property
    def file(self) -> CardSetFile | None:
        """Return the file of the cards."""
        file = None if self.editor is None else self.editor.file
        return file if isinstance(file, CardSetFile) else None

    @property
    def cards(self) -> CardSet | None:
        """Return the cards as they stand."""
        return None if self.editor is None else self.editor.file.model

    @property
    def state(self) -> StepStatus:
        """Return how the step stands."""
        if self.editor is None:
            return StepStatus(state="warning", text=tr("cannot be read"), detail=self.read_error)
        file = self.editor.file
        problems = tuple(self.editor.problems.values())
        flies = self.session is not None
        return find_cards_state(
            file.model, self.flown, problems, own=file.path.exists(), flies=flies
        )

    def progress(self, card_id: str) -> CardProgress | None:
        """Return what was flown for a card; None before anybody looked."""
        found = () if self.flown is None else self.flown.cards
        return next((one for one in found if one.card.id == card_id), None)

    # Changes

    def add(self, row: int) -> int:
        """Put a copy of a card below it; return where it stands."""
        file, editor = self.file, self.editor
        if file is not None and editor is not None:
            editor.set_values({_CARDS: file.with_duplicated_row(row)})
        return row + 1

    def remove(self, row: int) -> bool:
        """Take a card out; return whether it could go: the last one stays."""
        file, editor = self.file, self.editor
        if file is None or editor is None or len(file.rows) < 2:
            return False
        rows = file.rows
        del rows[row]
        return editor.set_values({_CARDS: rows})

    def move(self, row: int, steps: int) -> int:
        """Move a card up or down; return where it stands now."""
        file, editor = self.file, self.editor
        if file is None or editor is None:
            return row
        rows = file.rows
        target = min(max(row + steps, 0), len(rows) - 1)
        if target != row:
            rows.insert(target, rows.pop(row))
            editor.set_values({_CARDS: rows})
        return target

    def import_cards(self, path: Path) -> None:
        """Take the set of another file in place of this one; it can be taken back.

        Raises
        ------
        FileProblemsError
            If that file holds mistakes.
        """
        if self.editor is not None:
            content = CardSetFile(path, "").content
            keys = dict.fromkeys((*self.editor.file.content, *content))
            self.editor.set_values({(key,): content.get(key) for key in keys})

    # What was flown

    def loadable_flight(self) -> Flight | None:
        """Return the open flight up to now, to be searched; None where there is nothing."""
        session = self.session
        if session is None or self._aircraft is None or session.now is None:
            return None
        flight = session.flight()
        return flight if len(flight.block) else None

    def find_maneuvers(self, flight: Flight) -> tuple[DetectedManeuver, ...]:
        """Return the maneuvers of a flight; for the thread of a work."""
        if self._aircraft is None:
            return ()
        try:
            return collect_maneuvers(flight, self._aircraft).maneuvers
        except FlightError:
            # Nothing that moves was measured yet.
            return ()

    def set_maneuvers(self, maneuvers: tuple[DetectedManeuver, ...]) -> None:
        """Compare the cards with what was flown."""
        self._maneuvers = maneuvers
        self.compare_with_flight()

    def compare_with_flight(self) -> None:
        """Compare again, after the cards were changed."""
        cards = self.cards
        if self._maneuvers is not None and cards is not None:
            self.flown = match_cards(cards, self._maneuvers)
