"""The kept runs as the window knows them: means changed in the figures are kept with their run."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from gsapp.flight.catalog import Catalog
from gsapp.identification.runs.excluding import excluding
from gsapp.identification.runs.keeping import keep
from gsapp.identification.runs.request import RunRequest
from gsapp.identification.runs.running import run
from tests.identification.runs_kit import WINDOWS, write_flights
from ui.review.deeds import Deeds
from ui.review.runs_book import RunsBook


def test_a_maneuver_left_out_is_kept_with_the_run(qtbot, tmp_path: Path) -> None:
    """What the figures leave out stands in the catalog and in the list; taken in again, it goes."""
    outcome = run(RunRequest(flights=write_flights(tmp_path), given=WINDOWS))
    path = tmp_path / "c.sqlite"
    with Catalog(path) as catalog:
        outcome = replace(outcome, number=keep(catalog, outcome))
    errors: list[BaseException] = []
    book = RunsBook(lambda: path, errors.append, Deeds())
    with qtbot.waitSignal(book.changed, timeout=20_000):
        book.renew(excluding(outcome, ["1:1"]))
    (shown,) = book.runs
    assert shown.settings["left out of the means"] == "1:1"
    assert shown.values["Cm_q"].n == 1
    with qtbot.waitSignal(book.changed, timeout=20_000):
        book.renew(excluding(outcome, []))
    assert book.runs[0].values["Cm_q"].n == 2
    # A run that was not kept changes nothing.
    book.renew(replace(excluding(outcome, ["2:1"]), number=None))
    with qtbot.waitSignal(book.changed, timeout=20_000):
        book.read()
    assert book.runs[0].values["Cm_q"].n == 2
    assert errors == []
