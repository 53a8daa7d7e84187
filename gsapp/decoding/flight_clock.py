"""Flight time: the vehicle's own stamps, unwrapped; and what host time is to it.

Times are whole microseconds here, so that nothing depends on rounding. A vehicle may stamp its
messages since it was switched on (``time_boot_ms``, ``time_usec``) or since 1970; each component
may have a clock of its own. Every such clock is a *line*: flight time = stamp + offset. The first
line heard defines flight time. Another one that agrees with it within seconds is the same clock;
one that does not is laid beside it by the time of arrival, and reported.

A stamp that is far from where its line must be by now, or older than the line by more than its
messages are wont to be, is held back. If the line goes on where it was, the stamp was reordered on
the way or, where it is farther off, an outlier that is dropped. If the next ones go on from the new
place, the vehicle has restarted (or its clock was set): its line gets a new offset, so that flight
time goes on by the time of arrival, which is uncertain by the delay of the link, and this is
reported.

Everything is decided record by record, from stamps alone.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

from gsapp.decoding.settings import DECODING

WRAP_PERIOD_32BIT = 2**32
"""32 bits of microseconds start over every 72 minutes."""

MIN_UNIX_STAMP = 10**15
"""Stamps from here on (September 2001) count from 1970, not from switching on."""


_BACKLOG_PAUSE = 200_000
"""Between a stamp and an arrival that belong to one backlog, us."""


class TimedItem(NamedTuple):
    """An item with its flight time, microseconds."""

    time: int
    item: Any


@dataclass(frozen=True, slots=True, kw_only=True)
class ClockEvent:
    """Something that happened to a clock."""

    kind: str
    time: int
    """Flight time, microseconds."""
    text: str


class _HeldItem(NamedTuple):
    stamp: int
    host: int
    item: Any


class _VehicleClock:
    """One clock of the vehicle."""

    __slots__ = ("behind", "held", "host", "last", "offset", "repeats")

    def __init__(self) -> None:
        self.behind = 0  # by how much stamps were behind the newest while it went on
        self.last: int | None = None
        self.host = 0
        self.offset = 0
        self.repeats = 0
        self.held: list[_HeldItem] = []


class FlightClock:
    """Places stamps, and arrivals without a stamp, in flight time.

    `assign_time` and `assign_arrival_time` return the flight time of an item at once in the usual
    case. Where an item has to wait they return None, and hand it out later in `released`: the
    caller looks there after every call and empties it, and likewise `events`: restarts, outliers,
    clocks that disagree. `now` is the latest flight time placed (us), `dropped` counts items with
    an impossible stamp.
    """

    def __init__(self) -> None:
        self.now = 0
        self.first: int | None = None
        self.released: list[TimedItem] = []
        self.events: list[ClockEvent] = []
        self.dropped = 0
        self._lines: dict[tuple[int, bool], _VehicleClock] = {}
        self._unix_minus_boot: int | None = None
        self._envelope: float | None = None
        self._envelope_host = 0
        self._backlog = 0.0  # Delay of the newest stamp beyond the least.
        self._stamped = False
        self._above: list[_HeldItem] = []
        self._waiting: list[_HeldItem] = []
        self._narrow: list[tuple[int, int, _HeldItem]] = []

    def assign_time(
        self, component: int, stamp: int, host: int, item: Any, *, period: int = 0
    ) -> int | None:
        """Return the flight time (us) of a component's stamp; None if it waits, or was dropped.

        Stamp and time of arrival at the host are in us. The item is handed back in `released` if it
        must wait. After `period` us the stamp starts over at zero; 0 for never.
        """
        line = self._lines.get((component, stamp >= MIN_UNIX_STAMP))
        last = None if line is None else line.last
        if line is None or last is None:
            if self._envelope is None and 0 < period <= WRAP_PERIOD_32BIT:
                # Another stamp must tell how often this one has started over.
                self._narrow.append((component, period, _HeldItem(stamp, host, item)))
                self._give_up_waiting(host)
                return None
            line = self._lines.setdefault((component, stamp >= MIN_UNIX_STAMP), _VehicleClock())
            return self._begin(component, line, _HeldItem(stamp, host, item), period)
        passed = host - line.host
        if passed < 0:
            passed = 0
        unwrapped = stamp
        if period:
            # No flight pauses for weeks: by so much the host's clock may be set, and tells nothing.
            expected = last + passed if period <= WRAP_PERIOD_32BIT else last
            unwrapped += (expected - stamp + period // 2) // period * period
        ahead = unwrapped - last
        held = line.held
        if held and _continues_held_stamps(line, unwrapped, host):
            held.append(_HeldItem(unwrapped, host, item))
            self._move(line)
            return None
        if -line.behind <= ahead <= DECODING.max_stamp_lead + passed:
            if held:
                self._let_go(line)
            if ahead > 0:
                line.last = unwrapped
                line.host = host
                line.repeats = 0
            elif (
                ahead == 0
                and passed > DECODING.frozen_clock_time
                and self._stands_still(component, line)
            ):
                time = self.flight_time(host)
                self._pass(time)
                return time
            time = unwrapped + line.offset
            self._observe(time, host)
            return time
        self._suspect(
            line, _HeldItem(unwrapped if abs(ahead) <= DECODING.max_set_back else stamp, host, item)
        )
        return None

    def assign_arrival_time(self, host: int, item: Any) -> int | None:
        """Return the flight time of an arrival: of a message that carries no stamp.

        It is the time at which a message that left now, with the least delay known, would
        arrive; where a link delivers what it kept back, that of the newest stamp. None if no stamp
        was seen yet, or if the host's clock may have been set since the last one; the item then
        waits for the next stamps.
        """
        if self._envelope is None or self._may_be_set(host):
            self._waiting.append(_HeldItem(0, host, item))
            self._give_up_waiting(host)
            return None
        time = self.flight_time(host)
        if self._backlog > DECODING.min_backlog and host - self._envelope_host <= _BACKLOG_PAUSE:
            time = min(time, self.now)  # It was kept back with the stamps beside it.
        self._pass(time)
        return time

    def set_unix_offset(self, unix: int, boot: int) -> None:
        """Take note that a vehicle's two ways of counting are this far apart (SYSTEM_TIME)."""
        if unix >= MIN_UNIX_STAMP:
            self._unix_minus_boot = unix - boot

    def flight_time(self, host: int) -> int:
        """Return the flight time (us) at a host time (us), as the fastest message tells it."""
        return host - round(self._risen(host))

    def delay(self, time: int, host: int) -> int:
        return host - time - round(self._envelope or 0.0)

    def finish(self) -> None:
        """Release what still waits: no other stamp will come."""
        for key, line in list(self._lines.items()):
            if not line.held:
                continue
            if line.last is not None:
                self._let_go(line)
            elif self._envelope is None:
                self._settle_first(key[0], line)
            else:
                # A clock that told one time only, beside one that goes on, is not believed.
                self._drop(line.held)
                line.held = []
        if self._envelope is None and (self._waiting or self._narrow):
            self._begin_by_arrival()
        elif self._waiting:
            self._release_waiting()

    def _may_be_set(self, host: int) -> bool:
        return self._stamped and (
            bool(self._above) or self.flight_time(host) - self.now > DECODING.min_host_clock_step
        )

    def _begin(
        self, component: int, line: _VehicleClock, held: _HeldItem, period: int
    ) -> int | None:
        """Take up a new line at its second stamp that agrees with the one before."""
        if period and self._envelope is not None:
            expected = self.flight_time(held.host)
            turns = (expected - held.stamp + period // 2) // period
            held = _HeldItem(held.stamp + max(turns, 0) * period, held.host, held.item)
        agreeing = [each for each in line.held if _are_consistent_stamps(each, held)]
        if agreeing:
            self.dropped += len(line.held) - len(agreeing)
            line.held = [*agreeing, held]
            self._settle_first(component, line)
        else:
            line.held.append(held)
            if len(line.held) > DECODING.max_held_stamps:
                del line.held[0]
                self.dropped += 1
        return None

    def _settle_first(self, component: int, line: _VehicleClock) -> None:
        first = line.held[0]
        if self._envelope is None:
            # Counted since 1970 the number says nothing; begin at the whole second before.
            line.offset = (
                -(first.stamp // 1_000_000 * 1_000_000) if first.stamp >= MIN_UNIX_STAMP else 0
            )
        else:
            line.offset = self._offset_beside(component, first)
        self._release(line)

    def _offset_beside(self, component: int, first: _HeldItem) -> int:
        expected = self.flight_time(first.host)
        known = {0, *(other.offset for other in self._lines.values() if other.last is not None)}
        if first.stamp >= MIN_UNIX_STAMP and self._unix_minus_boot is not None:
            known |= {offset - self._unix_minus_boot for offset in list(known)}
        best = min(sorted(known), key=lambda offset: abs(first.stamp + offset - expected))
        if abs(first.stamp + best - expected) <= DECODING.same_clock_tolerance:
            return best
        self._tell(
            "other-clock",
            expected,
            f"component {component} has a different time origin; its messages are timed by arrival",
        )
        return expected - first.stamp

    def _stands_still(self, component: int, line: _VehicleClock) -> bool:
        """Count a stamp seen long ago; return whether the clock is to be ignored for it."""
        line.repeats += 1
        if line.repeats == DECODING.confirm_count:
            self._tell(
                "frozen-clock",
                self.now,
                f"the clock of component {component} is stuck at {(line.last or 0) / 1e6:.3f} "
                "s; its messages are timed by arrival",
            )
        return line.repeats >= DECODING.confirm_count

    def _suspect(self, line: _VehicleClock, held: _HeldItem) -> None:
        """Hold a stamp that does not fit its line, and see whether the line has moved."""
        if line.held and not _are_consistent_stamps(line.held[-1], held):
            self._let_go(line)
        line.held.append(held)
        if len(line.held) < DECODING.confirm_count:
            return
        first = line.held[0]
        span, passed = held.stamp - first.stamp, held.host - first.host
        if _is_reordered(line, first) and _arrived_in_burst([first, held]):
            return  # they come all at once: what was kept back on the way
        if span >= DECODING.confirm_span or passed >= DECODING.confirm_host:
            self._move(line)

    def _let_go(self, line: _VehicleClock) -> None:
        """Place what was held and is but reordered, since the line goes on; drop the rest."""
        held, line.held = line.held, []
        late: list[_HeldItem] = []
        strange: list[_HeldItem] = []
        for each in held:
            (late if _is_reordered(line, each) else strange).append(each)
        if late and len(late) < DECODING.confirm_count:
            line.behind = max(line.behind, *((line.last or 0) - each.stamp for each in late))
        self._hand_out(line, late)
        if strange:
            self._drop(strange)

    def _move(self, line: _VehicleClock) -> None:
        """Believe that the line goes on from another place."""
        first = line.held[0]
        last = line.last or 0
        passed = max(first.host - line.host, 0)
        step = first.stamp - last
        before = last + line.offset
        if 0 < step - passed <= DECODING.max_pause:
            self._tell(
                "step",
                before,
                f"the vehicle's clock advanced by {step / 1e6:.1f} s while {passed / 1e6:.1f} s "
                "passed here; treated as a link pause",
            )
        else:
            line.offset += last + max(passed, 1) - first.stamp
            what = "restarted: its clock stepped back" if step < 0 else "set its clock ahead"
            self._tell(
                "restart",
                before,
                f"the vehicle {what} from {last / 1e6:.1f} to {first.stamp / 1e6:.1f} s at "
                f"{before / 1e6:.1f} s of the flight; flight time continues by arrival time, "
                "uncertain by the link delay",
            )
        self._release(line)

    def _release(self, line: _VehicleClock) -> None:
        held, line.held = line.held, []
        newest = max(held, key=lambda each: each.stamp)
        line.last, line.host = newest.stamp, newest.host
        self._hand_out(line, held)

    def _hand_out(self, line: _VehicleClock, held: list[_HeldItem]) -> None:
        """Release items that waited, placed on their line."""
        for stamp, host, item in held:
            time = stamp + line.offset
            self._observe(time, host)
            self.released.append(TimedItem(time, item))

    def _drop(self, held: list[_HeldItem]) -> None:
        strange = held[-1].stamp / 1e6
        count = len(held)
        before, self.dropped = self.dropped, self.dropped + count
        # Two vehicles of one number would tell at every message: the first, tenth, hundredth do.
        if len(str(before)) < len(str(self.dropped)) or not before:
            self._tell(
                "outlier",
                self.now,
                f"{self.dropped} message{'s' if self.dropped > 1 else ''} with an impossible "
                f"time (the last: {strange:.3f} s) left out; if more follow, two senders share "
                "one id",
            )

    def _observe(self, time: int, host: int) -> None:
        """Take note of a stamp's delay: the lower envelope, which may rise as fast as drift."""
        delay = float(host - time)
        envelope = self._envelope
        self._stamped = True
        if envelope is None:
            self._envelope, self._envelope_host = delay, host
            self._pass(time)
            self._release_waiting()
            return
        passed = host - self._envelope_host
        if passed > 0:
            envelope += DECODING.max_clock_drift * passed
            self._envelope_host = host
        if delay > envelope + DECODING.min_host_clock_step:
            self._above.append(_HeldItem(time, host, None))
            if len(self._above) >= 4 * DECODING.confirm_count:
                envelope = float(min(each.host - each.stamp for each in self._above))
                if not _arrived_in_burst(self._above):
                    text = "the clock of this computer was set; delays restart"
                    self._tell("host-step", time, text)
                self._above.clear()
        elif self._above:
            self._above.clear()
        self._envelope = delay if delay < envelope else envelope
        self._backlog = delay - self._envelope if time >= self.now else 0.0
        if time > self.now:
            self._pass(time)
        if self._waiting and not self._above:
            self._release_waiting()

    def _risen(self, host: int) -> float:
        if not self._stamped:
            return self._envelope or 0.0
        elapsed = max(host - self._envelope_host, 0)
        return (self._envelope or 0.0) + DECODING.max_clock_drift * elapsed

    def _pass(self, time: int) -> None:
        if self.first is None:
            self.first = self.now = time
        elif time > self.now:
            self.now = time

    def _give_up_waiting(self, host: int) -> None:
        oldest = [held.host for held in self._waiting[:1]]
        oldest += [narrow[2].host for narrow in self._narrow[:1]]
        if (
            not oldest
            or host - max(min(oldest), self._heard_above()) <= DECODING.first_stamp_timeout
        ):
            return
        if self._envelope is None:
            self._begin_by_arrival()
        else:
            self._release_waiting()

    def _heard_above(self) -> int:
        return self._above[-1].host if self._above else 0

    def _begin_by_arrival(self) -> None:
        """Start without a stamp: flight time counts from the first arrival."""
        if self._narrow:
            component, _, first = self._narrow[0]
            line = self._lines[component, False] = _VehicleClock()
            line.last, line.host = first.stamp, first.host
            self._observe(first.stamp, first.host)
            return
        first = self._waiting[0]
        self._envelope, self._envelope_host = float(first.host), first.host
        self._tell("no-clock", 0, "no message carries the vehicle's time: timed by arrival")
        self._release_waiting()

    def _release_waiting(self) -> None:
        waiting, self._waiting = self._waiting, []
        narrow, self._narrow = self._narrow, []
        # Those that came before the first stamp are placed by the first delay known; those that
        # came when the host's clock was set, by the first one after it.
        for _, host, item in waiting:
            time = host - round(self._envelope or 0.0)
            self._pass(time)
            self.released.append(TimedItem(time, item))
        for component, period, (stamp, host, item) in narrow:
            placed = self.assign_time(component, stamp, host, item, period=period)
            if placed is not None:
                self.released.append(TimedItem(placed, item))

    def _tell(self, kind: str, time: int, text: str) -> None:
        self.events.append(ClockEvent(kind=kind, time=time, text=text))


def _are_consistent_stamps(before: _HeldItem, after: _HeldItem) -> bool:
    passed = max(after.host - before.host, 0)
    return (
        -DECODING.max_stamp_delay <= after.stamp - before.stamp <= DECODING.max_stamp_lead + passed
    )


def _arrived_in_burst(held: list[_HeldItem]) -> bool:
    return 2 * (held[-1].host - held[0].host) < held[-1].stamp - held[0].stamp


def _is_reordered(line: _VehicleClock, held: _HeldItem) -> bool:
    return line.last is not None and 0 <= line.last - held.stamp <= DECODING.max_stamp_delay


def _continues_held_stamps(line: _VehicleClock, stamp: int, host: int) -> bool:
    """Return whether a stamp goes on from those held, not from the newest of the line.

    So it does after a small step back, when the clock comes again to where it was.
    """
    if len(line.held) < DECODING.confirm_count or line.last is None or stamp < line.last:
        return False
    first, newest = line.held[0], line.held[-1]
    behind = line.last + host - line.host - stamp
    return (
        behind > 2 * abs(stamp - newest.stamp - (host - newest.host))
        and 2 * (host - first.host) >= stamp - first.stamp
    )
