"""Flights that a search for a missing effect cannot learn from: one sentence, and what to do."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gsapp.aircraft import load_aircraft
from gsapp.aircraft.aircraft_loader import SHIPPED_AIRCRAFT
from gsapp.cli.discrepancy import discrepancy
from gsapp.discrepancy.search_checks import check_model_match, record_remarks
from gsapp.dynamics.model import load_model
from gsapp.flight.maneuver_settings import ManeuverSettings
from gsapp.flight.writers import write_block
from gsapp.foundation import GroundStationError
from gsapp.identification.maneuver import open_flights_with_maneuvers
from gsapp.quantities import Block
from gsapp.virtual.virtual_flight import VirtualFlight
from tests.bad_input.bad_input_kit import everything_in, refused

WINDOWS = ("30:38", "40:45", "50:58", "63.5:68.5", "70:76")
"""Stretches of the flight, two of them doublets."""
SETTINGS = ManeuverSettings(aircraft="b777", maneuver_windows=WINDOWS)
Write = Callable[..., Path]


@pytest.fixture(scope="module")
def flown(flown_short: Callable[[int], VirtualFlight]) -> Block:
    whole = flown_short(5).measured
    kept = (whole.times >= 25.0) & (whole.times <= 80.0)
    return Block(channels=whole.channels, times=whole.times[kept], values=whole.values[kept])


@pytest.fixture
def write(flown: Block, tmp_path: Path) -> Write:
    def make(
        without: tuple[str, ...] = (),
        changed: Callable[[str, np.ndarray], np.ndarray] = lambda _, samples: samples,
    ) -> Path:
        kept = tuple(name for name in flown.channels if name not in without)
        columns = [changed(name, flown[name].copy()) for name in kept]
        block = Block(channels=kept, times=flown.times, values=np.column_stack(columns))
        write_block(tmp_path / "flight.csv", block, "csv")
        return tmp_path / "flight.csv"

    return make


def told(
    path: Path, windows: tuple[str, ...] = WINDOWS, aircraft: str = "b777", **options: Any
) -> str:
    there = everything_in(path.parent)
    with pytest.raises(GroundStationError) as caught:
        discrepancy(
            flights=[path],
            out=path.parent / "answer",
            aircraft=aircraft,
            maneuver_windows=windows,
            **options,
        )
    assert everything_in(path.parent) == there
    return str(caught.value)


def test_one_maneuver_is_not_enough(write: Write, tmp_path: Path) -> None:
    write()
    call = ("discrepancy", "flight.csv", "--out", "answer", "--maneuver", "40:45")
    refused(call, "only one maneuver", "fly at least 4", cwd=tmp_path)


def test_too_few_to_keep_any_out(write: Write) -> None:
    sentence = told(write(), WINDOWS[:3])
    assert "3 maneuvers" in sentence
    assert "fly at least 4" in sentence


def test_all_kept_out_leaves_nothing_to_learn_from(write: Write) -> None:
    assert "all maneuvers" in told(write(), held_out=("1", "2", "3", "4", "5"))


def test_propulsion_without_a_throttle(write: Write) -> None:
    path = write(without=("throttle", "thrust", "throttle_left", "throttle_right"))
    sentence = told(path, forced=("propulsion.Cm.throttle",))
    for text in ("propulsion.Cm.throttle", "needs throttle, which is not recorded", "steps"):
        assert text in sentence


def test_throttle_that_never_moved(write: Write) -> None:
    path = write(changed=lambda name, s: np.full_like(s, 0.6) if "throttle" in name else s)
    sentence = told(path, forced=("propulsion.Cm.throttle",))
    assert "needs throttle" in sentence


@pytest.mark.parametrize("channel", ["alpha", "q", "an"])
def test_a_channel_without_which_nothing_can_be_said(write: Write, channel: str) -> None:
    sentence = told(write(without=(channel,)))
    assert f"has no {channel}; record" in sentence


def test_a_lost_vane_is_not_the_fault_of_the_model(write: Write) -> None:
    assert "has no alpha" in told(write(without=("alpha",)), model="b777")


def test_names_that_do_not_exist(write: Write) -> None:
    path = write()
    assert "'propulsion.Cm.throttle'" in told(path, forced=("propulsion.Cm.throtle",))
    assert ", 'aero.Cm.alpha2' or" in told(path, refused=("aero.Cm.alpha7",))
    assert "no maneuver '9'" in told(path, held_out=("9",))
    assert "no maneuver '1:1'" in told(path, draw=("1:1",))


def test_a_place_that_cannot_be_written(write: Write, tmp_path: Path) -> None:
    (tmp_path / "answer").write_text("mine", encoding="utf-8")
    assert "answer is a file" in told(write())


def test_the_model_of_another_aircraft(write: Write, tmp_path: Path) -> None:
    (tmp_path / "heavy.toml").write_text(
        'name = "heavy"\n[derivatives]\nCN_0 = 0.9\nCN_alpha = 1.0\nCm_alpha = 0.8\n',
        encoding="utf-8",
    )
    sentence = told(write(), model=str(tmp_path / "heavy.toml"))
    assert "model 'heavy'" in sentence
    assert "aircraft file" in sentence
    flown = open_flights_with_maneuvers([write()], SETTINGS)[0].maneuvers
    model = load_model("b777")
    for factor in (0.8, 1.0, 1.2):
        scaled = {name: factor * value for name, value in model.derivatives.items()}
        check_model_match(model.with_derivatives(scaled), flown)


def test_the_aircraft_file_of_another_aircraft(write: Write, tmp_path: Path) -> None:
    text = SHIPPED_AIRCRAFT.find("b777").read_text(encoding="utf-8")
    assert 'wing_area = "11.33 ft^2"' in text
    path = tmp_path / "large.toml"
    path.write_text(text.replace("11.33 ft^2", "22.66 ft^2"), encoding="utf-8")
    sentence = told(write(), aircraft=str(path), model="b777")
    assert "aircraft file" in sentence


def test_what_is_clipped_or_lacks_is_told_with_the_answer(write: Write) -> None:
    limit = np.radians(90.0) / 8.0

    def clip(name: str, samples: np.ndarray) -> np.ndarray:
        return np.clip(samples, -limit, limit) if name == "q" else samples

    aircraft = load_aircraft("b777")
    path = write(without=("throttle", "thrust", "throttle_left", "throttle_right"), changed=clip)
    flown = open_flights_with_maneuvers([path], SETTINGS)[0].maneuvers
    ends = [replace(one, clipped={"q": np.abs(one.block["q"]) >= limit}) for one in flown]
    clipped, *lacking = record_remarks(ends, aircraft)
    assert clipped.startswith("q is clipped")
    assert "2 (" in clipped
    assert "are ignored" in clipped
    (throttle,) = (one for one in lacking if "needs throttle" in one)
    assert throttle.startswith("propulsion.")
    assert "not recorded" in throttle
    # As it was flown q is not clipped, and throttle was recorded and moved.
    whole = open_flights_with_maneuvers([write()], SETTINGS)[0].maneuvers
    text = " ".join(record_remarks(whole, aircraft))
    assert "q is clipped" not in text
    assert "needs throttle" not in text
