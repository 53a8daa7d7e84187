"""Fits of a flight's maneuvers while it goes on: the same numbers wherever they are made."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gsapp.aircraft import load_aircraft
from gsapp.dynamics.model import load_model
from gsapp.excitation.doublets.verdict import InputVerdict
from gsapp.flight import load_flight
from gsapp.flight.info import FlightInfo
from gsapp.flight.writers import write_block
from gsapp.identification.campaign import CampaignResult
from gsapp.identification.maneuver import cut_maneuver, mass_over_flight
from gsapp.session import Session
from gsapp.session.live_estimation.estimate_monitor import ManeuverCutter
from gsapp.session.live_estimation.fit_workers import FitWorker, InlineFitWorker, ProcessFitWorker
from gsapp.session.live_estimation.maneuver_fits import (
    FitRequest,
    FitResponse,
    ManeuverFits,
    run_fit_request,
)
from gsapp.session.replay_runner import run_replay
from gsapp.virtual.virtual_flight import VirtualFlight

LATE = 1800.0
"""Seconds."""
# Windows has no SIGKILL; there SIGTERM leaves a process no time either.
KILL = getattr(signal, "SIGKILL", signal.SIGTERM)

TRUTH = load_model("b777")


@pytest.fixture(scope="module")
def flown(flown_short: Callable[[int], VirtualFlight]) -> VirtualFlight:
    return flown_short(6)


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory, flown: VirtualFlight):
    path = write_block(tmp_path_factory.mktemp("fits") / "flight.csv", flown.measured, "csv")
    made = Session.replay(path, aircraft="b777", speed=np.inf, cues=False)
    run_replay(made)
    yield made
    made.close()


@pytest.fixture(scope="module")
def late_session(tmp_path_factory: pytest.TempPathFactory, flown: VirtualFlight):
    measured = replace(flown.measured, times=flown.measured.times + LATE)
    path = write_block(tmp_path_factory.mktemp("late") / "flight.csv", measured, "csv")
    made = Session.replay(path, aircraft="b777", speed=np.inf, cues=False)
    run_replay(made)
    yield made
    made.close()


@pytest.fixture(scope="module")
def verdicts(flown: VirtualFlight) -> tuple[InputVerdict, ...]:
    return tuple(
        InputVerdict(
            id=f"M{number}", given_at=one.t_end, t_start=one.t_start - 1.0, t_input=one.t_start,
            t_input_end=one.t_start + 1.0, t_end=one.t_end - 0.2, surfaces=one.inputs,
            kind=one.kind, amplitudes={}, halves={}, symmetry={}, left_over={}, cross={}, V=None,
            alpha=None, result="good", findings=(), advice="good",
        )
        for number, one in enumerate(flown.maneuvers, start=1)
    )  # fmt: skip


def fits_of(session: Session, workers: FitWorker) -> ManeuverFits:
    assert session.aircraft is not None
    cut = ManeuverCutter(session.history, session.aircraft, lambda: None, session.name)
    return ManeuverFits(cut, TRUTH, workers)


def numbers(result: CampaignResult) -> list[tuple[str, str, float | None]]:
    return [
        (one.maneuver.id, name, found.value)
        for one in result.results
        if one.estimate is not None
        for name, found in one.estimate.derivatives.items()
    ]


def test_fits_come_after_each_maneuver_and_are_the_same_anywhere(
    session: Session, verdicts: tuple[InputVerdict, ...]
) -> None:
    here, there = fits_of(session, InlineFitWorker()), fits_of(session, ProcessFitWorker())
    assert here.update(verdicts[:1], verdicts[0].t_end + 2.0) == ()
    (news,) = here.update(verdicts[:1], verdicts[0].t_end + 3.5)
    assert (news.maneuver, news.failure) == ("M1", "")
    assert [one.maneuver for one in here.update(verdicts, None)] == ["M2"]
    found = here.result
    for name in ("Cm_de", "Cl_da", "Cn_dr"):
        value = found.values[name]
        assert value.mean == pytest.approx(TRUTH.derivative(name), rel=0.05)
    assert there.update(verdicts, None) == ()
    assert there.pending == 2
    assert {one.maneuver for one in there.wait()} == {"M1", "M2"}
    assert numbers(there.result) == numbers(found)
    assert not there._asked  # samples of a maneuver are kept once
    here.close()
    there.close()


@pytest.mark.parametrize(("box", "begin"), [("session", 0.0), ("late_session", LATE)])
def test_the_cut_is_that_of_the_whole_flight(
    box: str, begin: float, request: pytest.FixtureRequest, verdicts: tuple[InputVerdict, ...]
) -> None:
    """Samples and mass as `gsapp estimate` cuts them from the file, however long the box was on."""
    session: Session = request.getfixturevalue(box)
    verdict = verdicts[1]
    begin += 0.004  # between two samples, where no rounding decides which are in
    verdict = replace(
        verdict, t_start=verdict.t_start + begin, t_input=verdict.t_input + begin,
        t_input_end=verdict.t_input_end + begin, t_end=verdict.t_end + begin,
    )  # fmt: skip
    assert session.aircraft is not None
    cut = ManeuverCutter(session.history, session.aircraft, lambda: None, session.name)(verdict)
    whole = cut_maneuver(
        load_flight(session.path), load_aircraft("b777"), verdict.t_start, verdict.t_end,
        id=verdict.id, inputs=("da", "dr"),
    )  # fmt: skip
    assert set(whole.block.channels) <= set(cut.block.channels)
    for name in ("p", "beta", "ay", "V", "dr"):
        np.testing.assert_array_equal(cut.block[name], whole.block[name])
    assert cut.mass == pytest.approx(whole.mass, abs=0.01)


def test_fuel_is_counted_once_and_by_the_throttle(
    session: Session, verdicts: tuple[InputVerdict, ...]
) -> None:
    """Maneuver after maneuver, one alone, one again; what is left after landing says nothing."""
    aircraft = session.aircraft
    assert aircraft is not None
    whole = mass_over_flight(load_flight(session.path), aircraft)
    info = FlightInfo(takeoff_weight=f"{whole[0] * 9.80665} N", landing_weight=f"{whole[0]} N")
    cut = ManeuverCutter(session.history, aircraft, lambda: info, session.name)
    masses = [cut(one).mass for one in (*verdicts, verdicts[0])]
    assert masses[0] > masses[1]
    assert masses[2] == pytest.approx(masses[0], abs=1e-9)
    alone = ManeuverCutter(session.history, aircraft, lambda: None, session.name)(verdicts[1]).mass
    assert masses[1] == pytest.approx(alone, abs=1e-9)
    at = np.searchsorted(load_flight(session.path).block.times, verdicts[1].t_input) - 1
    assert alone == pytest.approx(whole[at], abs=1e-6)


def die_of_the_first(request: FitRequest) -> FitResponse:
    if request.maneuver.id == "M1":
        os._exit(1)
    return run_fit_request(request)


@pytest.mark.long
def test_a_worker_that_dies_costs_its_fit_alone(
    session: Session, verdicts: tuple[InputVerdict, ...]
) -> None:
    fits = fits_of(session, ProcessFitWorker(die_of_the_first))
    fits.update(verdicts[:1], None)
    # The process yields to all others: on a busy machine it takes long even to begin.
    until = time.monotonic() + 120.0
    while fits.pending and time.monotonic() < until:
        fits.update(verdicts[:1], None)
        time.sleep(0.02)
    assert "failed" in fits.failures["M1"]
    assert fits.result.results == ()
    fits.update(verdicts, None)
    fits.wait()
    assert set(fits.failures) == {"M1"}
    assert [one.maneuver.id for one in fits.result.results] == ["M2"]
    fits.close()


@pytest.mark.long
def test_a_worker_ends_with_a_window_that_was_killed() -> None:
    code = (
        "import time; from gsapp.session.live_estimation.fit_workers import ProcessFitWorker\n"
        "workers = ProcessFitWorker(time.sleep)\n"
        "workers.submit(0.0).result()\n"
        "print('at work', flush=True); time.sleep(300.0)\n"
    )
    window = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE)
    assert window.stdout.readline().strip() == b"at work"
    window.kill()
    assert window.communicate(timeout=240.0)[0] == b""


@pytest.mark.long
def test_a_fit_that_runs_does_not_hold_up_the_end_of_the_program() -> None:
    code = (
        "import time; from gsapp.session.live_estimation.fit_workers import ProcessFitWorker\n"
        "workers = ProcessFitWorker(time.sleep)\n"
        "running = workers.submit(120.0)\n"
        "while not running.running(): time.sleep(0.01)\n"
        "workers.close()\n"
    )
    began = time.monotonic()
    subprocess.run([sys.executable, "-c", code], check=True, timeout=100.0)
    assert time.monotonic() - began < 60.0


def die_once(request: FitRequest) -> FitResponse:
    mark = Path(os.environ["GSAPP_TEST_DIED"])
    if not mark.exists():
        mark.touch()
        os.kill(os.getpid(), KILL)
    return run_fit_request(request)


def test_a_fit_whose_worker_was_killed_is_made_anew(
    session: Session,
    verdicts: tuple[InputVerdict, ...],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("GSAPP_TEST_DIED", str(tmp_path / "died"))
    fits = fits_of(session, ProcessFitWorker(die_once))
    fits.update(verdicts, None)
    fits.wait()
    assert (tmp_path / "died").exists()
    assert fits.failures == {}
    here = fits_of(session, InlineFitWorker())
    here.update(verdicts, None)
    assert numbers(fits.result) == numbers(here.result)
    fits.close()


def test_what_was_invalid_is_not_fitted_and_a_reset_forgets(
    session: Session, verdicts: tuple[InputVerdict, ...]
) -> None:
    fits = fits_of(session, InlineFitWorker())
    first, second = verdicts
    fits.update((replace(first, result="invalid"), second), None)
    assert [one.maneuver.id for one in fits.result.results] == ["M2"]
    fits.reset()
    assert fits.result.results == ()
    fits.update((first,), None)
    assert [one.maneuver.id for one in fits.result.results] == ["M1"]
    away = replace(second, t_start=9e3, t_input=9e3 + 1.0, t_end=9e3 + 5.0)
    fits.update((first, away), None)
    assert "no response" in fits.failures["M2"]
