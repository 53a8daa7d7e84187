"""Link health: loss, rate, age and delay, counted right whatever comes twice or late."""

import itertools
import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gsapp.decoding.dialect import dialect
from gsapp.decoding.health import LinkHealth

START = 1_700_000_000_000_000


def attitude(sequence: int, *, system: int = 1, component: int = 1, boot_ms: int = 0) -> bytes:
    module = dialect()
    packer = module.MAVLink(None, srcSystem=system, srcComponent=component)
    packer.seq = sequence % 256
    message = module.MAVLink_attitude_message(boot_ms or sequence * 10, 1, 2, 3, 4, 5, 6)
    return bytes(message.pack(packer))


def heartbeat(sequence: int, system: int, *, kind: int = 1, autopilot: int = 3) -> bytes:
    module = dialect()
    packer = module.MAVLink(None, srcSystem=system, srcComponent=1)
    packer.seq = sequence % 256
    return bytes(module.MAVLink_heartbeat_message(kind, autopilot, 0, 0, 4, 3).pack(packer))


def records(frames, period_us: int = 10_000):
    return [(START + index * period_us, "frame", data) for index, data in enumerate(frames)]


def fed(*items):
    health = LinkHealth()
    health.flown = 1, 1
    for item in items:
        health.feed(item)
    return health


def test_nothing_is_lost_when_nothing_is_lost() -> None:
    health = fed(records([attitude(number) for number in range(1000)]))
    report = health.report()
    assert (report.good, report.lost, report.duplicates, report.reordered) == (1000, 0, 0, 0)
    assert report.rate == pytest.approx(100.0, rel=0.01)
    assert report.messages[0].rate == pytest.approx(100.0, rel=0.01)
    assert report.messages[0].name == "ATTITUDE"
    assert report.warnings == ()


def test_gaps_in_the_sequence_are_losses_across_its_wrap() -> None:
    frames = [attitude(number) for number in range(1000) if number % 10]
    assert fed(records(frames)).lost == 99  # the first of all is not known to be missing


def test_each_component_counts_for_itself() -> None:
    both = itertools.chain.from_iterable(
        (attitude(number, component=1), attitude(2 * number, component=2)) for number in range(200)
    )
    report = fed(records(both)).report()
    assert {sender.component: sender.lost for sender in report.senders} == {1: 0, 2: 199}


def test_the_share_lost_is_that_of_the_frames_however_often_they_come() -> None:
    frames = [attitude(number) for number in range(1000) if number % 10]
    doubled = list(itertools.chain.from_iterable((frame, frame) for frame in frames))
    plain, twice = fed(records(frames)).report(), fed(records(doubled)).report()
    assert plain.loss == twice.loss == 99 / 999
    assert plain.arrived == twice.arrived == 900


def test_duplicates_are_no_losses() -> None:
    frames = [attitude(number) for number in range(300)]
    doubled = list(itertools.chain.from_iterable((frame, frame) for frame in frames))
    report = fed(records(doubled)).report()
    assert (report.good, report.lost, report.duplicates) == (600, 0, 300)
    assert report.messages[0].count == 300


def test_a_late_frame_takes_its_loss_back() -> None:
    frames = [attitude(number) for number in range(300)]
    frames[100], frames[103] = frames[103], frames[100]
    report = fed(records(frames)).report()
    assert (report.good, report.lost, report.duplicates) == (300, 0, 0)
    assert report.reordered == 3


def test_two_paths_with_loss_on_each_count_only_what_neither_brought() -> None:
    frames = [attitude(number) for number in range(2000)]
    arrived = []
    for number, frame in enumerate(frames):
        if number % 5:
            arrived.append(frame)
        if number >= 3 and (number - 3) % 7:  # the other path is three frames later
            arrived.append(frames[number - 3])
    report = fed(records(arrived)).report()
    missing = sum(number % 5 == 0 and number % 7 == 0 for number in range(1, 1997))
    assert abs(report.lost - missing) <= 1
    assert report.warnings == ()


def test_a_burst_before_a_silence_does_not_count_as_lost() -> None:
    """Twenty seconds at 100 Hz, four at 300 Hz, then 1,200 frames are lost in 12 s."""
    usual = [(START + 10_000 * number, "frame", attitude(number)) for number in range(2000)]
    burst = [
        (START + 20_000_000 + 3_333 * k, "frame", attitude(2000 + k, boot_ms=20_000 + 10 * k // 3))
        for k in range(1260)
    ]
    after = [
        (START + 36_200_000 + 10_000 * k, "frame", attitude(4460 + k, boot_ms=36_200 + 10 * k))
        for k in range(300)
    ]
    assert fed(usual, burst, after).lost == 1200


def test_what_a_link_kept_back_is_not_lost() -> None:
    """Six seconds of frames come all at once; three of them are missing."""
    whole = [attitude(number) for number in range(2000) if number not in (700, 701, 702)]
    times = [
        START + 10_000 * k if k < 700 or k >= 1300 else START + 13_000_000 for k in range(1997)
    ]
    frames = [(time, "frame", data) for time, data in zip(times, whole, strict=True)]
    assert fed(frames).lost == 3


def test_a_long_silence_counts_the_rounds_of_the_sequence() -> None:
    before = records([attitude(number) for number in range(500)])
    after = [
        (stamp + 25_000_000, kind, data)
        for stamp, kind, data in records([attitude(number) for number in range(2500, 2600)])
    ]
    assert fed(before, after).lost == pytest.approx(2000, abs=1)


def test_a_restarted_sender_is_no_storm_of_losses() -> None:
    frames = [attitude(number) for number in range(200)] + [attitude(n) for n in range(100)]
    health = fed(records(frames))
    assert health.lost < 128
    assert health.warnings() == ()


def test_two_aircraft_on_one_link_are_named() -> None:
    frames = [heartbeat(0, 1), heartbeat(0, 7), heartbeat(0, 255, kind=6, autopilot=8)]
    (sentence,) = fed(records(frames)).warnings()
    assert "systems 1 and 7" in sentence


def test_two_aircraft_of_the_same_number_are_noticed() -> None:
    both = itertools.chain.from_iterable(
        (attitude(number), attitude(number + 90, boot_ms=number * 10 + 7)) for number in range(600)
    )
    (sentence,) = fed(records(both)).warnings()
    assert "same system id" in sentence


def test_a_sender_that_does_not_count_is_neither_two_aircraft_nor_a_storm_of_losses() -> None:
    frames = [attitude(0, boot_ms=number * 10) for number in range(600)]
    beats = [heartbeat(0, 1)] * 600
    both = list(itertools.chain.from_iterable(zip(frames, beats, strict=True)))
    paused = [(stamp + 60_000_000, kind, data) for stamp, kind, data in records(both)]
    health = fed(records(both), paused)
    (sentence,) = health.warnings()
    assert "System 1, component 1" in sentence
    assert health.lost == 0
    counted = fed(records(both), records([attitude(number) for number in range(600)]))
    assert counted.warnings() == ()  # since it counts


def test_what_a_log_holds_of_a_ground_station_is_no_loss_of_the_link() -> None:
    frames = [heartbeat(3 * number, 255, kind=6, autopilot=8) for number in range(100)]
    assert fed(records(frames)).lost == 0


def test_delay_is_measured_against_the_fastest() -> None:
    frames = []
    for number in range(500):
        late = 80_000 if 200 <= number < 210 else 2_000
        stamp = START + number * 10_000 + late
        frames.append((stamp, "frame", attitude(number, boot_ms=1000 + number * 10)))
    health = LinkHealth()
    health.feed(frames[:205])
    assert health.report().messages[0].delay == pytest.approx(0.078)
    health.feed(frames[205:])
    assert health.report().messages[0].delay == pytest.approx(0.0, abs=1e-6)


def test_the_delay_of_what_is_stamped_with_the_time_of_day_goes_by_its_own_fastest() -> None:
    module = dialect()
    packer = module.MAVLink(None, srcSystem=1, srcComponent=1)
    frames = []
    for number in range(100):
        packer.seq = number
        sent = START - 5_000_000_000 + number * 10_000
        volts = module.MAVLink_debug_float_array_message(sent, b"daq", 0, [0.0] * 58)
        late = 80_000 if number == 99 else 2_000
        frames.append((START + number * 10_000 + late, "frame", bytes(volts.pack(packer))))
    health = fed(frames[:99])
    assert health.report().messages[0].delay == 0.0
    health.feed(frames[99:])
    assert health.report().messages[0].delay == pytest.approx(0.078)


@pytest.mark.parametrize("drift", [-1e-4, 1e-4])
def test_clocks_that_drift_apart_are_no_delay(drift: float) -> None:
    health = LinkHealth()
    worst = 0.0
    for number in range(3600):
        stamp = START + round(1e6 * number * (1.0 + drift))
        health.feed([(stamp, "frame", attitude(number, boot_ms=1000 + 1000 * number))])
        worst = max(worst, health.report().messages[0].delay or 0.0)
    assert worst < 0.02


def test_the_rate_is_told_before_the_first_span_is_over() -> None:
    report = fed(records([attitude(number) for number in range(101)])).report()
    assert report.rate == pytest.approx(100.0, rel=0.02)
    assert report.messages[0].rate == pytest.approx(100.0, rel=0.02)


def test_age_and_rate_of_a_message_that_stopped() -> None:
    health = fed(records([attitude(number) for number in range(500)]))
    last = START + 499 * 10_000
    report = health.report(last + 10_000_000)
    assert report.age == pytest.approx(10.0)
    assert report.messages[0].age == pytest.approx(10.0)
    assert report.messages[0].rate == 0.0
    assert report.rate == 0.0


def test_damage_is_counted_by_the_headers_in_the_residue() -> None:
    good = attitude(1)
    torn = [attitude(2)[:20], attitude(3)[:20]]
    health = fed([(START, "frame", good), (START, "residue", torn[0] + torn[1])])
    assert health.damaged == 2
    pieces = fed(
        [(START, "frame", good)], [(START, "residue", bytes((byte,))) for byte in torn[0] + torn[1]]
    )
    assert pieces.damaged == 2
    assert pieces.residue_bytes == 40


def test_headers_of_the_old_protocol_in_the_residue_are_counted_end_to_end() -> None:
    head = bytes((0xFE, 28, 7, 1, 1, 30))  # ATTITUDE
    health = fed([(START, "frame", attitude(1)), (START, "residue", 3 * head + bytes(4))])
    assert health.damaged == 3


def noise(seconds: float, start: float = 0.0) -> list[tuple[int, str, bytes]]:
    choose = random.Random(5)
    return [
        (START + int((start + 0.02 * k) * 1e6), "residue", choose.randbytes(100))
        for k in range(int(seconds / 0.02))
    ]


def unknown(sequence: int, system: int) -> bytes:
    return bytes((0xFD, 4, 0, 0, sequence % 256, system, 7, 0x11, 0x22, 0x33)) + b"abcdef"


def test_chance_frames_in_what_cannot_be_read_do_not_pass_for_senders() -> None:
    health = LinkHealth()
    for k, piece in enumerate(noise(120.0)):
        health.feed([piece])
        if k % 400 == 200:
            health.feed([(piece[0], "frame", unknown(k, 3 + k // 400)), (piece[0], "line", b"~")])
        assert bool(health.unreadable) == (k >= 150)
    # Nor do headers that turn up more often than chance would have it.
    for k in range(25):
        stamp = START + 120_000_000 + k
        health.feed([(stamp, "residue", attitude(1)[:12] + bytes(900))])
    report = health.report()
    assert (report.good, report.unknown, report.senders, report.lost) == (0, 15, (), 0)
    assert report.warnings == (report.unreadable,)
    assert "baud rate" in report.unreadable
    after = [(stamp + 130_000_000, kind, data) for stamp, kind, data in records([attitude(1)])]
    health.feed(after)
    assert health.warnings() == ()


def test_a_link_that_cannot_be_read_any_more_is_told_and_a_burst_is_not() -> None:
    health = fed(records([attitude(number) for number in range(100)]))
    health.feed(noise(2.0, start=1.0))
    assert health.unreadable == ""
    health.feed(noise(3.0, start=3.0))
    assert health.unreadable


def test_bursts_of_noise_between_good_frames_do_not_add_up() -> None:
    health = LinkHealth()
    for k in range(4):
        stamp = START + 10_000_000 * k
        health.feed([(stamp, "frame", attitude(k)), (stamp + 4_000_000, "residue", bytes(900))])
        assert health.unreadable == ""
    health.feed([(START + 34_100_000, "residue", bytes(200))])
    assert health.unreadable != ""


def test_lines_among_noise_prove_that_a_link_of_text_can_be_read() -> None:
    line, stamp = b"1.0,2.0,3.0,4.0,5.0", START
    health = LinkHealth()
    for k in range(200):
        stamp = START + 100_000 * k
        health.feed([(stamp, "line", line), (stamp, "residue", bytes(2 * len(line)))])
    assert health.unreadable == ""
    health.feed([(stamp, "residue", bytes(1000))])
    assert health.unreadable != ""


def test_frames_of_another_dialect_alone_are_not_called_unreadable() -> None:
    health = LinkHealth()
    for k, (stamp, kind, data) in enumerate(noise(10.0)):
        health.feed([(stamp, "frame", unknown(k, 1) + bytes(24)), (stamp, kind, data[:100])])
    assert health.unreadable == ""


def test_a_host_clock_that_runs_backwards_breaks_nothing() -> None:
    frames = records([attitude(number) for number in range(300)])
    jumped = [(stamp - 3_600_000_000, kind, data) for stamp, kind, data in frames[150:]]
    report = fed(frames[:150], jumped).report()
    assert (report.good, report.lost) == (300, 0)


@given(st.lists(st.integers(1, 40), min_size=1, max_size=10))
@settings(max_examples=25, deadline=None)
def test_the_report_does_not_depend_on_the_pieces(cuts) -> None:
    frames = [attitude(number, system=1 + number % 2) for number in range(150) if number % 7]
    items = records(frames)
    items.insert(40, (items[39][0], "residue", attitude(9)[:15]))
    items.insert(41, (items[39][0], "residue", b"more"))
    health, start = fed(), 0
    for size in itertools.cycle(cuts):
        if start >= len(items):
            break
        health.feed(items[start : start + size])
        start += size
    assert health.report() == fed(items).report()
