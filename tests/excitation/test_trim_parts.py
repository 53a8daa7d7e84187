"""Parts of the trim cue: windows, observers, states, ticks."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gsapp.excitation.flight_rows import rows_from_block
from gsapp.excitation.settings import CUES
from gsapp.excitation.trim.bank_observer import BankObserver
from gsapp.excitation.trim.motion_estimator import ClimbObserver, MovingWindow
from gsapp.excitation.trim.settings import TRIM
from gsapp.excitation.trim.tick_means import TICK_INDEX, TickMeans
from gsapp.excitation.trim.trim_cue import TrimDeviation
from gsapp.excitation.trim.trim_monitor import StateHysteresis, TrimMonitor
from gsapp.quantities import Block
from gsapp.quantities.constants import DEGREE, GRAVITY
from tests.excitation.trim_kit import RATE, SPEED, aircraft, changed, drawn, ramped

DT = 0.05


# Windows -------------------------------------------------------------------------------


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 10_000), cut=st.integers(0, 60), share=st.floats(0.0, 0.5))
def test_lines_are_those_of_least_squares(seed: int, cut: int, share: float) -> None:
    """Mean, slope and power of every window are those of `numpy.polyfit`; cuts change nothing."""
    random = np.random.default_rng(seed)
    values = random.standard_normal((60, 2))
    values[random.random(60) < share, 1] = np.nan
    whole, pieces = MovingWindow(20, 2), MovingWindow(20, 2)
    found = whole.fit_windows(values)
    parts = pieces.fit_windows(values[:cut]), pieces.fit_windows(values[cut:])
    for name in ("mean", "slope", "power"):
        joined = np.concatenate([getattr(part, name) for part in parts])
        np.testing.assert_array_equal(joined, getattr(found, name))
    place = np.arange(20)
    for end in (19, 37, 59):
        window = values[end - 19 : end + 1, 0]
        slope, offset = np.polyfit(place, window, 1)
        rest = window - slope * place - offset
        assert found.mean[end, 0] == pytest.approx(window.mean())
        assert found.slope[end, 0] == pytest.approx(slope)
        assert found.power[end, 0] == pytest.approx((rest**2).mean())
        there = np.isfinite(values[end - 19 : end + 1, 1])
        if there.sum() >= 12:
            known = values[end - 19 : end + 1, 1][there]
            assert found.mean[end, 1] == pytest.approx(known.mean())
        else:
            assert np.isnan(found.mean[end, 1])


# Observers -----------------------------------------------------------------------------


def test_bank_is_known_without_attitude() -> None:
    bank = ramped((8.0, 12.0), (6.0, -4.0), (8.0, 45.0), (8.0, 0.0), (8.0, -45.0), (10.0, 3.0))
    block = drawn(bank, attitude=False)
    ticks, _ = TickMeans(5, DT).average_rows(rows_from_block(block, RATE))
    for vane in (True, False):
        watch = BankObserver(DT, SPEED)
        misses = []
        for place, values in enumerate(ticks):
            row = {name: float(values[column]) for name, column in TICK_INDEX.items()}
            beta = row["beta"] if vane else np.nan
            watch.step((row["p"], row["q"], row["r"]), row["ax"], row["ay"], row["V"], beta, 0.0)
            misses.append(watch.bank - bank[5 * place + 2])
        late = np.array(misses[120:])
        assert np.sqrt((late**2).mean()) < 1.3 * DEGREE
        assert np.abs(late).max() < 4.0 * DEGREE
        assert watch.bank_std < 3.0 * DEGREE


def test_climb_is_known_now_though_height_comes_late() -> None:
    random = np.random.default_rng(3)
    count = round(16.0 / DT)
    lift = np.zeros(count)
    lift[200:210] = -4.0
    climb = 1.0 + np.cumsum(lift) * DT
    height = 100.0 + np.cumsum(climb) * DT
    watch = ClimbObserver(DT)
    late = round(CUES.slow_channel_delay / DT)
    found = []
    for place in range(count):
        shown = height[place - late] + 0.5 * random.standard_normal() if place >= late else np.nan
        watch.step(shown, np.nan, lift[place] + 0.02 * GRAVITY * random.standard_normal())
        found.append(watch.climb)
    misses = np.abs(np.array(found) - climb)
    assert np.nanmax(misses[120:200]) < 0.5
    assert misses[211:].max() < 0.6


def test_climb_from_a_rate_alone_and_from_nothing() -> None:
    watch = ClimbObserver(DT)
    for _ in range(200):
        watch.step(np.nan, 1.5, 0.0)
    assert watch.climb == pytest.approx(1.5, abs=0.05)
    for _ in range(60):
        watch.step(np.nan, np.nan, 0.0)
    assert np.isnan(watch.climb)


# States --------------------------------------------------------------------------------

_WANTED = st.tuples(st.sampled_from(["fly", "hold", "go", "gusty", "turn", "blind"]), st.booleans())


@settings(max_examples=50, deadline=None)
@given(samples=st.lists(_WANTED, min_size=1, max_size=120))
def test_states_stand_for_a_while(samples: list[tuple[str, bool]]) -> None:
    keeper = StateHysteresis("fly", 0.0)
    for tick, (wanted, lost) in enumerate(samples, start=1):
        before, since = keeper.state, keeper.since
        changed_now = keeper.step(tick * DT, wanted, lost=lost)  # type: ignore[arg-type]
        assert changed_now == (keeper.state != before)
        if changed_now:
            assert keeper.state == wanted
            assert (before == "go" and lost) or tick * DT - since >= TRIM.min_dwell_time - 1e-6
        if before == "go" and lost:
            assert keeper.state == wanted


# Ticks and words -----------------------------------------------------------------------


def test_ticks_leave_out_what_is_not_to_be_believed() -> None:
    block = drawn(np.zeros(400))
    block = changed(block, alpha=0.1, **{"r.3": block["r"] + 1.0})
    means = TickMeans(5, DT)
    means.invalid_channels = frozenset(("r", "beta"))
    ticks, stuck = means.average_rows(rows_from_block(block, RATE))
    assert ticks.shape == (80, len(TICK_INDEX))
    assert ticks[3, TICK_INDEX["p"]] == pytest.approx(block["p"][15:20].mean())
    assert np.isnan(ticks[:, TICK_INDEX["beta"]]).all()
    np.testing.assert_allclose(ticks[:, TICK_INDEX["r"]], 1.0, atol=0.05)
    assert np.isfinite(ticks[20, TICK_INDEX["alpha"]])
    assert np.isnan(ticks[60, TICK_INDEX["alpha"]])
    assert stuck[20] == ()
    assert stuck[60] == ("alpha",)


@pytest.mark.parametrize("rate", [20.0, 25.0, 50.0])
def test_slower_records_serve(rate: float) -> None:
    step = round(RATE / rate)
    full = drawn(np.zeros(1000))
    block = Block(
        channels=full.channels,
        times=np.arange(1000 // step) / rate,
        values=full.values[: 1000 // step * step : step],
    )
    watch = TrimMonitor(aircraft(), rate)
    watch.process_rows(rows_from_block(block, rate))
    assert watch.cue.state == "go"


@pytest.mark.parametrize(
    ("quantity", "amount", "channel", "us", "si"),
    [
        ("speed", -0.95, "V", "3 ft/s slow", "0.9 m/s slow"),
        ("bank", -6.2 * DEGREE, "phi", "left wing low 6 deg", "left wing low 6 deg"),
        ("bank", 6.2 * DEGREE, "r", "right wing low", "right wing low"),
        ("climb", 1.2, "climb_rate", "climbing 4 ft/s", "climbing 1.2 m/s"),
        ("alpha", -2.2 * DEGREE, "alpha", "alpha low 2 deg", "alpha low 2 deg"),
        ("pitch rate", -0.1, "q", "nose dropping", "nose dropping"),
        ("acceleration", 0.9, "ax", "speeding up", "speeding up"),
        ("height", 20.0, "height", "66 ft high", "20 m high"),
        ("unrest", 0.8, "alpha", "rough air", "rough air"),
    ],
)
def test_words_of_a_spotter(quantity: str, amount: float, channel: str, us: str, si: str) -> None:
    off = TrimDeviation(quantity=quantity, amount=amount, tolerance_ratio=1.5, channel=channel)
    assert off.format_text() == us
    assert off.format_text("SI") == si
