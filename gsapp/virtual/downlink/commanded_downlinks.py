"""The bench and the training flight over a link: what their box sends, and the words they obey."""

from __future__ import annotations

import math
import queue
import threading
from collections.abc import Callable, Iterator, Mapping
from typing import IO, Final, Protocol, get_args

from calibration.inertial.accelerometers import Position
from gsapp.foundation import FlightError, LinkError
from gsapp.quantities import Block
from gsapp.telemetry.clock import Clock
from gsapp.telemetry.link_registry import parse_link
from gsapp.telemetry.sources import LinkSource, open_source
from gsapp.virtual.bench import POTENTIOMETERS, VirtualBench
from gsapp.virtual.downlink.flight_downlink import FlightDownlink
from gsapp.virtual.downlink.onboard_messages import (
    TICK_RATE,
    FrameScheduler,
    Message,
    OnboardSample,
    Packet,
    telemetry_layout,
)
from gsapp.virtual.keyboard_pilot import KeyboardPilot
from gsapp.virtual.sticks import KeyPositions

_POSITIONS: tuple[Position, ...] = get_args(Position)

BENCH_HELP = f"""\
SURFACE DEG [hold]    set it to this angle: {", ".join(POTENTIOMETERS)}
release               release what is held
lie POSITION          lay the aircraft: {", ".join(_POSITIONS)}
turn p|q|r DEG [S]    turn it on the turntable, in S seconds
pitot covered|open|blow
where SURFACE         say where it really is
help"""
"""The lines that are obeyed."""


def execute_bench_command(bench: VirtualBench, line: str) -> str:
    """Do what one of the lines of `BENCH_HELP` says, and return what is answered.

    Raise FlightError if it is none of them; says what to write instead.
    """
    words = line.replace("deg", " ").split()
    if not words:
        return ""
    verb, rest = words[0], words[1:]
    if verb in POTENTIOMETERS and len(rest) == 1 + ("hold" in rest[1:]):
        angle = _number(rest[0], line, _BENCH_EXAMPLES)
        seconds_needed = bench.set_angle(verb, angle, hold="hold" in rest)
        return f"{verb} goes to {angle:g} deg in {seconds_needed:.1f} s"
    if verb == "turn" and len(rest) in (2, 3):
        angle, *seconds = (_number(word, line, _BENCH_EXAMPLES) for word in rest[1:])
        whole = bench.rotate(rest[0], angle, seconds=seconds[0] if seconds else None)
        return f"turns {angle:g} deg about the axis of {rest[0]}, over in {whole:.1f} s"
    if verb == "lie" and len(rest) == 1 and rest[0] in _POSITIONS:
        return f"lies {rest[0]} in {bench.move_to_position(rest[0]):.1f} s"
    if verb == "where" and len(rest) == 1:
        return f"{rest[0]} is at {bench.angle(rest[0]):.3f} deg"
    plain: Mapping[str, Callable[[], object]] = {
        "release": bench.release,
        "pitot covered": bench.cover,
        "pitot open": bench.uncover,
        "pitot blow": bench.blow,
    }
    if " ".join(words) in plain:
        plain[" ".join(words)]()
        return " ".join(words)
    if words == ["help"]:
        return BENCH_HELP
    raise FlightError(f"'{line.strip()}' is unknown; write for example {_BENCH_EXAMPLES}")


_BENCH_EXAMPLES: Final = (
    "'elevator_left 10', 'turn r 360', 'lie z_down', 'pitot covered', or 'help'"
)


def _number(word: str, line: str, examples: str) -> float:
    try:
        value = float(word)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise FlightError(f"'{word}' in '{line.strip()}' is not a number; write {examples}")
    return value


class CommandConsole(Protocol):
    """Where lines to obey come from, and where answers go."""

    @property
    def ended(self) -> bool:
        """Whether nobody can say anything any more, and the bench is to end with that."""

    def read_lines(self) -> list[str]:
        """Return the lines that have come; never waits."""

    def reply(self, text: str) -> None:
        """Send an answer."""

    def close(self) -> None:
        """Hear no more."""


class UdpConsole:
    """Lines over UDP: each datagram holds one or more.

    Raise LinkError if the link is not ``udpin:HOST:PORT``, or the port is taken.
    """

    ended = False

    def __init__(self, link: str, *, clock: Clock) -> None:
        address = parse_link(link)
        if address.kind != "udpin":
            raise LinkError(
                f"the bench cannot be controlled over '{link}'; give udpin:HOST:PORT, or - for "
                "standard input"
            )
        self._source: LinkSource = open_source(address, clock=clock)
        self._source.open()

    def read_lines(self) -> list[str]:
        chunks = self._source.read(0.0)
        return [
            line for chunk in chunks for line in chunk.data.decode("utf-8", "replace").splitlines()
        ]

    def reply(self, text: str) -> None:
        """Send an answer to all who have spoken lately."""
        self._source.write(text.encode() + b"\n")

    def close(self) -> None:
        self._source.close()


class StdinConsole:
    """Lines that are typed, or written by the program that started this one, which end the bench.

    To be made after NumPy and SciPy were imported: on Windows their libraries look at the
    standard input when they are loaded, which waits there until who reads from a pipe has a line.
    """

    def __init__(self, stream: IO[str], answer: Callable[[str], None]) -> None:
        self._answer = answer
        self._heard: queue.SimpleQueue[str | None] = queue.SimpleQueue()
        self._ended = False
        # A thread, for no system lets all kinds of input be asked without waiting.
        threading.Thread(target=self._read, args=(stream,), daemon=True).start()

    @property
    def ended(self) -> bool:
        return self._ended

    def read_lines(self) -> list[str]:
        found = []
        while not self._heard.empty():
            line = self._heard.get()
            if line is None:
                self._ended = True
            else:
                found.append(line)
        return found

    def reply(self, text: str) -> None:
        self._answer(text)

    def close(self) -> None:
        """Let the reader be; it ends with the program."""

    def _read(self, stream: IO[str]) -> None:
        try:
            for line in stream:
                self._heard.put(line)
        except (OSError, ValueError):
            pass  # closed from the other side
        self._heard.put(None)


class BenchDownlink:
    """Packs the volts of a bench for a link, and obeys lines of a console between the ticks.

    `thin` is for a 57,600-baud radio; `unix_us` the time of day at which the box is switched on,
    microseconds since 1970.
    """

    def __init__(
        self, bench: VirtualBench, control: CommandConsole | None, *, thin: bool, unix_us: int
    ) -> None:
        self._bench = bench
        self._control = control
        self._unix_us = unix_us
        self._box = FrameScheduler(
            telemetry_layout(thin=thin, attitude_sent=False, position_sent=False)
        )
        self._doing = "on the ground"
        self._stopped = False

    @property
    def finished(self) -> bool:
        return self._stopped or (self._control is not None and self._control.ended)

    def stop(self) -> None:
        self._stopped = True

    def pack_reply(self, message: Message) -> bytes:
        return self._box.pack(message)

    def advance(self, ticks: int) -> Iterator[Packet]:
        """Obey what was said, go on, and yield one packet for each tick."""
        self._obey()
        first = self._bench.ticks
        volts = self._bench.advance(ticks)
        values = self._values()
        for index, row in enumerate(volts):
            number = first + index
            tick = OnboardSample(
                number=number,
                volts=row.tolist(),
                values=values,
                unix_us=self._unix_us + number * (1_000_000 // TICK_RATE),
            )
            live = self._box.frames(tick)
            if number == 0:
                live.append(self._box.pack_text("Telemetry on, on the ground"))
            yield Packet(
                time=tick.micros * 1e-6,
                stamp_us=tick.unix_us,
                live_frames=tuple(live),
                onboard_frames=(),
                phase=self._doing,
            )

    def _obey(self) -> None:
        if self._control is None:
            return
        for line in self._control.read_lines():
            try:
                answer = execute_bench_command(self._bench, line)
            except FlightError as error:
                self._control.reply(str(error))
                continue
            if answer:
                self._control.reply(answer)
                self._doing = line.strip()

    def _values(self) -> dict[str, float]:
        """Return what the board knows besides; nothing turns and nothing is steered."""
        weather = self._bench.weather
        return {
            **dict.fromkeys(_ZERO_CHANNELS, 0.0),
            "rc_rssi": 1.0,
            "static_pressure": weather.pressure,
            "temperature": weather.temperature,
            "cpu_load": 0.31,
            "battery": 8.1,
            "battery_current": 0.6,
            "battery_remaining": 0.98,
        }


_ZERO_CHANNELS = (
    "psi", "servo_aileron", "servo_elevator", "servo_rudder", "servo_flap", "throttle_command",
    "stick_roll", "stick_pitch", "stick_yaw", "rate_switch", "rpm_left", "rpm_right",
    "dynamic_pressure", "Vc", "ground_speed", "throttle", "altitude", "climb_rate", "armed",
)  # fmt: skip


TRAINING_HELP: Final = """\
take                              you have it: the keys move the sticks
give                              I have it: the built-in pilot flies on
sticks PITCH ROLL YAW [THROTTLE]  where the keys push, -1 to 1: pulled, right, right; throttle 0
                                  to 1. Say it at least every 2 s, or the built-in pilot takes over
size SHARE                        how far a key pushes, as a share of full stick
rate low|high                     the rate switch
click pitch|roll|yaw|throttle BY  move a trim lever or the throttle by a share of its travel
land                              the built-in pilot lands, and the flight is over
help"""
"""The lines that are obeyed."""

_TRAINING_EXAMPLES: Final = (
    "for example 'take', 'sticks 0 -1 0', 'size 0.5', 'click throttle 0.05', or 'help'"
)


def execute_training_command(pilot: KeyboardPilot, line: str) -> str:
    """Do what one of the lines of `TRAINING_HELP` says; return the answer, empty for sticks.

    Raise FlightError if it is none of them, or cannot be done; says what to do instead.
    """
    verb, *rest = line.split() or [""]
    if verb == "sticks" and len(rest) in (3, 4):
        pitch, roll, yaw, *throttle = (_number(word, line, _TRAINING_EXAMPLES) for word in rest)
        pilot.set_keys(
            KeyPositions(
                pitch=pitch, roll=roll, yaw=yaw, throttle=throttle[0] if throttle else None
            )
        )
        return ""
    if verb == "click" and len(rest) == 2:
        pilot.step_lever(rest[0], _number(rest[1], line, _TRAINING_EXAMPLES))
        return ""
    if verb == "size" and len(rest) == 1:
        share = _number(rest[0], line, _TRAINING_EXAMPLES)
        pilot.set_key_travel(share)
        return f"a key gives {100.0 * share:.0f} % of full stick"
    if verb == "rate" and rest in (["low"], ["high"]):
        pilot.set_rate_switch(high=rest == ["high"])
        return f"{rest[0]} rate"
    if verb == "take" and not rest:
        if not pilot.take_over():
            raise FlightError("not in the pattern; take control after the climb")
        return "you have control"
    plain: Mapping[str, tuple[Callable[[], None], str]] = {
        "": (lambda: None, ""),
        "give": (pilot.hand_back, "I have control"),
        "land": (pilot.land, "I have it: landing"),
        "help": (lambda: None, TRAINING_HELP),
    }
    if not rest and verb in plain:
        act, answer = plain[verb]
        act()
        return answer
    raise FlightError(f"'{line.strip()}' is unknown; write {_TRAINING_EXAMPLES}")


class TrainingDownlink:
    """Packs the training flight of a pilot for a link, and obeys between the ticks.

    When the lines of its console end, the flight does.
    """

    def __init__(
        self, downlink: FlightDownlink, pilot: KeyboardPilot, control: CommandConsole
    ) -> None:
        self._downlink = downlink
        self._pilot = pilot
        self._control = control

    @property
    def finished(self) -> bool:
        """Return whether the flight is over, or nobody can say anything any more."""
        return self._control.ended or self._downlink.finished

    def pack_reply(self, message: Message) -> bytes:
        return self._downlink.pack_reply(message)

    def truth(self) -> Block:
        return self._downlink.truth()

    def advance(self, ticks: int) -> Iterator[Packet]:
        """Obey what was said, fly on, and yield one packet for each tick."""
        for line in self._control.read_lines():
            try:
                answer = execute_training_command(self._pilot, line)
            except FlightError as error:
                answer = str(error)
            if answer:
                self._control.reply(answer)
        yield from self._downlink.advance(ticks)
        if reason := self._pilot.take_handback_reason():
            self._control.reply(f"I have control: {reason}")
