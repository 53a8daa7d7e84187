"""Dangers: sound flights raise none, failing instruments are named, whatever the stream's cuts."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gsapp.aircraft import Aircraft, load_aircraft
from gsapp.aircraft.config import Limits
from gsapp.excitation.alerts.alert import ActiveAlerts, Alert, AlertLevel
from gsapp.excitation.alerts.alert_monitor import AlertMonitor
from gsapp.excitation.alerts.geofence import Geofence, load_geofence
from gsapp.excitation.alerts.row_frames import FlightFrame, FrameSplitter
from gsapp.excitation.alerts.sensor_monitors import ClippingMonitor
from gsapp.excitation.flight_rows import FlightRows, rows_from_block
from gsapp.excitation.settings import ALERTS
from gsapp.foundation import FileProblemsError
from gsapp.quantities import Block, FloatArray
from gsapp.session.session_flight import find_session_setting
from tests.excitation.danger_kit import (
    BARE,
    Flown,
    Harm,
    blocked_pitot,
    dead_gyro,
    fly_pattern,
    record,
    several,
    stuck_with_noise,
    watched,
)

RATE = 100.0
SECONDS = 36.0
AT = 15.0
VANE, PRESSURE = math.radians(0.1), 1.0
NOSE = ("alpha", "beta", "dynamic_pressure")


def _limited(**limits: str | None) -> Aircraft:
    return _b777().model_copy(update={"limits": Limits.model_validate(limits)})


@pytest.fixture(scope="module")
def pattern() -> Flown:
    return fly_pattern(5000, 0.6, SECONDS)


def steady(channels: dict[str, np.ndarray | float], seconds: float) -> FlightRows:
    """Return rows of level flight at 30 m/s with these channels instead, or besides."""
    count = round(seconds * RATE)
    noise = np.random.default_rng(5).standard_normal((count, 6))
    usual = {
        "V": 30.0 + 0.1 * noise[:, 0],
        "alpha": 0.06 + 0.002 * noise[:, 1],
        "p": 0.02 * noise[:, 2],
        "q": 0.02 * noise[:, 3],
        "r": 0.02 * noise[:, 4],
        "an": 9.81 + 0.1 * noise[:, 5],
        "ax": 0.5 + 0.1 * noise[:, 0],
        "flap": 0.0,
    }
    columns = {name: np.broadcast_to(values, count) for name, values in (usual | channels).items()}
    block = Block(
        channels=tuple(columns),
        times=np.arange(count) / RATE,
        values=np.column_stack(list(columns.values())),
    )
    return rows_from_block(block, RATE)


def keys_of(rows: FlightRows, **options: object) -> list[str]:
    watch = AlertMonitor(options.pop("aircraft", _b777()), RATE, **options)  # type: ignore[arg-type]
    watch.process_rows(rows)
    return [danger.key for danger in watch.log]


def _b777() -> Aircraft:
    return load_aircraft("b777")


@pytest.mark.parametrize("without", [frozenset[str](), BARE], ids=["all", "bare"])
@pytest.mark.parametrize("known", [True, False], ids=["b777", "unknown"])
def test_a_sound_flight_raises_nothing(
    pattern: Flown, without: frozenset[str], known: bool
) -> None:
    assert not watched(record(pattern, without=without), known=known).log


@pytest.mark.parametrize(
    ("key", "channel", "faults", "harm", "latest"),
    [
        ("alpha", "alpha", ("alpha:stuck:start=15 s",), None, 2.5),
        ("beta", "beta", ("beta:dropout:start=15 s",), None, 1.5),
        ("airspeed", "V", ("dynamic_pressure:dropout:start=15 s",), None, 1.5),
        ("gyro.q", "q", ("q:stuck:start=15 s",), None, 2.5),
        ("alpha", "alpha", (), stuck_with_noise("alpha", AT, VANE), 12.0),
        ("beta", "beta", (), stuck_with_noise("beta", AT, VANE), 12.0),
        ("gyro.p", "p", (), dead_gyro("p", AT), 15.0),
        ("gyro.q", "q", (), dead_gyro("q", AT), 15.0),
    ],
)
def test_a_failing_instrument_is_named_and_no_other(
    pattern: Flown,
    key: str,
    channel: str,
    faults: tuple[str, ...],
    harm: Harm | None,
    latest: float,
) -> None:
    watch = watched(record(pattern, faults=faults, harm=harm, without=BARE))
    assert [danger.key for danger in watch.log] == [key]
    assert AT < watch.log[0].since < AT + latest
    assert channel in watch.invalid_channels


@pytest.mark.parametrize("every", [2, 10])
def test_other_rates_of_the_grid_serve(pattern: Flown, every: int) -> None:
    for faults, said in (((), []), (("beta:dropout:start=15 s",), ["beta"])):
        block = record(pattern, faults=faults)
        thinned = replace(block, times=block.times[::every], values=block.values[::every])
        watch = AlertMonitor(_b777(), RATE / every)
        watch.process_rows(rows_from_block(thinned, RATE / every))
        assert [danger.key for danger in watch.log] == said


def test_a_dead_gyro_is_outvoted_by_the_attitude(pattern: Flown) -> None:
    watch = watched(record(pattern, harm=dead_gyro("q", AT)))
    assert [danger.key for danger in watch.log] == ["gyro.q"]
    assert watch.log[0].since < AT + 8.0


@pytest.mark.parametrize("jammed", [False, True], ids=["plug out", "jammed"])
def test_without_nose_sensors_the_crew_is_told_to_land(pattern: Flown, jammed: bool) -> None:
    """Flight B would have been told; dead at once or each for itself."""
    harm = several(
        *(
            stuck_with_noise(name, AT, noise)
            for name, noise in zip(NOSE, (VANE, VANE, PRESSURE), strict=True)
        )
    )
    faults = () if jammed else tuple(f"{name}:dropout:start=15 s" for name in NOSE)
    watch = watched(record(pattern, faults=faults, harm=harm if jammed else None, without=BARE))
    worst = watch.active_alerts[0]
    assert (worst.key, worst.level) == ("nose", AlertLevel.WARNING)
    assert "nose sensors lost" in worst.spoken_text
    assert {"alpha", "beta", "V"} <= set(watch.invalid_channels)


def test_a_blocked_pitot_is_found_where_the_height_changes(pattern: Flown) -> None:
    watch = watched(record(pattern, harm=blocked_pitot(AT)))
    assert "airspeed" in [danger.key for danger in watch.log]
    assert {danger.key for danger in watch.log} <= {"airspeed", "stall"}


@pytest.fixture(scope="module")
def harmed(pattern: Flown) -> Block:
    harm = stuck_with_noise("alpha", 9.0, VANE)
    block = record(pattern, faults=("q:dropout:start=14 s,every=2 s,length=0.2 s",), harm=harm)
    rows = slice(0, 2200)
    return replace(block, times=block.times[rows], values=block.values[rows])


@settings(max_examples=5, deadline=None)
@given(cuts=st.lists(st.integers(1, 430), max_size=30, unique=True))
def test_cutting_the_stream_changes_nothing(harmed: Block, cuts: list[int]) -> None:
    """However many ticks come at once, the same is told at the same times."""
    whole = watched(harmed)
    assert whole.log
    assert watched(harmed, cuts=[*sorted(cuts), 440]).log == whole.log


@settings(max_examples=10, deadline=None)
@given(seed=st.integers(0, 2**31), share=st.sampled_from([0.01, 0.3, 0.9]))
@pytest.mark.filterwarnings("error")
def test_rubbish_is_survived(seed: int, share: float) -> None:
    rows = steady({"phi": 0.0, "theta": 0.05, "psi": 1.0, "p.2": 0.0, "height": 60.0,
                   "latitude": 0.7, "longitude": -1.4, "battery": 12.0}, 4.0)  # fmt: skip
    random = np.random.default_rng(seed)
    values = rows.values.copy()
    hit = random.random(values.shape) < share
    values[hit] = random.choice([np.nan, np.inf, -np.inf, 1e300, -1e12, 0.0], hit.sum())
    for aircraft in (_b777(), None):
        watch = AlertMonitor(aircraft, RATE)
        watch.process_rows(
            FlightRows(first_index=0, times=rows.times, values=values, starts_segment=True)
        )
        assert set(watch.invalid_channels) <= {
            name for one in watch.active_alerts for name in one.channels
        }


def test_a_sensor_that_falls_silent_is_told_and_one_never_heard_is_not() -> None:
    count = round(30.0 * RATE)
    alpha = 0.06 + 0.002 * np.random.default_rng(0).standard_normal(count)
    alpha[2000:] = np.nan
    assert keys_of(steady({"alpha": alpha}, 30.0)) == ["alpha"]


def test_three_gyros_vote() -> None:
    count = round(30.0 * RATE)
    noise = 0.02 * np.random.default_rng(0).standard_normal((count, 3))
    turn = np.where(np.arange(count) > 1500, 0.3, 0.0)
    rates = {"q": turn + noise[:, 0], "q.2": 0.3 * turn + noise[:, 1], "q.3": turn + noise[:, 2]}
    assert keys_of(steady(rates, 30.0)) == ["gyro.q.2"]


@pytest.mark.parametrize(("load", "told"), [(1.0, []), (1.9, ["stall"])])
def test_a_turn_stalls_at_a_speed_that_level_flight_bears(load: float, told: list[str]) -> None:
    pulled = np.where(np.arange(2000) > 1500, load, 1.0) * 9.80665
    rows = steady({"V": 25.0 + 0.1 * np.random.default_rng(1).standard_normal(2000),
                   "an": pulled}, 20.0)  # fmt: skip
    assert sorted(set(keys_of(rows))) == told


def test_an_alpha_that_is_not_believed_warns_of_no_stall() -> None:
    alpha = np.where(np.arange(3000) > 2000, np.radians(29.0), 0.06)
    alpha[:2001] += 0.002 * np.random.default_rng(0).standard_normal(2001)
    assert "stall" not in keys_of(steady({"alpha": alpha}, 30.0))[1:]


def test_the_fence_is_told_before_it_is_reached() -> None:
    """At 30 m/s away from home, 800 m are called four seconds before, then again beyond."""
    count = round(40.0 * RATE)
    away = np.arange(count) / RATE * 30.0
    rows = steady(
        {"north": away, "east": np.zeros(count), "ground_speed": 30.0, "track": 0.0,
         "height": 60.0}, 40.0
    )  # fmt: skip
    watch = AlertMonitor(_b777(), RATE)
    watch.process_rows(rows)
    first, second = watch.log
    assert (first.key, first.level) == ("fence.side", AlertLevel.CAUTION)
    assert (second.key, second.level) == ("fence.side", AlertLevel.WARNING)
    assert second.since - first.since == pytest.approx(4.0, abs=0.5)
    assert keys_of(rows, fence=None) == []


@pytest.mark.parametrize(("system", "ceiling"), [("US", "394 ft"), ("SI", "120 m")])
def test_the_ceiling_is_told_before_it_is_reached(system: str, ceiling: str) -> None:
    height = 50.0 + 5.0 * np.maximum(np.arange(2500) / RATE - 5.0, 0.0)
    watch = AlertMonitor(_b777(), RATE, system=system)
    watch.process_rows(steady({"height": height, "climb_rate": 5.0}, 25.0))
    assert all(ceiling in danger.text for danger in watch.log)
    assert [(danger.key, danger.level) for danger in watch.log] == [
        ("fence.top", AlertLevel.CAUTION),
        ("fence.top", AlertLevel.WARNING),
    ]


def test_the_time_that_the_aircraft_may_fly_is_told_a_minute_before_it_is_over() -> None:
    rows = steady({}, 100.0)
    watch = AlertMonitor(_limited(flight_time="90 s"), RATE)
    watch.process_rows(rows)
    assert [one.level for one in watch.log] == [AlertLevel.CAUTION, AlertLevel.WARNING]
    assert "60 s" in watch.log[0].text
    assert "1.5 min" in watch.log[1].text
    assert watch.log[1].since - watch.log[0].since == pytest.approx(60.0, abs=0.5)
    assert keys_of(rows, aircraft=_limited(flight_time=None)) == []
    assert keys_of(rows, aircraft=None) == []


@pytest.mark.parametrize(("empty", "told"), [("10.5 V", ["battery"]), ("9 V", []), (None, [])])
def test_a_battery_that_will_not_last_is_told(empty: str | None, told: list[str]) -> None:
    seconds = 150.0
    battery = 12.0 - 0.5 / 60.0 * np.arange(round(seconds * RATE)) / RATE
    rows = steady({"battery": battery}, seconds)
    aircraft = _limited(flight_time=None, battery_empty=empty)
    assert keys_of(rows, aircraft=aircraft) == told


def test_a_fence_file_with_mistakes_says_so(tmp_path: Path) -> None:
    place = tmp_path / "fence.toml"
    place.write_text('radius = "500 m"\nceiling = "400 ft"\n')
    assert load_geofence(place).radius == pytest.approx(500.0)
    place.write_text('floor = "400 m"\nlatitude = "39 deg"\n')
    with pytest.raises(FileProblemsError):
        load_geofence(place)
    assert Geofence().ceiling == pytest.approx(120.0)


def test_the_fence_of_a_flight_lies_in_its_folder(tmp_path: Path) -> None:
    assert find_session_setting(tmp_path).fence is None
    place = tmp_path / "fence.toml"
    place.write_text('radius = "500 m"\n')
    found = find_session_setting(tmp_path)
    assert found.fence == Geofence.model_validate({"radius": "500 m"})
    assert not found.remarks
    place.write_text('radius = "minus"\n')
    found = find_session_setting(tmp_path)
    assert found.fence is None
    assert "default geofence" in found.remarks[0]


def test_a_floor_counts_until_the_flaps_are_out() -> None:
    height = 60.0 - 4.0 * np.maximum(np.arange(2000) / RATE - 5.0, 0.0)
    fence = Geofence.model_validate({"floor": "30 m"})
    sinking = {"height": height, "climb_rate": -4.0}
    assert "fence.floor" in keys_of(steady(sinking, 20.0), fence=fence)
    landing = sinking | {"flap": np.radians(20.0)}
    assert "fence.floor" not in keys_of(steady(landing, 20.0), fence=fence)


def _swinging(stop: float, size: float = 0.6) -> np.ndarray:
    times = np.arange(round(30.0 * RATE)) / RATE
    noise = 0.02 * np.random.default_rng(6).standard_normal(times.size)
    swing = np.where((times > 15.0) & (times < 21.0), size * np.sin(math.pi * times), 0.0)
    return np.clip(swing + noise, -stop, stop)


@pytest.mark.parametrize("known", [True, False], ids=["b777", "unknown"])
def test_a_gyro_that_is_cut_off_within_its_range_shows_it_by_flat_tops(known: bool) -> None:
    aircraft = _b777() if known else None
    assert set(keys_of(steady({"q": _swinging(0.4)}, 30.0), aircraft=aircraft)) == {"clip.q"}
    assert keys_of(steady({"q": _swinging(9.0)}, 30.0), aircraft=aircraft) == []


@pytest.mark.parametrize(("stop", "size"), [(0.4, 0.6), (1.6, 2.4)])
def test_what_is_cut_off_on_the_ground_or_of_a_broken_gyro_is_not_told(
    stop: float, size: float
) -> None:
    rows = steady({"q": _swinging(stop, size)}, 30.0)

    def told(doubted: frozenset[str] = frozenset(), **state: float) -> set[str]:
        room = ClippingMonitor(_b777(), RATE)
        frames = [FlightFrame(rows=cut, **state) for cut in FrameSplitter(RATE).split(rows)]  # type: ignore[arg-type]
        return {found.key for frame in frames for found in room.evaluate(frame, doubted)}

    assert told(time_since_takeoff=60.0) == {"clip.q"}
    assert told(time_since_takeoff=-1.0) == set()
    assert told(time_since_takeoff=60.0, near_ground=True) == set()
    assert told(frozenset({"q"}), time_since_takeoff=60.0) == set()


@pytest.mark.parametrize("rate", [2.0, 4.0, 5.0, 10.0])
def test_lines_between_the_samples_of_a_slow_link_are_no_flat_tops(rate: float) -> None:
    times = np.arange(round(60.0 * RATE)) / RATE
    sampled = np.arange(0.0, 61.0, 1.0 / rate)
    noise = 0.02 * np.random.default_rng(0).standard_normal(sampled.size)
    swing = 0.5 * np.sin(0.6 * sampled) + noise

    def linked(values: FloatArray) -> FlightRows:
        return steady({"q": np.interp(times, sampled, values)}, 60.0)

    assert keys_of(linked(swing)) == []
    assert "clip.q" in keys_of(linked(np.minimum(swing, 0.3)))


def test_a_clipped_gyro_is_told_once_for_each_event() -> None:
    p = 0.02 * np.random.default_rng(0).standard_normal(3000)
    for start in (1500, 2500):
        p[start : start + 20] = np.radians(90.0)
    assert keys_of(steady({"p": p}, 30.0)) == ["clip.p", "clip.p"]


def test_what_stands_does_not_flicker() -> None:
    standing = ActiveAlerts()
    caution = Alert(key="stall", level=AlertLevel.CAUTION, text="", spoken_text="slow")
    warning = Alert(key="stall", level=AlertLevel.WARNING, text="", spoken_text="stall: push")
    for step in range(20):
        standing.update(0.25 * step, [caution] if step % 3 == 0 else [])
        assert standing.alerts
    standing.update(5.0, [warning])
    standing.update(5.25, [caution])
    assert standing.alerts[0].level is AlertLevel.WARNING
    standing.update(5.25 + ALERTS.hold_time, [caution])
    assert standing.alerts[0].level is AlertLevel.CAUTION
    standing.update(20.0, [])
    assert not standing.alerts
    assert [danger.since for danger in standing.log] == [0.0, 5.0]
