"""Records made ready: slow attitudes curved, surfaces behind servos."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gsapp.aircraft import Aircraft, load_aircraft
from gsapp.dynamics.actuators import Actuator
from gsapp.flight import Flight
from gsapp.identification.channel_faults import unmeasured_surfaces
from gsapp.identification.ftr.maneuver_estimator import compute_ftr_history
from gsapp.identification.maneuver import Maneuver, cut_maneuver
from gsapp.identification.maximum_likelihood import MLSettings, estimate
from gsapp.identification.record_preparation import (
    aircraft_as_recorded,
    interpolate_cubic,
    interpolate_repeated,
    reconstruct_deflections,
)
from gsapp.quantities import Block, FloatArray
from gsapp.quantities.constants import DEGREE
from tests.identification.virtual_maneuvers import Virtual, fly

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


def test_repeated_values_are_a_slow_channel() -> None:
    """Of a table that repeats what an instrument gave 17 times a second, up to the next value."""
    noise = np.random.default_rng(1).normal(0.0, 1e-3, TIMES.size)
    taken = np.floor(17.0 * TIMES) / 17.0
    held = np.interp(taken, TIMES, BANK + noise)
    found = interpolate_repeated(held)
    inside = slice(20, -20)
    before = np.std((held - BANK)[inside])
    assert before > 0.07
    assert np.std((found - BANK)[inside]) < 0.3 * before  # a row of the grid is late by itself
    held[301:340] = np.nan
    assert np.array_equal(np.isnan(interpolate_repeated(held)), np.isnan(held))


def test_coarse_steps_and_stuck_values_are_not_held() -> None:
    coarse = np.round(BANK / 0.05) * 0.05
    stuck = np.where(TIMES < 4.0, BANK, 0.3)
    for own in (BANK, coarse, stuck, np.full(800, 0.3), np.full(800, np.nan), np.full(1, 0.3)):
        assert np.array_equal(interpolate_repeated(own), own, equal_nan=True)


def test_maneuvers_are_cut_with_curves() -> None:
    block = Block(
        channels=("de", "phi", "q"), times=TIMES, values=np.column_stack((BANK, chords(2), BANK))
    )
    flight = Flight(name="A", path=Path("a.csv"), block=block, sources={})
    found = cut_maneuver(flight, load_aircraft("b777"), 2.0, 6.0, id="1", inputs=("de",))
    inner = slice(200, 601)
    assert np.abs(found.block["phi"] - BANK[inner]).max() < 2e-4
    assert np.array_equal(found.block["q"], BANK[inner])


B777 = load_aircraft("b777")
LAG, DELAY = 0.08, 0.03


def flown_by(kind: str, aircraft: Aircraft = B777, **servo: object) -> Aircraft:
    elevator = aircraft.controls.de.model_copy(update={"kind": kind, **servo})
    controls = aircraft.controls.model_copy(update={"de": elevator})
    return aircraft.model_copy(update={"controls": controls})


def block_of(**channels: FloatArray) -> Block:
    count = len(next(iter(channels.values())))
    return Block(
        channels=tuple(channels),
        times=DT * np.arange(count),
        values=np.column_stack(list(channels.values())),
    )


def stepped(aircraft: Aircraft, commands: FloatArray) -> tuple[FloatArray, FloatArray]:
    actuator = Actuator(aircraft, "de", DT)
    places = [actuator.step(one) for one in commands.tolist()]
    return np.array([one.servo for one in places]), np.array([one.surface for one in places])


DOUBLET = np.repeat((0.0, 30.0, -8.0, 0.0), (60, 40, 40, 110)) * DEGREE


def test_a_command_passes_travel_servo_and_linkage_as_the_virtual_aircraft_has_it() -> None:
    """Play apart, which a record's own noise would turn over: it follows the record smoothed."""
    for name in ("de", "de_command"):
        aircraft = flown_by("command", slop=0.0)
        found = reconstruct_deflections(block_of(**{name: DOUBLET}), aircraft)["de"]
        assert found == pytest.approx(stepped(aircraft, DOUBLET)[1], abs=1e-9)
        assert found.max() == pytest.approx(aircraft.controls.de.travel[1], rel=1e-3)


def test_a_servo_passes_the_linkage_alone() -> None:
    aircraft = flown_by("servo", slop=2.0 * DEGREE)
    servo = stepped(aircraft, 0.5 * DOUBLET)[0]
    found = reconstruct_deflections(block_of(de=servo), aircraft)["de"]
    assert found[95] == pytest.approx(servo[95] - 1.0 * DEGREE, abs=0.02 * DEGREE)
    assert found[135] == pytest.approx(servo[135] + 1.0 * DEGREE, abs=0.02 * DEGREE)


def test_a_measured_surface_stays_to_the_last_bit() -> None:
    block = block_of(de=DOUBLET, de_command=2.0 * DOUBLET)
    assert reconstruct_deflections(block, B777) is block


def test_a_flight_of_nothing_but_commands_is_one_where_the_file_states_no_kind() -> None:
    commands = block_of(de_command=0.5 * DOUBLET)
    unsaid = B777.model_copy(update={"controls": type(B777.controls)()})
    recorded = aircraft_as_recorded(commands, unsaid)
    assert recorded.controls.de.kind == "command"
    assert recorded.controls.da.kind == "position"
    assert "de" in reconstruct_deflections(commands, recorded)
    measured = block_of(de=DOUBLET, de_command=DOUBLET)
    assert aircraft_as_recorded(measured, unsaid) is unsaid
    assert aircraft_as_recorded(commands, B777) is B777


def test_what_hangs_on_a_missing_sample_is_missing() -> None:
    aircraft = flown_by("command", slop=0.0)
    commands = DOUBLET.copy()
    commands[70:74] = np.nan
    found = reconstruct_deflections(block_of(de=commands), aircraft)["de"]
    whole = stepped(aircraft, DOUBLET)[1]
    assert np.isnan(found[70:74]).all()
    assert np.isfinite(found[:70]).all()
    assert np.isfinite(found[120:]).all()
    known = np.isfinite(found)
    assert found[known] == pytest.approx(whole[known], abs=0.05 * DEGREE)


def asked_for(virtual: Virtual) -> FloatArray:
    deflection = virtual.motion["de"]
    asked = deflection + LAG * np.gradient(deflection, virtual.maneuver.dt)
    late = round(DELAY / virtual.maneuver.dt)
    return np.concatenate((asked[late:], np.full(late, asked[-1])))


def log_of(virtual: Virtual) -> Flight:
    block = virtual.maneuver.block
    columns = {"de_command" if name == "de" else name: block[name] for name in block.channels}
    columns["de_command"] = asked_for(virtual)
    values = np.column_stack(list(columns.values()))
    log = Block(channels=tuple(columns), times=block.times, values=values)
    return Flight(name="log", path=Path("log"), sources={}, info=None, block=log)


def commanded(virtual: Virtual, aircraft: Aircraft) -> Maneuver:
    flight = log_of(virtual)
    first, last = (float(flight.block.times[place]) for place in (0, -1))
    return cut_maneuver(flight, aircraft, first, last, id="1", inputs=("de",))


def behind_a_servo(aircraft: Aircraft, lag: float, delay: float) -> Aircraft:
    return flown_by("command", aircraft, lag=lag, delay=delay, slop=0.0, rate_limit=1e9)


def test_a_log_of_commands_gives_the_derivatives_of_the_aircraft() -> None:
    virtual = fly(7, "lon")

    def found(aircraft: Aircraft) -> tuple[Maneuver, dict[str, float]]:
        maneuver = commanded(virtual, aircraft)
        result = estimate([maneuver], MLSettings(axis="lon"))
        return maneuver, {name: result.value(name) for name in ("Cm_alpha", "Cm_q", "Cm_de")}

    told, right = found(behind_a_servo(virtual.maneuver.aircraft, lag=LAG, delay=DELAY))
    truth = {name: virtual.truth[name] for name in right}
    assert right == pytest.approx(truth, rel=0.08)
    assert told.remarks == ()
    untold, wrong = found(behind_a_servo(virtual.maneuver.aircraft, lag=0.0, delay=0.0))
    assert abs(wrong["Cm_q"] / truth["Cm_q"] - 1.0) > 0.3
    (remark,) = untold.remarks
    assert "servo" in remark
    assert "[controls.de]" in remark


def test_ftr_over_a_whole_flight_hears_the_surface() -> None:
    virtual = fly(7, "lon")
    aircraft = virtual.maneuver.aircraft
    measured = replace(log_of(virtual), block=virtual.maneuver.block)
    behind = behind_a_servo(aircraft, lag=LAG, delay=DELAY)

    def heard(flight: Flight, flown_by: Aircraft) -> float | None:
        return compute_ftr_history(flight, flown_by).estimates()["Cm_de"].value

    truth = heard(measured, aircraft)
    assert truth is not None
    assert heard(log_of(virtual), behind) == pytest.approx(truth, rel=0.05)


def test_an_aircraft_file_that_expects_a_position_is_told_what_the_log_holds() -> None:
    maneuver = commanded(fly(7, "lon"), B777)
    (surface, text) = next(iter(unmeasured_surfaces(maneuver, "lon")))
    assert surface == "de"
    assert "de_command" in text
    assert 'kind = "command"' in text
