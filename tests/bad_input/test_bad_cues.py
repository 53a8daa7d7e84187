"""Cues of flights with bad instruments or little known: what can be judged is, the rest is said."""

import math
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from calibration.certificate_toml import certificate_paths
from gsapp.excitation.cueing import CueGenerator
from gsapp.excitation.cueing.cue_generator import NO_AIRCRAFT, NO_CARDS, NO_MODEL
from gsapp.flight.folder import FlightFolder
from gsapp.quantities import Block
from gsapp.session import UNLIMITED_SPEED, Session
from gsapp.session.replay_runner import run_replay
from tests.excitation.cue_kit import CARDS, Record, cueing, feed, flown, part

SURFACES = (
    "elevator_left", "elevator_right", "aileron_left", "aileron_right", "rudder", "de", "da", "dr",
)  # fmt: skip
FLOW = ("alpha", "beta", "dynamic_pressure", "static_pressure")


def without(block: Block, *names: str) -> Block:
    kept = [name for name in block.channels if name not in names]
    return part(block, 0, len(block), kept)


def changed(block: Block, name: str, change: Callable[[np.ndarray], None]) -> Block:
    values = block.values.copy()
    change(values[:, block.channels.index(name)])
    return Block(channels=block.channels, times=block.times, values=values)


def judged(block: Block, **known: object) -> CueGenerator:
    cuts = range(0, len(block), 97)
    return feed(cueing(**{"model": None, **known}), block, cuts)


def states(cues: CueGenerator) -> set[str]:
    return {event.state for event in cues.log if event.kind == "trim"}


def said(cues: CueGenerator) -> str:
    snapshot = cues.snapshot()
    doubts = [text for verdict in cues.verdicts for text in verdict.judged_by]
    return "; ".join((*snapshot.limitations, *snapshot.judged_by, *doubts))


def test_no_aircraft_no_model_no_cards() -> None:
    cues = judged(flown(), aircraft=None, cards=None)
    assert "go" in states(cues)
    assert len(cues.verdicts) == 1
    missing = cues.snapshot().limitations
    assert {NO_AIRCRAFT, NO_MODEL, NO_CARDS} <= set(missing)
    assert cues.snapshot().card is None


def test_no_aircraft_but_cards() -> None:
    cues = judged(flown(), aircraft=None)
    picked = cues.snapshot().card
    assert picked.stick_text["de"].endswith("deg")
    assert cues.verdicts[0].card == "E1"


def test_no_model() -> None:
    cues = judged(flown())
    assert cues.verdicts[0].result == "good"
    outlook = cues.snapshot().outlook
    assert outlook is None or outlook.best_forecast is None
    assert NO_MODEL in cues.snapshot().limitations


def test_no_attitude() -> None:
    cues = judged(without(flown(), "phi", "theta", "psi"))
    assert "go" in states(cues)
    assert cues.verdicts[0].result == "good"
    assert "wings: " in said(cues)
    assert "wings: attitude" not in said(cues)


def test_surfaces_uncalibrated() -> None:
    cues = judged(without(flown(), *SURFACES))
    assert "go" in states(cues)
    assert cues.snapshot().unmeasured_surfaces == ("de", "da", "dr")
    assert cues.verdicts == ()
    assert not any(event.kind == "input" for event in cues.log)


def test_surfaces_uncalibrated_is_said(tmp_path: Path) -> None:
    folder = FlightFolder.create(tmp_path / "flight")
    folder.store_cards(CARDS)
    record = Record(folder.path, flown())
    record.write(400)
    record.close()
    some = tmp_path / "some"
    some.mkdir()
    for path in certificate_paths("b777"):
        if not path.stem.startswith(SURFACES[:5]):
            shutil.copy(path, some)
    session = Session.replay(
        folder.path, channel_map="b777", aircraft="b777", certificates=some, speed=UNLIMITED_SPEED
    )
    run_replay(session)
    cues = session.cues
    assert "not calibrated" in cues.limitations[0]
    assert "levator" in cues.limitations[0]
    session.close()


def test_nose_sensors_missing() -> None:
    cues = judged(without(flown(), *FLOW))
    assert "blind" not in {event.state for event in cues.log if event.time > 3.0}
    assert "speed" in said(cues)
    assert cues.snapshot().speed is None
    assert cues.snapshot().alpha is None


def test_no_rates_at_all_is_blind() -> None:
    cues = judged(without(flown(), "p", "q", "r"))
    assert states(cues) == {"blind"}
    assert cues.snapshot().limitations


@pytest.mark.parametrize("name", ["q", "de"])
def test_stuck_in_flight(name: str) -> None:
    def stick(samples: np.ndarray) -> None:
        samples[400:] = samples[400]

    cues = judged(changed(flown(), name, stick))
    assert math.isfinite(cues.log[-1].time)
    if name == "de":
        assert cues.verdicts == ()


@pytest.mark.parametrize("bad", [math.nan, 1e300])
def test_numbers_that_are_none(bad: float) -> None:
    block = flown()
    values = block.values.copy()
    for column in range(len(block.channels)):
        values[100 + 11 * column : 105 + 11 * column, column] = bad
    cues = judged(Block(channels=block.channels, times=block.times, values=values))
    assert cues.snapshot().time == pytest.approx(block.times[-1], abs=0.06)
    assert len(cues.verdicts) == 1
    for one in cues.maneuvers:
        one.to_record()


def test_nothing_but_missing_samples() -> None:
    block = flown()
    empty = np.full_like(block.values, np.nan)
    cues = judged(Block(channels=block.channels, times=block.times, values=empty))
    assert states(cues) <= {"blind", "fly"}
    assert cues.verdicts == ()
    assert cues.snapshot().limitations


def test_late_channels() -> None:
    block = flown()
    quick = [name for name in block.channels if name not in ("alpha", "beta")]
    cues = cueing(model=None)
    behind = 0.0
    for start in range(0, len(block), 10):
        cues.feed(part(block, start, start + 10, quick))
        cues.feed(part(block, max(start - 100, 0), max(start - 90, 0), ("alpha", "beta")))
        cues.process_step()
        time = cues.snapshot().time
        if start > 200 and time is not None:
            behind = max(behind, block.times[min(start + 10, len(block)) - 1] - time)
    assert behind < 0.5
    assert cues.snapshot().alpha is None
    cues.finish()
    assert len(cues.verdicts) == 1


def test_an_empty_flight() -> None:
    cues = cueing()
    cues.process_step()
    cues.finish()
    snapshot = cues.snapshot()
    assert snapshot.time is None
    assert snapshot.trim is None
    assert snapshot.verdict_age is None
    assert list(cues.log) == []
