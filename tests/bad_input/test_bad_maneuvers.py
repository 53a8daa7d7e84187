"""Bad maneuvers on the command line: a clear sentence each, and no number that is not earned."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from gsapp.aircraft.aircraft_loader import SHIPPED_AIRCRAFT
from gsapp.flight.writers import write_block
from gsapp.quantities import Block
from gsapp.virtual.virtual_flight import VirtualFlight
from tests.cli.command_kit import gsapp

ELEVATOR, COMBINED = "40:45", "63.5:68.5"
Change = Callable[[str, np.ndarray], np.ndarray]


@pytest.fixture(scope="module")
def flown(flown_short: Callable[[int], VirtualFlight]) -> Block:
    return flown_short(5).measured


def changed(block: Block, change: Change) -> Block:
    columns = [change(name, block[name].copy()) for name in block.channels]
    return Block(channels=block.channels, times=block.times, values=np.column_stack(columns))


def estimate(folder: Path, block: Block, *options: str) -> tuple[str, dict | None]:
    write_block(folder / "flight.csv", block, "csv")
    out = folder / "out.json"
    done = gsapp(
        "estimate", str(folder / "flight.csv"), *options, "--json", str(out), folder=folder
    )
    text = " ".join((done.stdout + done.stderr).split())
    assert "Traceback" not in text
    assert done.returncode in (0, 1), text
    return text, json.loads(out.read_text(encoding="utf-8")) if done.returncode == 0 else None


def only(name: str, make: Callable[[np.ndarray], np.ndarray]) -> Change:
    return lambda channel, samples: make(samples) if channel == name else samples


@pytest.mark.parametrize("surface", ["de", "da", "dr"])
def test_reversed_surface_is_named(flown: Block, tmp_path: Path, surface: str) -> None:
    window = ELEVATOR if surface == "de" else COMBINED
    bad = changed(flown, only(surface, lambda samples: -samples))
    said, _ = estimate(tmp_path, bad, "--maneuver", window)
    assert "sign" in said
    assert f"({surface})" in said


def test_stuck_surface_earns_nothing(flown: Block, tmp_path: Path) -> None:
    bad = changed(flown, only("dr", lambda samples: np.full_like(samples, 0.01)))
    said, content = estimate(tmp_path, bad, "--maneuver", COMBINED)
    assert content is None or "Cn_dr" not in content["campaign"]
    assert "dr" in said


def test_all_missing_channel_is_left_out_and_told(flown: Block, tmp_path: Path) -> None:
    bad = changed(flown, only("alpha", lambda samples: np.full_like(samples, np.nan)))
    said, content = estimate(tmp_path, bad, "--maneuver", ELEVATOR)
    assert "alpha" not in content["maneuvers"][0]["fit"]
    assert "alpha" in said


def test_constant_channel_is_told(flown: Block, tmp_path: Path) -> None:
    bad = changed(flown, only("q", lambda samples: np.full_like(samples, 0.02)))
    said, content = estimate(tmp_path, bad, "--maneuver", ELEVATOR)
    q = None if content is None else content["campaign"].get("Cm_q")
    # Either there is no number, or a word about what is wrong stands beside it.
    assert q is None or "q" in said.split("maneuver 1:", 1)[-1]


def test_ten_samples_are_too_few(flown: Block, tmp_path: Path) -> None:
    said, content = estimate(tmp_path, flown, "--maneuver", "41.0:41.09")
    assert content is None or not content["campaign"]
    assert "samples" in said or "too" in said


def test_aircraft_without_mass_is_refused(flown: Block, tmp_path: Path) -> None:
    text = SHIPPED_AIRCRAFT.find("b777").read_text(encoding="utf-8")
    path = tmp_path / "light.toml"
    path.write_text(text.replace('mass = "1.45 slug"', 'mass = "0 slug"'), encoding="utf-8")
    said, content = estimate(tmp_path, flown, "--aircraft", str(path))
    assert content is None
    assert "mass.mass" in said
    assert "greater than zero" in said
