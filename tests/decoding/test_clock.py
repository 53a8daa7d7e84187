"""Flight time: unwrapped, continued over restarts, not led astray by one bad stamp."""

import random

import pytest

from gsapp.decoding.flight_clock import FlightClock

HOST = 1_700_000_000_000_000
MS_TURN = 2**32 * 1000
US_TURN = 2**32


class Case:
    """A clock with what it placed, in order."""

    def __init__(self) -> None:
        self.clock = FlightClock()
        self.placed: list[tuple[str, int]] = []

    def stamp(self, stamp: int, host: int, *, component: int = 1, period: int = 0,
              item: str = "") -> None:  # fmt: skip
        time = self.clock.assign_time(component, stamp, HOST + host, item, period=period)
        self._take(item, time)

    def arrive(self, host: int, item: str = "arrival") -> None:
        self._take(item, self.clock.assign_arrival_time(HOST + host, item))

    def finish(self) -> None:
        self.clock.finish()
        self._take("", None)

    def _take(self, item: str, time: int | None) -> None:
        self.placed += [(placed.item, placed.time) for placed in self.clock.released]
        self.clock.released.clear()
        if time is not None:
            self.placed.append((item, time))

    @property
    def times(self) -> list[int]:
        return [time for _, time in self.placed]

    @property
    def kinds(self) -> list[str]:
        return [event.kind for event in self.clock.events]


def test_stamps_since_boot_are_flight_time() -> None:
    case = Case()
    for k in range(5):
        case.stamp(7_000_000 + 10_000 * k, 10_000 * k)
    assert case.times == [7_000_000 + 10_000 * k for k in range(5)]
    assert case.kinds == []


def test_32_bit_milliseconds_go_on_after_49_days() -> None:
    case = Case()
    start = MS_TURN - 50_000
    for k in range(20):
        case.stamp((start + 10_000 * k) % MS_TURN, 10_000 * k, period=MS_TURN)
    assert case.times == [start + 10_000 * k for k in range(20)]
    assert case.kinds == []


def test_32_bit_microseconds_take_their_turn_from_another_message() -> None:
    case = Case()
    true = 3 * US_TURN + 5_000_000
    for k in range(10):
        case.stamp((true + 20_000 * k) % US_TURN, 20_000 * k, period=US_TURN, item="servo")
        case.stamp(true + 20_000 * k, 20_000 * k + 10, period=MS_TURN, item="attitude")
    servo = [time for item, time in case.placed if item == "servo"]
    assert servo == [true + 20_000 * k for k in range(10)]
    assert case.kinds == []


def test_32_bit_microseconds_that_join_later_take_their_turn_at_once() -> None:
    case = Case()
    true = 2 * US_TURN - 30_000
    for k in range(10):
        case.stamp(true + 20_000 * k, 20_000 * k, period=MS_TURN, item="attitude")
        if k:
            narrow = (true + 20_000 * k) % US_TURN
            case.stamp(narrow, 20_000 * k, component=2, period=US_TURN, item="servo")
    servo = [time for item, time in case.placed if item == "servo"]
    assert servo == [true + 20_000 * k for k in range(1, 10)]
    assert case.kinds == []


@pytest.mark.parametrize("minutes", [10, 50, 100])
def test_a_restart_is_no_turn_of_a_32_bit_count(minutes: int) -> None:
    case = Case()
    last = minutes * 60_000_000
    for k in range(100):
        case.stamp((last + 10_000 * k) % US_TURN, 10_000 * k, period=US_TURN)
        case.stamp(last + 10_000 * k, 10_000 * k, item="other")
    for k in range(100):
        case.stamp(10_000 * k, 4_000_000 + 10_000 * k, period=US_TURN)
    assert case.kinds == ["restart"]
    assert case.clock.now == last + 4_990_000


def test_32_bit_microseconds_alone_still_count() -> None:
    case = Case()
    for k in range(4):
        case.stamp(20_000 * k, 20_000 * k, period=US_TURN, item="servo")
    assert case.placed == []
    case.finish()
    assert case.times == [0, 20_000, 40_000, 60_000]


def test_counting_from_1970_begins_at_its_own_first_second() -> None:
    case = Case()
    unix = HOST + 123_456
    for k in range(4):
        case.stamp(unix + 10_000 * k, 10_000 * k)
    assert case.times == [unix % 1_000_000 + 10_000 * k for k in range(4)]


def test_both_ways_of_counting_agree_by_system_time() -> None:
    """SYSTEM_TIME relates the count from 1970 to that since boot, to the microsecond."""
    case = Case()
    unix = HOST - 33_000_000_123
    case.clock.set_unix_offset(unix + 40_000_000, 40_000_000)
    for k in range(5):
        case.stamp(40_000_000 + 10_000 * k, 10_000 * k + 900, item="boot")
        case.stamp(unix + 40_000_000 + 10_000 * k, 10_000 * k + 5_000, item="unix")
    boot = [time for item, time in case.placed if item == "boot"]
    assert [time for item, time in case.placed if item == "unix"] == boot
    assert case.kinds == []


def test_a_restart_goes_on_by_arrival_and_is_reported() -> None:
    case = Case()
    for k in range(100):
        case.stamp(500_000_000 + 10_000 * k, 10_000 * k + 2_000)
    for k in range(100):
        case.stamp(10_000 * k, 4_000_000 + 10_000 * k + 2_000)
    assert case.kinds == ["restart"]
    assert "restarted" in case.clock.events[0].text
    assert case.clock.events[0].time == case.times[99]  # where the clock was last heard before
    assert len(case.times) == 200
    assert case.times == sorted(case.times)
    # Four seconds after the first sample, as it arrived.
    assert case.times[100] == 504_000_000
    assert case.times[199] == 504_990_000


@pytest.mark.parametrize("period", [0, US_TURN])
@pytest.mark.parametrize("back", [150, 300, 800, 1500, 1990, 2010, 2500, 4000])
def test_a_clock_that_is_set_back_a_little_loses_no_sample(back: int, period: int) -> None:
    case = Case()
    for k in range(1000):
        # From where it was set on, the link is slower and less even.
        stamp = 7_000_000 + 10_000 * k - (1000 * back if k >= 500 else 0)
        case.stamp(stamp, 10_000 * k + (k * 7919 % 15_000 if k >= 500 else 0), period=period)
    case.finish()
    assert case.kinds == ["restart"]
    assert len(case.times) == 1000
    assert case.times == sorted(case.times)
    assert case.times[-1] == pytest.approx(16_990_000, abs=20_000)
    assert case.clock.dropped == 0


@pytest.mark.parametrize("count", [3, 60, 150])
def test_what_was_kept_back_on_the_way_is_no_restart(count: int) -> None:
    """The newest comes first, and at once all those before it: each keeps its own time."""
    case = Case()
    order = [*range(100), 100 + count, *range(100, 100 + count), *range(101 + count, 400)]
    for k in order:
        case.stamp(10_000 * k, 10_000 * max(k, 100 + count if k >= 100 else 0), item=str(k))
    case.finish()
    assert case.kinds == []
    assert dict(case.placed) == {str(k): 10_000 * k for k in range(400)}


@pytest.mark.parametrize("way", ["uneven", "two ways", "stalls"])
@pytest.mark.parametrize("most", [0.02, 0.3, 1.5])
def test_no_way_that_delays_each_message_by_itself_looks_like_a_restart(
    way: str, most: float
) -> None:
    draw = random.Random(18)
    sent = [4000 * k for k in range(5000)]
    free = 0.0
    came = []
    for stamp in sent:
        if way == "stalls":
            free = stamp + 1e6 * most if stamp > free and draw.random() < 0.002 else free
            delay = max(0.0, free - stamp) + draw.uniform(0.0, 5000.0)
        else:
            delay = 1e6 * most * (draw.random() if way == "uneven" else draw.randrange(2))
        came.append((round(stamp + delay), stamp))
    case = Case()
    for host, stamp in sorted(came):
        case.stamp(7_000_000 + stamp, host)
    case.finish()
    assert case.kinds == []
    assert sorted(case.times) == [7_000_000 + stamp for stamp in sent]


@pytest.mark.parametrize("behind", [200, 700, 1200])
def test_messages_that_are_always_late_may_be_the_only_ones_for_a_while(behind: int) -> None:
    case = Case()
    for k in range(1500):
        if not 500 <= k < 800:
            case.stamp(7_000_000 + 10_000 * k, 10_000 * k, item="quick")
        if k % 5 == 0:
            case.stamp(7_000_000 + 10_000 * k - 1000 * behind, 10_000 * k + 100, item="late")
    case.finish()
    assert case.kinds == []
    late = [time for item, time in case.placed if item == "late"]
    assert late == [7_000_000 + 10_000 * k - 1000 * behind for k in range(0, 1500, 5)]


@pytest.mark.parametrize("wrong", [0, 499_000_000, 513_000_000, 600_000_000, 4_000_000_000_000_000])
def test_one_outlier_is_dropped_and_reported(wrong: int) -> None:
    case = Case()
    for k in range(50):
        case.stamp(510_000_000 + 10_000 * k, 10_000 * k)
        if k == 25:
            case.stamp(wrong, 10_000 * k + 1)
    case.finish()
    assert case.times == [510_000_000 + 10_000 * k for k in range(50)]
    assert case.kinds == ["outlier"]
    assert case.clock.dropped == 1
    assert f"{wrong / 1e6:.3f} s" in case.clock.events[0].text


def test_what_came_late_as_the_record_ends_has_its_own_time() -> None:
    case = Case()
    for k in range(50):
        case.stamp(7_000_000 + 10_000 * k, 10_000 * k)
    case.stamp(7_000_000 + 100_000, 500_000, item="late")
    case.finish()
    assert ("late", 7_100_000) in case.placed
    assert case.clock.dropped == 0
    case.stamp(600_000_000, 510_000, item="wrong")
    case.finish()
    assert "wrong" not in dict(case.placed)
    assert case.clock.dropped == 1


def test_a_bad_first_stamp_does_not_become_the_truth() -> None:
    case = Case()
    case.stamp(3_000_000_000_000, 0)
    for k in range(10):
        case.stamp(5_000_000 + 10_000 * k, 10_000 * k + 5)
    assert case.times == [5_000_000 + 10_000 * k for k in range(10)]


def test_reordered_stamps_are_placed_where_they_belong() -> None:
    case = Case()
    for stamp in (0, 10_000, 30_000, 20_000, 40_000):
        case.stamp(stamp, 50_000)
    assert case.times == [0, 10_000, 30_000, 20_000, 40_000]
    assert case.kinds == []


def test_a_pause_of_the_link_is_a_pause() -> None:
    case = Case()
    for base in (0, 1_200_000_000):
        for k in range(3):
            case.stamp(base + 10_000 * k, base + 10_000 * k)
    assert case.times[3] == 1_200_000_000
    assert case.kinds == []


def test_a_clock_that_steps_ahead_is_believed_and_reported() -> None:
    case = Case()
    for k in range(200):
        case.stamp(10_000 * k + (60_000_000 if k >= 100 else 0), 10_000 * k)
    assert case.kinds == ["step"]
    assert case.times[-1] == 61_990_000
    assert len(case.times) == 200


def test_a_clock_set_ahead_by_years_does_not_stretch_the_flight() -> None:
    case = Case()
    for k in range(200):
        case.stamp(10_000 * k + (10**14 if k >= 100 else 0), 10_000 * k)
    assert case.kinds == ["restart"]
    assert case.times == [10_000 * k for k in range(200)]


def test_another_component_with_its_own_clock_is_laid_beside() -> None:
    case = Case()
    for k in range(50):
        case.stamp(300_000_000 + 10_000 * k, 10_000 * k + 1_000)
        case.stamp(7_000_000 + 10_000 * k, 10_000 * k + 1_000, component=100, item="camera")
    camera = [time for item, time in case.placed if item == "camera"]
    assert camera[0] == pytest.approx(300_000_000, abs=20_000)
    assert len(camera) == 50
    assert case.kinds == ["other-clock"]


@pytest.mark.parametrize("drift", [-8e-5, 0.0, 8e-5])
def test_arrivals_follow_the_lower_envelope_over_an_hour_of_drift(drift: float) -> None:
    """With jitter of up to 0.1 s and drifting clocks arrivals are placed within 3 ms."""
    case = Case()
    generator = random.Random(1)
    for k in range(36_000):
        stamp = 100_000 * k
        sent = round(stamp * (1.0 + drift)) + 5_000
        delay = generator.choice((0, 0, generator.randrange(100_000)))
        case.clock.assign_time(1, stamp, HOST + sent + delay, None)
        if k > 100 and k % 100 == 0:
            true = stamp
            assert case.clock.flight_time(HOST + sent) == pytest.approx(true, abs=3_000)
            assert case.clock.delay(stamp, HOST + sent + 50_000) == pytest.approx(50_000, abs=3_000)


def test_arrivals_wait_for_the_first_stamp() -> None:
    case = Case()
    case.arrive(0)
    case.arrive(500_000)
    case.stamp(10_000_000, 1_000_000)
    case.stamp(10_010_000, 1_010_000)
    assert sorted(case.times) == [9_000_000, 9_500_000, 10_000_000, 10_010_000]


def test_without_any_stamp_flight_time_is_arrival() -> None:
    case = Case()
    for k in range(40):
        case.arrive(1_000_000 * k)
    assert case.times == [1_000_000 * k for k in range(40)]
    assert case.kinds == ["no-clock"]


@pytest.mark.parametrize("leap", [3_600_000_000, -3_600_000_000])
@pytest.mark.parametrize("period", [0, MS_TURN])
def test_a_computer_whose_clock_is_set_begins_its_delays_anew(leap: int, period: int) -> None:
    """An hour's jump of the host clock keeps no stamp back; ahead it could be a delay, and is told.

    Back it needs no word: nothing arrives before it was sent, so the delays are known at once.
    """
    case = Case()
    for k in range(200):
        case.stamp(10_000 * k, 10_000 * k + (leap if k >= 100 else 0), period=period)
        assert len(case.times) == (k + 1 if k else 0)
    assert case.times == [10_000 * k for k in range(200)]
    assert case.kinds == (["host-step"] if leap > 0 else [])
    assert case.clock.flight_time(HOST + leap + 2_000_000) == pytest.approx(2_000_000, abs=1000)


@pytest.mark.parametrize("leap", [45_000_000, 3_600_000_000, 20 * 365 * 86_400_000_000])
@pytest.mark.parametrize("rate", [1, 100])
def test_arrivals_stay_in_place_when_the_computers_clock_is_set(leap: int, rate: int) -> None:
    case = Case()
    step = 1_000_000 // rate
    for k in range(40 * rate):
        host = step * k + (leap if k >= 10 * rate else 0)
        if k % 2:
            case.arrive(host, "arrival")
        case.stamp(step * k, host, item="stamp", period=MS_TURN)
    case.finish()
    arrived = [time for item, time in case.placed if item == "arrival"]
    assert arrived == pytest.approx(list(range(step, 40_000_000, 2 * step)), abs=10_000)
    assert case.kinds == ["host-step"]
    assert case.clock.now == step * (40 * rate - 1)


def test_what_the_link_kept_back_for_a_minute_is_no_clock_that_was_set() -> None:
    """It comes all at once; messages without a stamp count at the stamps they came among."""
    case = Case()
    for k in range(12_000):
        host = 10_000 * k if not 2_000 <= k < 8_000 else 80_000_000 + k
        case.arrive(host, f"{k}")
        case.stamp(10_000 * k, host, item="stamp")
    arrived = {int(item): time for item, time in case.placed if item != "stamp"}
    assert all(abs(time - 10_000 * k) < 300_000 for k, time in arrived.items())
    assert len(arrived) == 12_000
    assert case.kinds == []


def test_arrivals_go_on_when_all_stamps_have_ended() -> None:
    case = Case()
    for k in range(100):
        case.stamp(10_000 * k, 10_000 * k, item="stamp")
    for k in range(200):
        case.arrive(100_000_000 + 500_000 * k)
    arrived = [time for item, time in case.placed if item == "arrival"]
    assert arrived == pytest.approx([100_000_000 + 500_000 * k for k in range(200)], abs=50_000)


def test_a_clock_that_stands_still_is_ignored_and_reported() -> None:
    case = Case()
    for k in range(1000):
        case.stamp(0, 10_000 * k)
    assert case.kinds == ["frozen-clock"]
    late = case.times[310:]
    assert late == sorted(set(late))
    assert late[-1] == pytest.approx(9_990_000, abs=5_000)


def test_a_repeated_message_after_a_pause_is_no_frozen_clock() -> None:
    """The same stamp once more, seconds later, keeps its time."""
    case = Case()
    for host in (0, 10_000, 6_000_000):
        case.stamp(min(host, 10_000), host)
    assert case.times == [0, 10_000, 10_000]
    assert case.kinds == []


def test_two_vehicles_of_one_number_do_not_flood_the_reports() -> None:
    case = Case()
    for k in range(1000):
        case.stamp(500_000_000 + 10_000 * k, 10_000 * k)
        case.stamp(90_000_000 + 10_000 * k, 10_000 * k + 1)
    assert case.times == [500_000_000 + 10_000 * k for k in range(1000)]
    assert set(case.kinds) == {"outlier"}
    assert len(case.kinds) <= 4
    assert case.clock.dropped >= 990


def test_a_clock_that_goes_back_and_stands_still() -> None:
    case = Case()
    for k in range(100):
        case.stamp(500_000_000 + 10_000 * k, 10_000 * k)
    for k in range(1000):
        case.stamp(0, 1_000_000 + 10_000 * k)
    assert case.kinds[0] == "restart"
    assert len(case.times) == 1100
    assert case.times[-1] == pytest.approx(510_990_000, abs=20_000)


def test_what_a_link_kept_back_is_timed_by_the_stamps_beside_it() -> None:
    case = Case()
    second = 1_000_000
    for k in range(100):  # ten seconds; what left after the third comes at the end of the tenth
        sent = 100_000 * k
        host = sent if sent < 3 * second else max(sent, 10 * second)
        case.stamp(sent, host, item="stamped")
        case.arrive(host + 1, item=f"beside {sent}")
    beside = {int(item[7:]): time for item, time in case.placed if item.startswith("beside")}
    assert len(beside) == 100
    # Within the second from which on it is a backlog arrivals tell.
    assert all(abs(time - sent) <= second for sent, time in beside.items())
    assert all(time == sent for sent, time in beside.items() if 3 * second <= sent < 8.9 * second)
    # Stamps that end hold nothing up, and one that was late on its way is no backlog.
    case.arrive(14 * second, item="alone")
    assert case.placed[-1][1] == pytest.approx(14 * second, abs=5000)  # the clocks may drift
    case.stamp(14 * second, 14 * second)
    case.stamp(13 * second - 500_000, 14 * second + 1)
    case.arrive(14 * second + 2, item="after a late one")
    assert case.placed[-1][1] == pytest.approx(14 * second, abs=5000)
