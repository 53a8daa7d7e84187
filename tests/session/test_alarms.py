"""Limits and alarms: what is raised depends on the samples, and stays until acknowledged."""

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Literal

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gsapp.aircraft import load_aircraft
from gsapp.foundation import FileProblemsError
from gsapp.quantities import Block, channel
from gsapp.session.alarms import Alarm, AlarmRegistry
from gsapp.session.limit_monitor import LimitMonitor
from gsapp.session.limits import (
    LimitBands,
    LimitRule,
    LimitSet,
    Severity,
    aircraft_rules,
    load_limits,
)
from gsapp.session.session_monitors import AlarmMonitor, MessagePresenceMonitor
from gsapp.session.user_limit_store import UserLimitStore

RATE = 100.0
DEG = np.pi / 180.0


def block(first: int, values: dict[str, np.ndarray]) -> Block:
    count = len(next(iter(values.values())))
    return Block(
        channels=tuple(values),
        times=np.arange(first, first + count) / RATE,
        values=np.column_stack(list(values.values())),
    )


class _Plain:
    def __init__(self, threshold: float, hysteresis: float, needed: int) -> None:
        self.threshold, self.back, self.needed = threshold, threshold - hysteresis, needed
        self.on, self.count = False, 0

    def step(self, value: float) -> None:
        away = value <= self.back if self.on else value > self.threshold
        self.count = self.count + 1 if away else 0
        if self.count >= self.needed:
            self.on, self.count = not self.on, 0


def plain_onsets(rule: LimitRule, values: np.ndarray) -> list[tuple[int, Severity]]:
    """Return where alarms begin or grow worse, one sample at a time."""
    sign = 1.0 if rule.side == "high" else -1.0
    needed = max(1, round(rule.duration * RATE))
    latches = [
        _Plain(sign * limit, rule.hysteresis, needed) for limit in (rule.caution, rule.warning)
    ]
    armed = rule.armed_at is None
    found, before = [], Severity.NORMAL
    for index, value in enumerate((sign * values).tolist()):
        if rule.armed_at is not None:
            if value < sign * rule.armed_at:
                armed = True
            elif value > sign * rule.disarmed_at:
                armed = False
                for latch in latches:
                    latch.on, latch.count = False, 0
        if armed:
            for latch in latches:
                latch.step(value)
        now = Severity(max(level + 1 if latch.on else 0 for level, latch in enumerate(latches)))
        if now > before:
            found.append((index, now))
        before = now
    return found


@settings(deadline=None, max_examples=50)
@given(
    seed=st.integers(0, 10_000),
    cuts=st.lists(st.integers(1, 599), max_size=12),
    side=st.sampled_from(["high", "low"]),
    duration=st.sampled_from([0.0, 0.03, 0.1]),
    missing=st.sampled_from([0.0, 0.05]),
    sleeping=st.booleans(),
)
def test_limits_act_sample_by_sample_however_the_samples_arrive(
    seed: int, cuts: list[int], side: str, duration: float, missing: float, sleeping: bool
) -> None:
    """Any cutting gives the alarms of a plain loop over the samples: onsets, state, value."""
    generator = np.random.default_rng(seed)
    walk = np.cumsum(generator.normal(size=600) * 0.02) + generator.normal(size=600) * 0.02
    values = walk * DEG * 40
    values[generator.random(600) < missing] = np.nan
    sign = 1.0 if side == "high" else -1.0
    rule = LimitRule(
        channel="alpha",
        side=side,
        caution=sign * 3 * DEG,
        warning=sign * 8 * DEG,
        hysteresis=1 * DEG,
        duration=duration,
        armed_at=sign * -2 * DEG if sleeping else None,
        disarmed_at=sign * 15 * DEG if sleeping else None,
    )
    boards = []
    for places in ([0, 600], [0, *sorted(set(cuts)), 600]):
        board = AlarmRegistry()
        monitor = LimitMonitor(LimitSet(own=[rule]), board, RATE)
        for first, last in pairwise(places):
            monitor.feed(block(first, {"alpha": values[first:last]}))
        boards.append(board)
    whole, cut = boards
    assert whole.current_alarms == cut.current_alarms
    assert whole.onsets == cut.onsets
    told = [(round(one.time * RATE), one.severity) for one in whole.onsets if one.key == rule.key]
    worst: dict[int, Severity] = {}
    for index, severity in told:
        worst[index] = max(severity, worst.get(index, Severity.NORMAL))
    assert sorted(worst.items()) == plain_onsets(rule, values)


def test_an_alarm_stays_until_seen_and_over() -> None:
    """Latched when the cause goes, gone once acknowledged; new again when it grows worse."""
    board = AlarmRegistry()
    rule = LimitRule(channel="alpha", side="high", caution=10 * DEG, warning=14 * DEG)
    monitor = LimitMonitor(LimitSet(own=[rule]), board, RATE)

    def fly(first: int, degrees: float) -> Alarm | None:
        monitor.feed(block(first, {"alpha": np.full(50, degrees * DEG)}))
        return board.get("alpha:high")

    assert fly(0, 5.0) is None
    raised = fly(50, 11.0)
    assert (raised.severity, raised.active, raised.time) == (Severity.CAUTION, True, 0.59)
    passed = fly(100, 5.0)
    assert (passed.severity, passed.active) == (Severity.CAUTION, False)
    board.acknowledge("alpha:high", passed.time)
    assert board.current_alarms == ()
    again = fly(150, 12.0)
    board.acknowledge("alpha:high", again.time)
    assert board.get("alpha:high").acknowledged
    assert board.unacknowledged == ()
    worse = fly(200, 15.0)
    assert (worse.severity, worse.acknowledged) == (Severity.WARNING, False)
    milder = fly(250, 12.0)
    assert (milder.severity, milder.current) == (Severity.WARNING, Severity.CAUTION)
    board.acknowledge("alpha:high", milder.time)
    assert board.get("alpha:high").severity is Severity.CAUTION
    fly(300, 5.0)
    assert board.current_alarms == ()
    assert [onset.severity for onset in board.onsets] == [1, 1, 2]


@pytest.mark.parametrize("side", ["high", "low"])
def test_an_episode_holds_the_worst_of_an_alarm_that_grew(side: Literal["high", "low"]) -> None:
    board = AlarmRegistry()
    unit = DEG if side == "high" else -DEG
    rule = LimitRule(channel="alpha", side=side, caution=10 * unit, warning=14 * unit)
    for time, severity, text, value in (
        (1.0, Severity.CAUTION, "far", 11),
        (2.0, Severity.WARNING, "too far", 15),
        (2.5, Severity.CAUTION, "far", 12),
    ):
        board.raise_(rule.key, severity, time, text, rule=rule, value=value * unit)
    alarm = board.get(rule.key)
    assert (alarm.severity, alarm.current, alarm.value) == (
        Severity.WARNING, Severity.CAUTION, 15 * unit
    )  # fmt: skip
    board.clear(rule.key, 3.0)
    (one,) = board.episodes
    assert (one.severity, one.message, one.value) == (Severity.WARNING, "too far", 15 * unit)
    assert (one.onset, one.raised, one.end) == (1.0, 2.0, 3.0)


def test_an_alarm_that_came_back_keeps_its_farthest_value() -> None:
    rule = LimitRule(channel="alpha", side="high", caution=10 * DEG, warning=14 * DEG)
    values = np.concatenate([np.full(50, degrees) for degrees in (15.0, 0.0, 11.0, 0.0)]) * DEG
    for step in (200, 30, 7):
        board = AlarmRegistry()
        monitor = LimitMonitor(LimitSet(own=[rule]), board, RATE)
        for first in range(0, 200, step):
            monitor.feed(block(first, {"alpha": values[first : first + step]}))
        alarm = board.get("alpha:high")
        assert (alarm.severity, alarm.count, alarm.time) == (Severity.WARNING, 2, 1.09)
        assert (alarm.value, alarm.rule.warning) == (15.0 * DEG, 14.0 * DEG)


def test_alarms_speak_as_engineers_do() -> None:
    board = AlarmRegistry()
    aircraft = load_aircraft("b777")
    monitor = LimitMonitor(LimitSet(aircraft), board, RATE)
    monitor.feed(block(0, {"alpha": np.full(50, 15.2 * DEG), "an": np.full(50, 3.7 * 9.80665)}))
    said = [alarm.message_text("US") for alarm in board.current_alarms]
    assert said == [
        "Angle of attack 15.2 deg, above 14.0 deg, stall",
        "Normal acceleration 3.70 g, above 3.60 g, near the g limit",
    ]


def test_newest_first() -> None:
    board = AlarmRegistry()
    board.raise_("link", Severity.WARNING, 3.0, "link lost")
    board.raise_("disk", Severity.CAUTION, 9.0, "disk nearly full")
    board.raise_("recorder", Severity.WARNING, 9.0, "recorder stopped")
    assert [alarm.key for alarm in board.current_alarms] == ["recorder", "disk", "link"]
    # What was raised before there was a flight time stands now, and is told first.
    board.raise_("clock", Severity.CAUTION, None, "clock set back")
    assert [alarm.key for alarm in board.current_alarms] == ["clock", "recorder", "disk", "link"]


def test_stall_speed_is_no_alarm_on_the_ground() -> None:
    board = AlarmRegistry()
    aircraft = load_aircraft("b777")
    stall = aircraft.limits.stall_speed
    monitor = LimitMonitor(LimitSet(aircraft), board, RATE)
    speeds = np.concatenate(
        [
            np.linspace(0.0, 1.6 * stall, 500),
            np.full(200, 1.6 * stall),
            np.linspace(1.6 * stall, 0.95 * stall, 300),
            np.full(100, 0.95 * stall),
        ]
    )
    monitor.feed(block(0, {"Vc": speeds[:600]}))
    assert board.current_alarms == ()
    monitor.feed(block(600, {"Vc": speeds[600:]}))
    assert board.get("Vc:low").severity is Severity.WARNING
    assert "below stall speed" in board.get("Vc:low").message_text()
    monitor.feed(block(1100, {"Vc": np.linspace(0.95 * stall, 0.0, 300)}))
    assert not board.get("Vc:low").active


def _landing(height: float, sensor_noise: float = 1.3) -> dict[str, np.ndarray]:
    """Return speed and altitude of a take-off, and of a stall at a height above the field.

    The field lies at 378 m; the air data have the noise of the B777's probe.
    """
    stall = load_aircraft("b777").limits.stall_speed
    random = np.random.default_rng(4)
    speed = np.concatenate(
        [
            np.full(800, 1.0),
            np.linspace(0.0, 1.6 * stall, 400),
            np.full(600, 1.6 * stall),
            np.linspace(1.6 * stall, 0.8 * stall, 300),
            np.linspace(0.8 * stall, 0.0, 300),
        ]
    )
    above = np.interp(np.arange(speed.size), [0, 1150, 1500, 1700, 1800], [0, 0, 60, 60, height])
    return {
        "Vc": speed + random.normal(0.0, 0.1, speed.size),
        "altitude": 378.0 + above + random.normal(0.0, sensor_noise, speed.size),
    }


def _stall_alarms(
    samples: dict[str, np.ndarray], places: Sequence[int], *, together: bool = True
) -> list[tuple[float | None, Severity]]:
    board = AlarmRegistry()
    limits = LimitSet(load_aircraft("b777"))
    monitor = LimitMonitor(limits, board, RATE, lambda _one, _other: together)
    for first, last in pairwise((0, *places, len(samples["Vc"]))):
        if last > first:
            part = {name: values[first:last] for name, values in samples.items()}
            monitor.feed(block(first, part))
    return [(one.time, one.severity) for one in board.onsets if one.key == "Vc:low"]


@settings(deadline=None, max_examples=25)
@given(cuts=st.lists(st.integers(1, 2399), max_size=10), height=st.sampled_from([0.0, 2.0, 60.0]))
def test_a_landing_is_no_stall_and_a_stall_at_height_is_one(cuts: list[int], height: float) -> None:
    found = _stall_alarms(_landing(height), sorted(set(cuts)))
    assert found == _stall_alarms(_landing(height), ())
    assert [severity for _, severity in found] == (
        [Severity.CAUTION, Severity.WARNING] if height == 60.0 else []
    )


def test_a_landing_that_cannot_be_told_raises_the_alarm() -> None:
    samples = _landing(0.0)
    assert _stall_alarms({"Vc": samples["Vc"]}, ())
    assert _stall_alarms(samples, (), together=False)
    in_flight = {name: values[1400:] for name, values in samples.items()}
    assert _stall_alarms(in_flight, ())
    samples["altitude"][1500:] = np.nan
    assert _stall_alarms(samples, ())


def test_a_pitot_blocked_in_flight_is_no_ground() -> None:
    samples = _landing(60.0)
    blocked = {name: np.insert(values, 1750, values[:600]) for name, values in samples.items()}
    blocked["altitude"][1750:2350] = samples["altitude"][1600]
    assert _stall_alarms(blocked, ())


def test_redundant_sensors_have_their_own_limits_of_plausibility() -> None:
    board = AlarmRegistry()
    monitor = LimitMonitor(LimitSet(load_aircraft("b777")), board, RATE)
    monitor.feed(block(0, {"alpha.2": np.full(100, 20 * DEG)}))
    assert board.current_alarms == ()
    monitor.feed(block(100, {"alpha.2": np.full(100, 55 * DEG)}))
    alarm = board.get("alpha.2:high")
    assert (alarm.value, alarm.rule.channel) == (pytest.approx(55 * DEG), "alpha.2")
    assert "not plausible" in alarm.message_text()


@settings(deadline=None, max_examples=25)
@given(cuts=st.lists(st.integers(1, 1999), max_size=10), lead=st.integers(0, 40))
def test_a_silent_instrument_is_missed_the_same_live_and_replayed(
    cuts: list[int], lead: int
) -> None:
    """Silence of one channel among others, found at the same flight time however cut."""
    q = np.zeros(2000)
    q[300:900] = np.nan
    p = np.zeros(2000)
    p[1600:] = np.nan
    p[1000:1100] = np.nan
    boards = []
    for places in ([0, 2000], [0, *sorted(set(cuts)), 2000]):
        board = AlarmRegistry()
        monitor = MessagePresenceMonitor(board, lambda name: name, 2.0)
        for first, last in pairwise(places):
            # One channel runs ahead of the other, as messages do.
            begin, end = max(first - lead, 0), last if last == 2000 else max(last - lead, 0)
            monitor.feed(block(first, {"q": q[first:last], "r": q[first:last] * 0 + 1}))
            monitor.feed(block(first, {"alpha": np.ones(last - first)}))
            if end > begin:
                monitor.feed(block(begin, {"p": p[begin:end]}))
            monitor.process_step()
        boards.append(board)
    assert boards[0].onsets == boards[1].onsets
    assert boards[0].current_alarms == boards[1].current_alarms
    assert [(onset.key, onset.time) for onset in boards[0].onsets] == [
        ("q:silent", 5.0),
        ("r:silent", 5.0),
        ("p:silent", 18.0),
    ]
    assert boards[0].get("p:silent").active
    assert not boards[0].get("q:silent").active


def test_when_everything_is_silent_no_instrument_is_blamed() -> None:
    board = AlarmRegistry()
    monitor = MessagePresenceMonitor(board, lambda name: name, 2.0)
    monitor.feed(block(0, {"q": np.ones(200)}))
    monitor.process_step()
    monitor.feed(block(200, {"q": np.full(1000, np.nan)}))
    monitor.process_step()
    assert board.current_alarms == ()


@pytest.mark.parametrize("pause", [2.5, 5.0, 60.0])
@pytest.mark.parametrize("last", [0.1, 1.9])
def test_a_link_that_drops_out_and_comes_again_is_no_messages_fault(
    pause: float, last: float
) -> None:
    board = AlarmRegistry()
    monitor = MessagePresenceMonitor(board, lambda name: name)
    rare = np.full(800, np.nan)
    rare[199 - round(last * RATE) :: 200] = 1.0  # the last one so long before the end
    for begin, battery in ((0, rare), (round((8.0 + pause) * RATE), rare[::-1])):
        both = {"q": np.ones(800), "alpha": np.ones(800)}
        monitor.feed(block(begin, {**both, "battery": battery}))
        monitor.process_step()
    assert board.onsets == ()
    gone = round((16.0 + pause) * RATE)
    monitor.feed(block(gone, {"q": np.ones(800)}))
    monitor.process_step()
    assert {alarm.key for alarm in board.current_alarms} == {"alpha:silent", "battery:silent"}


@pytest.mark.parametrize("piece", [50, 370, 6000])
def test_one_lost_of_a_rare_message_is_not_one_that_stays_away(piece: int) -> None:
    board = AlarmRegistry()
    monitor = MessagePresenceMonitor(board, lambda name: name)
    rare = np.full(6000, np.nan)
    rare[::200] = 1.0
    rare[[1600, 3000]] = np.nan
    rare[4001:] = np.nan
    for first in range(0, 6000, piece):
        battery = rare[first : first + piece]
        monitor.feed(block(first, {"q": np.ones(battery.size), "battery": battery}))
        monitor.process_step()
    assert [(onset.key, onset.time) for onset in board.onsets] == [("battery:silent", 46.25)]


def test_a_message_of_which_one_channel_is_dead_has_not_fallen_silent() -> None:
    board = AlarmRegistry()
    carriers = {"q": "daq", "r": "daq", "alpha": "ATTITUDE"}
    monitor = MessagePresenceMonitor(board, carriers.get)
    dead = np.concatenate([np.ones(300), np.full(1500, np.nan)])
    monitor.feed(block(0, {"q": np.ones(1800), "r": dead, "alpha": np.ones(1800)}))
    monitor.process_step()
    assert board.current_alarms == ()


def test_a_box_that_falls_silent_is_one_alarm() -> None:
    board = AlarmRegistry()
    carriers = {"q": "daq", "r": "daq", "alpha": "ATTITUDE"}
    monitor = MessagePresenceMonitor(board, carriers.get)
    gone = np.concatenate([np.ones(300), np.full(1500, np.nan)])
    monitor.feed(block(0, {"q": gone, "r": gone, "V": gone, "alpha": np.ones(1800)}))
    monitor.process_step()
    assert ["daq" in alarm.message_text() for alarm in board.current_alarms] == [True]


def test_limits_files_are_read_and_their_mistakes_are_named(tmp_path: Path) -> None:
    """The shipped table is good; units, order, channel and emptiness are checked with key path."""
    rules = {rule.key: rule for rule in load_limits("b777").rules()}
    assert rules["battery:low"].warning == 10.5
    assert rules["rc_rssi:low"].caution == pytest.approx(0.4)
    path = tmp_path / "own.toml"
    path.write_text(
        '[[limits]]\nchannel = "alpha"\nhigh_caution = "9 deg"\nhysteresis = "1 deg"\n'
        '[[limits]]\nchannel = "temperature"\nhigh_warning = "40 degC"\nhysteresis = "2 degC"\n'
    )
    alpha, temperature = load_limits(path).rules()
    assert alpha.caution == pytest.approx(9 * DEG)
    assert temperature.hysteresis == pytest.approx(2.0)
    path.write_text(
        '[[limits]]\nchannel = "alfa"\nhigh_caution = "9 deg"\n'
        '[[limits]]\nchannel = "alpha"\nhigh_caution = "9 ft"\n'
        '[[limits]]\nchannel = "alpha"\n'
        '[[limits]]\nchannel = "alpha"\nhigh_caution = "9 deg"\nhigh_warning = "8 deg"\n'
    )
    with pytest.raises(FileProblemsError) as caught:
        load_limits(path)
    text = str(caught.value)
    assert "limits[0]" in text
    assert "alpha" in text
    assert "'ft'" in text
    assert "no limit" in text
    assert "in order" in text


def test_the_crews_own_limit_replaces_the_aircrafts(tmp_path: Path) -> None:
    rule = LimitRule(channel="alpha", side="high", caution=7 * DEG)
    limits = LimitSet(load_aircraft("b777"), [rule])
    bands = limits.bands("alpha")
    assert bands.caution_high == 7 * DEG
    assert bands.warning_high is None
    assert bands.caution_low == pytest.approx(-4 * DEG)
    assert limits.bands("battery").warning_low is None


def test_a_limit_that_is_switched_off_raises_nothing(tmp_path: Path) -> None:
    path = tmp_path / "limits.toml"
    path.write_text('[[limits]]\nchannel = "alpha"\noff = true\n', encoding="utf-8")
    limits = LimitSet(load_aircraft("b777"), load_limits(path).rules())
    assert limits.bands("alpha") == LimitBands()
    board = AlarmRegistry()
    LimitMonitor(limits, board, RATE).feed(block(0, {"alpha": np.full(100, 20 * DEG)}))
    assert board.onsets == ()
    path.write_text('[[limits]]\nchannel = "alpha"\noff = true\nhigh_caution = "5 deg"\n')
    with pytest.raises(FileProblemsError, match="switched off"):
        load_limits(path)


def test_typed_limits_count_from_the_next_sample_and_can_be_taken_back() -> None:
    """The alarm of the former limit ends; the typed one is raised; reset brings the first back."""
    board = AlarmRegistry()
    limits = LimitSet(load_aircraft("b777"))
    shipped = limits.bands("alpha")
    watch = AlarmMonitor(board, limits, RATE, lambda _name: None, lambda _one, _other: True)

    def feed(first: int) -> None:
        watch.feed(block(first, {"alpha": np.full(100, 11 * DEG)}))

    feed(0)
    assert board.get("alpha:high").severity is Severity.CAUTION
    limits.set_user_limits("alpha", LimitBands(caution_high=12 * DEG))
    watch.reload_limits("alpha")
    assert not board.get("alpha:high").active
    feed(100)
    assert len(board.onsets) == 1
    limits.set_user_limits("alpha", LimitBands(warning_high=9 * DEG))
    watch.reload_limits("alpha")
    feed(200)
    assert board.get("alpha:high").severity is Severity.WARNING
    assert board.get("alpha:high").message_text("US").endswith("above 9.0 deg, stall")
    limits.set_user_limits("alpha", None)
    watch.reload_limits("alpha")
    assert limits.bands("alpha") == shipped
    feed(300)
    assert board.get("alpha:high").active
    assert board.onsets[-1].severity is Severity.CAUTION


def test_a_typed_stall_speed_still_sleeps_on_the_ground() -> None:
    limits = LimitSet(load_aircraft("b777"))
    limits.set_user_limits("Vc", LimitBands(caution_low=25.0))
    (rule, _) = limits.rules("Vc")
    assert (rule.caution, rule.warning) == (25.0, None)
    assert rule.armed_at == pytest.approx(27.5)
    assert rule.disarmed_at < 25.0
    assert rule.airborne_only


def test_typed_limits_are_kept_in_a_file_with_units(tmp_path: Path) -> None:
    path = tmp_path / "settings" / "limits.toml"
    book = UserLimitStore(path)
    book.write("alpha", LimitBands(caution_high=8 * DEG, warning_high=11 * DEG), "US")
    book.write("q", LimitBands(), "US")
    assert 'high_caution = "8 deg"' in path.read_text(encoding="utf-8")
    again = UserLimitStore(path).limits
    assert again["alpha"].warning_high == pytest.approx(11 * DEG, rel=1e-9)
    assert again["q"] == LimitBands()
    book.write("alpha", None, "US")
    assert set(UserLimitStore(path).limits) == {"q"}
    path.write_text('[[limits]]\nchannel = "alfa"\n', encoding="utf-8")
    damaged = UserLimitStore(path)
    assert "limits.damaged.toml" in damaged.error_text
    assert not damaged.limits
    assert (tmp_path / "settings" / "limits.damaged.toml").exists()


def test_two_windows_type_limits_into_one_file(tmp_path: Path) -> None:
    path = tmp_path / "limits.toml"
    one, other = UserLimitStore(path), UserLimitStore(path)
    assert not other.refresh()
    one.write("alpha", LimitBands(caution_high=8 * DEG), "US")
    other.write("q", LimitBands(caution_high=40 * DEG), "US")
    assert set(UserLimitStore(path).limits) == {"alpha", "q"}
    assert one.refresh()
    assert set(one.limits) == {"alpha", "q"}
    assert not one.refresh()
    path.write_text("no limits", encoding="utf-8")
    assert not one.refresh()
    assert set(one.limits) == {"alpha", "q"}
    path.unlink()
    assert one.refresh()
    assert not one.limits


def test_every_limit_of_the_aircraft_file_is_watched_on_both_sides() -> None:
    aircraft = load_aircraft("b777")
    found = {rule.key: (rule.caution, rule.warning) for rule in aircraft_rules(aircraft)}
    limits = aircraft.limits
    assert found["alpha:high"] == (limits.alpha_linear[1], limits.alpha_stall)
    assert found["alpha:low"] == (limits.alpha_linear[0], None)
    assert found["beta:high"] == (limits.beta_linear, None)
    assert found["beta:low"] == (-limits.beta_linear, None)
    assert found["phi:high"] == (limits.bank, None)
    assert found["phi:low"] == (-limits.bank, None)
    for side, load in zip(("low", "high"), limits.load_factor, strict=True):
        assert found[f"an:{side}"] == (0.9 * load, load)
    for name in ("de", "da", "dr", "flap"):
        low, high = getattr(aircraft.controls, name).travel
        assert found[f"{name}:high"] == (pytest.approx(high + 0.1 * (high - low)), None)
        assert found[f"{name}:low"] == (pytest.approx(low - 0.1 * (high - low)), None)
    assert found["Vc:low"] == (1.1 * limits.stall_speed, limits.stall_speed)


def test_a_limit_that_was_passed_is_kept_off_by_more_than_noise() -> None:
    rules = {rule.key: rule for rule in aircraft_rules(load_aircraft("b777"))}
    for key, rule in rules.items():
        reference = rule.warning if rule.caution is None else rule.caution
        least = 3.0 * channel(rule.channel).precision
        assert rule.hysteresis == pytest.approx(max(least, 0.02 * abs(reference))), key


def test_a_sensor_at_its_stop_is_clipped() -> None:
    limits = LimitSet(load_aircraft("b777"))
    assert limits.is_clipped("q", 90 * DEG)
    assert limits.is_clipped("q.2", -90 * DEG)
    assert not limits.is_clipped("q", 80 * DEG)
    assert not limits.is_clipped("dynamic_pressure", 0.0)
    assert not limits.is_clipped("q", float("nan"))
    assert not limits.is_clipped("battery", 1e9)
