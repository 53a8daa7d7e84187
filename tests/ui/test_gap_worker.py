"""The process behind the page Model gap: jobs, progress, stopping, and what goes wrong."""

import os
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from pathlib import Path
from types import SimpleNamespace

import pytest

import gsapp.identification.maneuver
import ui.job_process.job_server
from gsapp.discrepancy.results import DiscrepancyResult, Observability
from gsapp.discrepancy.settings import (
    DiscrepancySettings,
    SearchProgress,
    SearchProgressCallback,
    SearchStoppedError,
)
from gsapp.foundation import FlightError
from tests.ui.gap_kit import ALPHA2, THROTTLE, make_answer, make_discrepancy
from tests.ui.window_kit import KILL
from ui.background_job import JobCanceledError
from ui.gap.gap_search import create_search_job_runner
from ui.gap.gap_text import (
    confidence_text,
    gap_closed_text,
    maneuver_kind_text,
    p_value_text,
    parameter_text,
    signed_number_text,
    verdict_state,
    verdict_text,
)
from ui.gap.gap_view_models import build_observability_rows
from ui.gap.search_jobs import GapReportJob, GapRequest, SearchResult, serve_gap_jobs
from ui.job_process.job_runner import JobError, ProcessJobRunner
from ui.job_process.job_server import JobProgressCallback, JobReport, StopEvent, serve_jobs
from ui.number_format import value_with_std_text
from ui.virtual_flight_simulation import find_virtual_flight_folder, simulate_virtual_flight


class FakeSearch:
    """Stands for a prepared search and remembers what it was told."""

    def __init__(self) -> None:
        self.settings: list[DiscrepancySettings] = []
        self.endless = False

    def run(
        self, settings: DiscrepancySettings, *, progress: SearchProgressCallback | None = None
    ) -> DiscrepancyResult:
        self.settings.append(settings)
        assert progress is not None
        step = 0
        while step < 3 or self.endless:
            if progress(SearchProgress(share=min(step / 3, 0.9), activity=f"step {step}")) is False:
                raise SearchStoppedError("stopped")
            step += 1
            time.sleep(0.002)
        return make_discrepancy(maneuvers=4)


class Bench:
    """`serve_gap_jobs` in a thread, with the pipe that the window would hold."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.search = FakeSearch()
        self.prepared: list[tuple[object, ...]] = []
        self.read: list[tuple[Path, ...]] = []
        self.maneuvers = [SimpleNamespace(id="1", inputs=("de",), kind="doublet")]
        self.stop = threading.Event()
        self.connection: Connection
        self.connection, theirs = Pipe()
        monkeypatch.setattr(
            gsapp.identification.maneuver, "open_flights_with_maneuvers", self._flown
        )
        # This process is that of all tests.
        monkeypatch.setattr(ui.job_process.job_server, "lower_priority", lambda _steps: None)
        self.thread = threading.Thread(
            target=serve_gap_jobs, args=(theirs, self.stop, self._prepare)
        )
        self.thread.start()

    def _flown(
        self, paths: tuple[Path, ...], _: object, *, doing: Callable[[str], object]
    ) -> tuple[object, ...]:
        self.read.append(paths)
        doing("reading flight 3")
        if "missing" in str(paths[0]):
            raise FlightError("there is no flight 'missing'")
        return (
            SimpleNamespace(
                flight=SimpleNamespace(name="flight 3"),
                aircraft=SimpleNamespace(name="B777"),
                maneuvers=tuple(self.maneuvers),
                remarks=("p clipped",),
            ),
        )

    def _prepare(self, *parts: object) -> FakeSearch:
        self.prepared.append(parts)
        return self.search

    def do(self, job: GapRequest | GapReportJob) -> list[JobReport]:
        self.connection.send(job)
        told = []
        while not told or told[-1].kind == "doing":
            assert self.connection.poll(20.0), "no word from the bench"
            told.append(self.connection.recv())
        return told

    def close(self) -> None:
        self.connection.close()
        self.thread.join(5.0)


@pytest.fixture
def bench(monkeypatch: pytest.MonkeyPatch) -> Iterator[Bench]:
    made = Bench(monkeypatch)
    yield made
    made.close()


def job(*, flight: str = "flight 3") -> GapRequest:
    return GapRequest(flights=(Path(flight),), model="b777")


def test_flights_are_read_once_and_decisions_reach_the_search(bench: Bench) -> None:
    told = bench.do(job())
    answer = told[-1].result
    assert isinstance(answer, SearchResult)
    assert answer.kinds == {"1": "de doublet"}
    assert (answer.remarks, answer.aircraft) == (("p clipped",), "B777")
    assert answer.effect_infos[THROTTLE].mistaken_for
    shares = [one.share for one in told if one.kind == "doing"]
    assert shares == sorted(shares)
    assert 0.0 <= shares[0] < shares[-1] <= 1.0
    assert "reading flight 3" in [one.text for one in told]
    bench.do(job().refuse(THROTTLE).force(ALPHA2))
    assert len(bench.read) == len(bench.prepared) == 1
    assert (bench.search.settings[1].refused, bench.search.settings[1].forced) == (
        (THROTTLE,),
        (ALPHA2,),
    )
    bench.do(job(flight="flight 4"))
    assert len(bench.read) == 2


def test_a_stop_is_obeyed_and_what_was_prepared_is_kept(bench: Bench) -> None:
    bench.search.endless = True
    bench.connection.send(job())
    while bench.connection.recv().text != "step 4":
        pass
    bench.stop.set()
    while (told := bench.connection.recv()).kind == "doing":
        pass
    assert told.kind == "stopped"
    bench.stop.clear()
    bench.search.endless = False
    assert bench.do(job())[-1].kind == "done"
    assert len(bench.read) == 1


def test_what_fails_is_told_with_its_reason(bench: Bench) -> None:
    told = bench.do(job(flight="missing"))[-1]
    assert (told.kind, told.is_expected) == ("failed", True)
    assert "'missing'" in told.text
    bench.maneuvers.clear()
    told = bench.do(job(flight="flight 5"))[-1]
    assert told.is_expected
    assert "doublets of elevator" in told.text
    bench.maneuvers.append(None)
    told = bench.do(job(flight="flight 6"))[-1]
    assert not told.is_expected
    assert "Traceback" in told.details


def test_the_report_is_written_with_the_files_it_came_from(bench: Bench, tmp_path: Path) -> None:
    flight = tmp_path / "flight.csv"
    flight.write_text("time [s],alpha [deg]\n0,1\n", encoding="utf-8")
    answer = make_answer(GapRequest(flights=(flight,), model="b777"))
    answer = replace(answer, discrepancy=make_discrepancy(maneuvers=2))
    told = bench.do(GapReportJob(result=answer, path=tmp_path / "gap.html", units="SI"))
    assert told[-1].result == tmp_path / "gap.html", told[-1].text
    text = (tmp_path / "gap.html").read_text(encoding="utf-8")
    assert "flight.csv" in text
    assert "Throttle pitches" in text


def test_a_process_of_its_own_fails_and_stops_in_words(tmp_path: Path) -> None:
    engine = create_search_job_runner()
    assert engine.pid is None
    heard: list[str] = []
    with pytest.raises(JobError, match="nowhere"):
        engine.do(job(flight=str(tmp_path / "nowhere")), lambda _share, words: heard.append(words))
    first = engine.pid
    assert first is not None
    assert heard[0] == "starting"

    def stop(_share: float | None, _words: str) -> None:
        raise JobCanceledError

    with pytest.raises(JobCanceledError):
        engine.do(job(flight=str(tmp_path / "nowhere")), stop)
    engine.close()


@pytest.mark.usefixtures("pipes_stay")
def test_a_process_that_dies_while_it_starts_is_missed(tmp_path: Path) -> None:
    engine = create_search_job_runner()
    late = time.monotonic() + 20.0

    def kill(_share: float | None, _words: str) -> None:
        assert time.monotonic() < late, "its death was not seen"
        if engine.pid is not None:
            os.kill(engine.pid, KILL)

    with pytest.raises(JobError, match="ended without a message"):
        engine.do(job(flight=str(tmp_path / "nowhere")), kill)
    assert engine.pid is None
    engine.close()


@pytest.mark.long
@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no named pipes here")
def test_a_process_that_does_not_obey_is_ended(tmp_path: Path) -> None:
    stuck = tmp_path / "stuck.csv"
    os.mkfifo(stuck)
    engine = create_search_job_runner()
    begun: list[float] = []

    def tell(_share: float | None, words: str) -> None:
        if words.startswith("reading"):
            begun.append(time.monotonic())
            if begun[-1] - begun[0] > 0.5:
                raise JobCanceledError

    with pytest.raises(JobCanceledError):
        engine.do(job(flight=str(stuck)), tell)
    assert time.monotonic() - begun[-1] < 8.0
    assert engine.pid is None


class _Writer:
    def __init__(self, tell: JobProgressCallback) -> None:
        self._tell = tell

    def do(self, job: Path) -> object:
        try:
            job.touch()
            while True:
                self._tell(None, "writing")
                time.sleep(0.01)
        finally:
            job.unlink()


def serve_writer(connection: Connection, stop: StopEvent) -> None:
    serve_jobs(connection, stop, _Writer)


@pytest.mark.long
def test_a_process_that_is_closed_leaves_nothing_half_written(tmp_path: Path) -> None:
    engine = ProcessJobRunner(serve_writer, name="writer", remedy="try again")
    half, ended = tmp_path / "half", threading.Event()
    told: list[BaseException] = []

    def tell(_share: float | None, _words: str) -> None:
        if ended.is_set():
            raise JobCanceledError

    def work() -> None:
        try:
            engine.do(half, tell)
        except BaseException as error:
            told.append(error)

    thread = threading.Thread(target=work)
    thread.start()
    deadline = time.monotonic() + 20.0
    while not half.exists():
        assert time.monotonic() < deadline
        time.sleep(0.01)
    ended.set()
    engine.close()
    thread.join(10.0)
    assert engine.pid is None
    assert not half.exists()
    assert [type(error) for error in told] == [JobCanceledError]


def test_a_trial_flight_stops_when_it_is_not_wanted_any_more(tmp_path: Path) -> None:
    from datetime import date

    folder = find_virtual_flight_folder(tmp_path, date(2026, 5, 12))
    assert folder.name == "2026-05-12 trial 1"
    folder.mkdir()
    assert find_virtual_flight_folder(tmp_path, date(2026, 5, 12)).name == "2026-05-12 trial 2"

    flying = []

    def tell(_share: float | None, _words: str) -> None:
        # Not before it has begun to write.
        flying.extend(tmp_path.glob(".never.*/.never.*/flight.toml"))
        if flying:
            raise JobCanceledError

    with pytest.raises(JobCanceledError):
        simulate_virtual_flight(tmp_path / "never", tell)
    assert flying
    assert [one.name for one in tmp_path.iterdir()] == [folder.name]


# Words


@pytest.mark.parametrize(
    ("value", "std", "text"),
    [(-0.0412, 0.0013, "−0.0412 ± 0.0013"), (-22.6, 0.42, "−22.60 ± 0.42"),
     (1234.5, 120.0, "1234 ± 120"), (0.5, 0.0, "0.500"), (float("nan"), 1.0, "–")],
)  # fmt: skip
def test_a_value_has_the_digits_that_its_bound_earns(value: float, std: float, text: str) -> None:
    assert value_with_std_text(value, std) == text


def test_numbers_in_words() -> None:
    assert parameter_text(0.0105, 0.0006, "rad", "US") == "0.602 ± 0.034 °"
    assert parameter_text(0.3048, 0.03048, "m", "US") == "1.00 ± 0.10 ft"
    assert signed_number_text(5053.6, 1) == "+5,054"
    assert signed_number_text(-0.04, 1) == "0.0"
    assert p_value_text(1e-9) == "chance below 1 in a million"
    assert p_value_text(0.00033) == "chance 1 in 3,000"
    assert "94 ± 3 %" in gap_closed_text(0.943, 0.031)
    assert "%" not in gap_closed_text(None, None)
    assert maneuver_kind_text("da+dr doublet") == "aileron+rudder doublet"


@pytest.mark.parametrize(
    ("verdict", "state", "words"),
    [("effects-found", "caution", "Two effects are missing"),
     ("values-wrong", "caution", "1 value must change"),
     ("model-adequate", "good", "No effect is missing"),
     ("ambiguous", "unknown", "cannot tell which"),
     ("unexplained", "warning", "not in the catalog"),
     ("not-observable", "unknown", "cannot show")],
)  # fmt: skip
def test_every_verdict_has_a_headline_and_a_state(verdict: str, state: str, words: str) -> None:
    answer = replace(make_answer(), discrepancy=make_discrepancy(verdict=verdict, maneuvers=2))
    assert words in verdict_text(answer)
    assert verdict_state(answer.discrepancy) == state


def test_what_only_the_ground_can_settle_is_said_so() -> None:
    seen = Observability(
        effect="mass.cg.x", effect_class="C", sigma=0.0, sigma_size=1.0, fly="weigh the aircraft"
    )
    found = replace(make_discrepancy(maneuvers=2), observability=(seen,))
    line = build_observability_rows(replace(make_answer(), discrepancy=found), hidden_only=True)[0]
    assert line.cells[1:] == ("on the ground only", "weigh the aircraft")


def test_nothing_is_ever_called_certain() -> None:
    assert "95 of 100" in confidence_text(0.95)
    assert "62 of 100" in confidence_text(0.62)
