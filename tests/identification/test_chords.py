"""Slow attitude channels: curves in place of the chords between their samples."""

from pathlib import Path

import numpy as np
import pytest

from gsapp.aircraft import load_aircraft
from gsapp.flight import Flight
from gsapp.identification.maneuver import cut_maneuver
from gsapp.identification.record_preparation import interpolate_cubic
from gsapp.quantities import Block

DT = 0.01
TIMES = DT * np.arange(800)
# Bank of a small, agile aircraft: 0.4 rad at 11 rad/s.
BANK = 0.4 * np.sin(11.0 * TIMES) + 0.1 * np.sin(3.0 * TIMES)


def chords(length: int, first: int = 0) -> np.ndarray:
    return np.interp(TIMES, TIMES[first::length], BANK[first::length])


@pytest.mark.parametrize(("length", "first"), [(2, 0), (2, 1), (4, 3)])
def test_what_chords_cut_off_comes_back(length: int, first: int) -> None:
    slow = chords(length, first)
    inside = slice(12, -12)
    before = np.abs(slow - BANK)[inside].max()
    assert before > 2e-3 * (length / 2) ** 2
    assert np.abs(interpolate_cubic(slow) - BANK)[inside].max() < 0.1 * before
    ends = np.arange(first, TIMES.size, length)
    assert np.array_equal(interpolate_cubic(slow)[ends], slow[ends])


def test_gaps_stay_and_nothing_is_drawn_across_them() -> None:
    slow = chords(2)
    slow[301:340] = np.nan
    found = interpolate_cubic(slow)
    assert np.isnan(found[301:340]).all()
    assert np.abs(found - BANK)[12:295].max() < 2e-4
    assert np.abs(found - BANK)[346:-12].max() < 2e-4


def test_a_channel_with_samples_of_its_own_stays_as_it_was() -> None:
    count = 0.01
    noise = np.random.default_rng(0).normal(0.0, 1e-3, TIMES.size)
    for own in (BANK, BANK + noise, np.round(BANK / count) * count, np.full(800, 0.3), TIMES):
        assert np.array_equal(interpolate_cubic(own), own)


def test_maneuvers_are_cut_with_curves() -> None:
    block = Block(
        channels=("de", "phi", "q"), times=TIMES, values=np.column_stack((BANK, chords(2), BANK))
    )
    flight = Flight(name="A", path=Path("a.csv"), block=block, sources={})
    found = cut_maneuver(flight, load_aircraft("b777"), 2.0, 6.0, id="1", inputs=("de",))
    inner = slice(200, 601)
    assert np.abs(found.block["phi"] - BANK[inner]).max() < 2e-4
    assert np.array_equal(found.block["q"], BANK[inner])
