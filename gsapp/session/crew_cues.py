"""What the crew is told by the cues of a session, and chooses for them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from gsapp.excitation.announcer import Announcement
from gsapp.excitation.cues import CueSnapshot
from gsapp.flight.cards import CardSet
from gsapp.flight.folder import FlightFolder
from gsapp.session.cue_monitor import CueMonitor
from gsapp.session.file_worker import FileWorker
from gsapp.session.flight_metadata import FlightMetadata

if TYPE_CHECKING:
    from gsapp.excitation.debrief import Debrief


class CrewCues:
    """Cues of a session; empty where the options switch them off."""

    def __init__(
        self,
        monitor: CueMonitor | None,
        metadata: FlightMetadata,
        folder: FlightFolder | None,
        worker: FileWorker | None,
    ) -> None:
        self._monitor = monitor
        self._metadata = metadata
        self._folder = folder
        self._worker = worker

    def snapshot(self) -> CueSnapshot | None:
        """Return what the crew is to be told now; None where cues are switched off."""
        if self._monitor is None:
            return None
        return self._monitor.snapshot(
            self._metadata.uncalibrated, self._metadata.out_of_calibrated_range
        )

    @property
    def spoken(self) -> Sequence[Announcement]:
        """Return all that is to be heard so far; it shrinks only when a replay goes back."""
        return () if self._monitor is None else self._monitor.spoken

    @property
    def cards(self) -> CardSet | None:
        return None if self._monitor is None else self._monitor.cueing.cards

    def debrief(self) -> Debrief | None:
        """Return every input judged so far, and the score by card; None without cues."""
        if self._monitor is None:
            return None
        from gsapp.excitation.debrief import create_debrief

        return create_debrief(self._metadata.name, self._monitor.cueing)

    def select_card(self, card_id: str) -> None:
        """Let a test card be the next until it is flown; an empty id lets the program pick.

        A live flight keeps the choice among its events, so that a replay tells the same.

        Raises
        ------
        UnknownNameError
            If there is no such card.
        FlightError
            If it cannot be written.
        """
        if self._monitor is not None:
            self._monitor.select_card(card_id)

    def set_units(self, system: str) -> None:
        """Give cues in these units, ``US`` or ``SI``, from now on."""
        if self._monitor is not None:
            self._monitor.cueing.use_units(system)

    def set_cards(self, cards: CardSet) -> None:
        """Take other test cards; a live flight without any keeps them in its folder.

        Raises
        ------
        FlightError
            If they cannot be written; they count in this window.
        """
        if self._monitor is None:
            return
        self._monitor.cueing.use_cards(cards)
        folder = self._folder
        if folder is None:
            return

        def store() -> None:
            if not folder.cards_file.exists():
                folder.store_cards(cards)

        if self._worker is None:
            store()
        else:
            self._worker.run_job(store)
