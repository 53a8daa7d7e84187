"""The kept runs of the catalog as the window knows them; read and changed in a thread."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Signal

from ui.review.deeds import Deeds
from ui.work import Progress, Work

if TYPE_CHECKING:
    # The window starts without the numerics behind a run.
    from gsapp.flight.catalog import Catalog
    from gsapp.identification.runs.keeping import KeptRun
    from gsapp.identification.runs.outcome import Outcome

Act = Callable[["Catalog"], object]


class RunsBook(QObject):
    """Lists, renames and forgets kept runs.

    Parameters
    ----------
    catalog : callable
        Returns where the catalog is.
    report_error : callable
        Where errors go.
    deeds : Deeds
        Where changes are noted.

    Attributes
    ----------
    changed : Signal
        Other runs are known now.
    runs : tuple of KeptRun
        The newest first.
    unread : str
        Why they could not be read; empty where they were.
    """

    changed = Signal()

    def __init__(
        self,
        catalog: Callable[[], Path],
        report_error: Callable[[BaseException], None],
        deeds: Deeds,
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self._catalog = catalog
        self._report_error = report_error
        self._deeds = deeds
        self._work: Work | None = None
        self._waiting: list[Act | None] = []
        self._only_reads = True
        self.runs: tuple[KeptRun, ...] = ()
        self.unread = ""

    @property
    def catalog(self) -> Path:
        """Return where the catalog is."""
        return self._catalog()

    def run(self, number: int | None) -> KeptRun | None:
        """Return a run by its number; None if it is not known."""
        return next((one for one in self.runs if one.number == number), None)

    def read(self) -> None:
        """Read the runs anew."""
        self._do(None)

    def rename(self, number: int, label: str) -> None:
        """Call a run something else."""
        before = self.run(number)
        if before is None or before.label == label.strip():
            return
        former = before.label
        self._rename(number, label)
        self._deeds.record(
            lambda: self._rename(number, former), lambda: self._rename(number, label)
        )

    def forget(self, number: int) -> None:
        """Leave a run out; it can be brought back."""
        if self.run(number) is None:
            return
        self._forget(number)
        self._deeds.record(lambda: self._recall(number), lambda: self._forget(number))

    def renew(self, outcome: Outcome) -> None:
        """Keep the means of a kept run as they are now."""
        if outcome.number is None:
            return

        def act(catalog: Catalog) -> None:
            from gsapp.identification.runs.keeping import renew

            renew(catalog, outcome)

        self._do(act)

    def _rename(self, number: int, label: str) -> None:
        def act(catalog: Catalog) -> None:
            from gsapp.identification.runs.keeping import rename

            rename(catalog, number, label)

        self._do(act)

    def _forget(self, number: int) -> None:
        def act(catalog: Catalog) -> None:
            from gsapp.identification.runs.keeping import forget

            forget(catalog, number)

        self._do(act)

    def _recall(self, number: int) -> None:
        def act(catalog: Catalog) -> None:
            from gsapp.identification.runs.keeping import recall

            recall(catalog, number)

        self._do(act)

    def _do(self, act: Act | None) -> None:
        """Change something, if asked, and read anew; one after the other."""
        self._waiting.append(act)
        self._next()

    def _next(self) -> None:
        if self._work is not None or not self._waiting:
            return
        act, path = self._waiting.pop(0), self.catalog
        self._only_reads = act is None

        def run(_progress: Progress) -> tuple[KeptRun, ...]:
            if not path.is_file():
                return ()
            from gsapp.flight.catalog import Catalog
            from gsapp.identification.runs.keeping import kept_runs

            with Catalog(path) as catalog:
                if act is not None:
                    act(catalog)
                return kept_runs(catalog)[::-1]

        work = Work("Reading the kept runs", run, self)
        self._work = work
        work.done.connect(self._read)
        work.failed.connect(self._failed)
        work.start()

    def _read(self, runs: tuple[KeptRun, ...]) -> None:
        self._work = None
        self.runs, self.unread = runs, ""
        self.changed.emit()
        self._next()

    def _failed(self, error: BaseException) -> None:
        self._work = None
        if self._only_reads:
            self.unread = str(error)
            self.changed.emit()
        self._report_error(error)
        self._next()
