"""The kept runs as the window knows them: means changed in the figures are kept with their run."""

from dataclasses import replace
from pathlib import Path

from gsapp.flight.catalog import Catalog
from gsapp.identification.runs.request import RunRequest
from gsapp.identification.runs.run_execution import exclude_maneuvers, execute_run
from gsapp.identification.runs.run_store import save_run
from tests.identification.runs_kit import WINDOWS, write_flights
from ui.review.run_store import RunStore
from ui.undo import UndoStack


def test_a_maneuver_left_out_is_kept_with_the_run(qtbot, tmp_path: Path) -> None:
    """What the figures leave out stands in the catalog and in the list; taken in again, it goes."""
    outcome = execute_run(RunRequest(flights=write_flights(tmp_path), maneuver_windows=WINDOWS))
    path = tmp_path / "c.sqlite"
    with Catalog(path) as catalog:
        outcome = replace(outcome, number=save_run(catalog, outcome))
    errors: list[BaseException] = []
    book = RunStore(lambda: path, errors.append, UndoStack())
    with qtbot.waitSignal(book.changed, timeout=20_000):
        book.update_means(exclude_maneuvers(outcome, ["1:1"]))
    (shown,) = book.runs
    assert shown.settings["left out of the means"] == "1:1"
    assert shown.values["Cm_q"].n == 1
    with qtbot.waitSignal(book.changed, timeout=20_000):
        book.update_means(exclude_maneuvers(outcome, []))
    assert book.runs[0].values["Cm_q"].n == 2
    # A run that was not kept changes nothing.
    book.update_means(replace(exclude_maneuvers(outcome, ["2:1"]), number=None))
    with qtbot.waitSignal(book.changed, timeout=20_000):
        book.reload()
    assert book.runs[0].values["Cm_q"].n == 2
    assert errors == []
