"""FTR as a consumer of a live flight: however samples come, whenever windows become known."""

from collections.abc import Sequence
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline

from gsapp.aircraft import load_aircraft
from gsapp.dynamics.model import load_model
from gsapp.foundation import FlightError, UnknownNameError
from gsapp.identification.axes import axis_derivatives
from gsapp.identification.ftr import FTR, FTRSettings
from gsapp.identification.record_preparation import channel_delays
from gsapp.quantities import Block
from gsapp.session.consumer_scheduler import Consumer
from tests.identification.virtual_maneuvers import fly

AIRCRAFT = load_aircraft("b777")
TRUTH = load_model("b777")
RATE = 100.0
FIRST = 6  # columns in the first of two blocks


@cache
def flight() -> Block:
    parts = [fly(seed, kind, model=TRUTH).maneuver for seed, kind in ((1, "lon"), (2, "lat"))]
    parts.append(fly(3, "both", model=TRUTH).maneuver)
    channels = parts[0].block.channels
    rows, times = [], []
    for index, part in enumerate(parts):
        rows.append(part.block.values[:1000])
        begin = 50.0 + index * 10.0 + (3.0 if index == 2 else 0.0)
        times.append(begin + 0.01 * np.arange(1000.0))
    values = np.concatenate(rows)
    random = np.random.default_rng(4)
    values[random.random(values.shape) < 5e-4] = np.nan
    values[1300:1320] = np.nan
    return Block(channels=channels, times=np.concatenate(times), values=values)


def feed(ftr: FTR, block: Block, cuts: Sequence[int], *, split: bool = False) -> None:
    for start, stop in zip([0, *cuts], [*cuts, len(block)], strict=True):
        if stop <= start:
            continue
        groups = [slice(0, FIRST), slice(FIRST, None)] if split else [slice(None)]
        for group in groups:
            ftr.feed(
                Block(
                    channels=block.channels[group],
                    times=block.times[start:stop],
                    values=block.values[start:stop, group],
                )
            )
        ftr.process_step()


def same(one: FTR, other: FTR) -> bool:
    return one.estimates() == other.estimates() and all(
        np.array_equal(getattr(a, part), getattr(b, part), equal_nan=True)
        for name in one.names
        for a, b in [(one.history(name), other.history(name))]
        for part in ("times", "values", "stds", "signal_to_noise")
    )


@cache
def reference(forgetting: float | None) -> FTR:
    ftr = FTR(AIRCRAFT, FTRSettings(forgetting=forgetting), rate=RATE, aligned=True)
    feed(ftr, flight(), [])
    ftr.finish()
    return ftr


@pytest.mark.parametrize("forgetting", [None, 12.0])
@settings(max_examples=8, deadline=None)
@given(
    cuts=st.lists(st.integers(1, 2999), max_size=60, unique=True).map(sorted), split=st.booleans()
)
def test_nothing_depends_on_how_samples_were_cut(
    forgetting: float | None, cuts: list[int], split: bool
) -> None:
    ftr = FTR(AIRCRAFT, FTRSettings(forgetting=forgetting), rate=RATE, aligned=True)
    feed(ftr, flight(), cuts, split=split)
    ftr.finish()
    assert same(ftr, reference(forgetting))


def test_sample_by_sample_and_ten_times_a_second() -> None:
    ftr: Consumer = FTR(AIRCRAFT, rate=RATE, aligned=True)
    assert isinstance(ftr, FTR)
    assert ftr.time is None
    assert ftr.estimates() == {}
    feed(ftr, flight(), range(1, 3000))
    ftr.finish()
    assert same(ftr, reference(None))
    times = ftr.history("Cm_q").times
    assert np.allclose(np.diff(times), 0.1)
    assert times[-1] == ftr.time
    ftr.reset()
    assert ftr.time is None
    feed(ftr, flight(), [1000])
    ftr.finish()
    assert same(ftr, reference(None))


@pytest.mark.parametrize("count", [1, 7, 100, 10**6])
def test_a_thinned_history_ends_with_the_latest_estimate(count: int) -> None:
    ftr = reference(None)
    whole, thinned = ftr.history("Cm_q"), ftr.history("Cm_q", max_points=count)
    assert min(count, whole.times.size) / 2 < thinned.times.size <= count
    places = np.searchsorted(whole.times, thinned.times)
    assert places[-1] == whole.times.size - 1
    assert np.unique(np.diff(places)).size <= 1
    for part in ("times", "values", "stds", "signal_to_noise"):
        kept = getattr(whole, part)[places]
        assert np.array_equal(getattr(thinned, part), kept, equal_nan=True)


def test_live_estimates_are_right_whenever_they_are_shown() -> None:
    ftr = reference(None)
    worst = {}
    for name in axis_derivatives("both"):
        if name.endswith("_0"):
            continue  # trims differ
        history = ftr.history(name)
        assert np.isnan(history.values[:20]).all()
        error = (history.values - TRUTH.derivative(name)) / history.stds
        if np.isfinite(error).any():
            worst[name] = float(np.sqrt(np.nanmean(error**2)))
    assert len(worst) >= 20
    assert float(np.median(list(worst.values()))) < 1.5
    assert max(worst.values()) < 3.0
    early, late = ftr.estimates(53.0), ftr.estimates(73.0)
    assert early["Cl_p"].value is None
    assert early["Cl_p"].progress < 1.0
    assert early["Cl_p"].why
    assert late["Cl_p"].value is not None
    assert late["Cl_p"].progress == 1.0
    assert late["Cl_p"].amplitude > 0.0
    with pytest.raises(UnknownNameError, match="'CL_alpha'"):
        ftr.history("CL_alpha")


def test_forgetting_follows_a_change() -> None:
    changed = TRUTH.with_derivatives({**TRUTH.derivatives, "Cm_de": -0.7})
    before = [fly(seed, "lon", model=TRUTH, noise=0.3).maneuver.block for seed in (1, 2)]
    after = [fly(seed, "lon", model=changed, noise=0.3).maneuver.block for seed in (3, 4, 5)]
    blocks = [*before, *after]
    joined = Block(
        channels=blocks[0].channels,
        times=0.01 * np.arange(sum(len(one) for one in blocks)),
        values=np.concatenate([one.values for one in blocks]),
    )
    found = {}
    for forgetting in (None, 6.0):
        ftr = FTR(
            AIRCRAFT, FTRSettings(forgetting=forgetting), rate=RATE, axes=("lon",), aligned=True
        )
        feed(ftr, joined, [])
        ftr.finish()
        found[forgetting] = ftr.estimates()["Cm_de"].value
    assert found[6.0] == pytest.approx(-0.7, abs=0.06)
    assert found[None] < -0.76


# --- windows ------------------------------------------------------------------------------------


def test_windows_do_not_depend_on_when_they_became_known() -> None:
    """A maneuver announced in time, late, or after landing leaves the same estimates."""
    windows = [(50.4, 59.5), (60.3, 66.0), (73.0, 82.9)]
    chosen = FTRSettings(gate="maneuvers")
    late = FTR(AIRCRAFT, chosen, rate=RATE, aligned=True)
    feed(late, flight(), [])
    late.finish()
    assert late.estimates() == {}
    for start, stop in windows:
        late.begin_window(start)
        late.end_window(stop)
    for delay in (0.0, 1.7):
        ftr = FTR(AIRCRAFT, chosen, rate=RATE, aligned=True)
        due = [x for start, stop in windows for x in ((start + delay, "begin"), (stop, "end"))]
        for start in range(0, 3000, 23):
            piece = slice(start, start + 23)
            block = flight()
            feed(
                ftr,
                Block(
                    channels=block.channels, times=block.times[piece], values=block.values[piece]
                ),
                [],
            )
            while due and block.times[min(start + 22, 2999)] >= due[0][0]:
                at, what = due.pop(0)
                ftr.begin_window(at - delay) if what == "begin" else ftr.end_window(at)
        ftr.finish()
        assert not due
        assert ftr.estimates().keys() == late.estimates().keys()
        for name, one in ftr.estimates().items():
            other = late.estimates()[name]
            assert (one.value, one.std, one.status) == (other.value, other.std, other.status)
    assert late.estimates()["Cl_p"].value is not None


def test_windows_out_of_order_are_refused() -> None:
    with pytest.raises(FlightError, match="gate is 'always'"):
        FTR(AIRCRAFT, rate=RATE).begin_window(1.0)
    ftr = FTR(AIRCRAFT, FTRSettings(gate="maneuvers", lookback=5.0), rate=RATE, aligned=True)
    with pytest.raises(FlightError, match="start one first"):
        ftr.end_window(3.0)
    feed(ftr, flight(), [])
    with pytest.raises(FlightError, match="raise lookback"):
        ftr.begin_window(51.0)
    ftr.begin_window(80.0)
    with pytest.raises(FlightError, match="end that maneuver"):
        ftr.begin_window(81.0)
    with pytest.raises(FlightError, match="began at"):
        ftr.end_window(79.0)
    with pytest.raises(FlightError, match="too few"):
        FTR(AIRCRAFT, rate=1.0)


# --- saved state --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "chosen",
    [FTRSettings(), FTRSettings(forgetting=12.0), FTRSettings(gate="maneuvers")],
    ids=["always", "forgetting", "maneuvers"],
)
def test_saved_and_restored_goes_on_to_the_last_bit(chosen: FTRSettings, tmp_path: Path) -> None:
    path = tmp_path / "ftr.npz"
    block = flight()
    parts = [block.between(0.0, 64.55), block.between(64.55, 200.0)]
    one, other = (
        FTR(AIRCRAFT, chosen, rate=RATE, aligned=True),
        FTR(AIRCRAFT, chosen, rate=RATE, aligned=True),
    )
    feed(one, parts[0], [700])
    if chosen.gate == "maneuvers":
        one.begin_window(60.5)
    one.save(path)
    other.load(path)
    assert same(one, other)
    for ftr in (one, other):
        feed(ftr, parts[1], [300])
        if chosen.gate == "maneuvers":
            ftr.end_window(69.0)
        ftr.finish()
    assert same(one, other)
    assert any(x.value is not None for x in one.estimates().values())


def test_strange_states_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "ftr.npz"
    ftr = FTR(AIRCRAFT, rate=RATE, aligned=True)
    feed(ftr, flight().between(0.0, 55.0), [])
    ftr.save(path)
    with pytest.raises(FlightError, match="other rate"):
        FTR(AIRCRAFT, rate=50.0).load(path)
    with pytest.raises(FlightError, match="other settings"):
        FTR(AIRCRAFT, FTRSettings(forgetting=5.0), rate=RATE, aligned=True).load(path)
    path.write_bytes(path.read_bytes()[:-400])
    with pytest.raises(FlightError, match="can be read"):
        ftr.load(path)
    with pytest.raises(FlightError, match="can be read"):
        ftr.load(tmp_path / "none.npz")


# --- instruments --------------------------------------------------------------------------------


def test_instrument_that_dies_stops_its_equations_alone() -> None:
    block = flight()
    values = block.values.copy()
    values[500:, block.channels.index("an")] = np.nan
    ftr = FTR(AIRCRAFT, rate=RATE, aligned=True)
    feed(ftr, Block(channels=block.channels, times=block.times, values=values), [])
    ftr.finish()
    found = ftr.estimates()
    assert found["CN_alpha"].value is None
    assert found["CN_alpha"].why == "an is not measured"
    assert found["Cm_alpha"].value is not None
    assert ftr.unavailable_coefficients() == {"CN": "an is not measured"}


def test_channel_that_stops_coming_does_not_stop_the_rest() -> None:
    block = flight()
    ftr = FTR(AIRCRAFT, rate=RATE, aligned=True)
    feed(ftr, block.between(0.0, 55.0), [])
    keep = [k for k, name in enumerate(block.channels) if name != "ay"]
    rest = block.between(55.0, 60.0)
    feed(
        ftr,
        Block(
            channels=tuple(block.channels[k] for k in keep),
            times=rest.times,
            values=rest.values[:, keep],
        ),
        [],
    )
    assert ftr.time == pytest.approx(60.0 - 1.0, abs=0.2)


def test_instrument_that_is_late_is_put_right() -> None:
    gyro = AIRCRAFT.sensors.gyro.model_copy(update={"delay": 0.03})
    plane = AIRCRAFT.model_copy(
        update={"sensors": AIRCRAFT.sensors.model_copy(update={"gyro": gyro})}
    )
    block = fly(2, "lat", model=TRUTH, noise=0.0).maneuver.block
    values = block.values.copy()
    late = channel_delays(plane)
    assert late["p"] >= 0.03
    for column, name in enumerate(block.channels):
        if name in late:
            shown = CubicSpline(block.times, values[:, column])
            values[:, column] = shown(np.maximum(block.times - late[name], block.times[0]))
    chosen = FTRSettings(gate="maneuvers", signal_to_noise=1e-6, uncertain_share=1e6)
    errors = {}
    for aligned in (False, True):
        ftr = FTR(plane, chosen, rate=RATE, origin=float(block.times[0]), aligned=aligned)
        ftr.begin_window(float(block.times[0]))
        feed(ftr, Block(channels=block.channels, times=block.times, values=values), [])
        ftr.finish()
        value = ftr.estimates()["Cl_p"].value
        errors[aligned] = abs(value / TRUTH.derivative("Cl_p") - 1.0)
    assert errors[False] < 0.02
    assert errors[True] > 0.1
