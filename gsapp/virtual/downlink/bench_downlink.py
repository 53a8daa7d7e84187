"""The virtual aircraft on the ground: what its box sends, and the words that its crew obeys."""

from __future__ import annotations

import math
import queue
import threading
from collections.abc import Callable, Iterator, Mapping
from typing import IO, Protocol, get_args

from calibration.inertial.accelerometers import Position
from gsapp.foundation import FlightError, LinkError
from gsapp.telemetry.clock import Clock
from gsapp.telemetry.link_registry import parse_link
from gsapp.telemetry.sources import LinkSource, open_source
from gsapp.virtual.bench import POTENTIOMETERS, VirtualBench
from gsapp.virtual.downlink.frame_scheduler import FrameScheduler
from gsapp.virtual.downlink.onboard_messages import (
    TICK_RATE,
    Message,
    OnboardSample,
    telemetry_layout,
)
from gsapp.virtual.downlink.packet import Packet

_POSITIONS: tuple[Position, ...] = get_args(Position)

BENCH_HELP = f"""\
SURFACE DEG [hold]    set it to this angle: {", ".join(POTENTIOMETERS)}
release               let go of what is held
lie POSITION          lay the aircraft: {", ".join(_POSITIONS)}
turn p|q|r DEG [S]    turn it on the turntable, in S seconds
pitot covered|open|blow
where SURFACE         say where it really is
help"""
"""The lines that are obeyed."""


def execute_bench_command(bench: VirtualBench, line: str) -> str:
    """Do what a line says, and return what is answered.

    Parameters
    ----------
    bench : VirtualBench
    line : str
        One of `BENCH_HELP`.

    Raises
    ------
    FlightError
        If it is none of them; says what to write instead.
    """
    words = line.replace("deg", " ").split()
    if not words:
        return ""
    verb, rest = words[0], words[1:]
    if verb in POTENTIOMETERS and len(rest) == 1 + ("hold" in rest[1:]):
        angle = _number(rest[0], line)
        seconds_needed = bench.set_angle(verb, angle, hold="hold" in rest)
        return f"{verb} goes to {angle:g} deg in {seconds_needed:.1f} s"
    if verb == "turn" and len(rest) in (2, 3):
        angle, *seconds = (_number(word, line) for word in rest[1:])
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
    raise FlightError(f"'{line.strip()}' is unknown; write for example {_EXAMPLES}")


_EXAMPLES = "'elevator_left 10', 'turn r 360', 'lie z_down', 'pitot covered', or 'help'"


def _number(word: str, line: str) -> float:
    try:
        value = float(word)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise FlightError(f"'{word}' in '{line.strip()}' is not a number; write {_EXAMPLES}")
    return value


class CommandConsole(Protocol):
    """Where lines to obey come from, and where answers go."""

    @property
    def ended(self) -> bool:
        """Whether nobody can say anything any more, and the bench is to end with that."""
        ...

    def read_lines(self) -> list[str]:
        """Return the lines that have come; never waits."""
        ...

    def reply(self, text: str) -> None:
        """Send an answer."""
        ...

    def close(self) -> None:
        """Hear no more."""
        ...


class UdpConsole:
    """Lines over UDP: each datagram holds one or more.

    Parameters
    ----------
    link : str
        ``udpin:HOST:PORT``.
    clock : Clock

    Raises
    ------
    LinkError
        If it is another link, or the port is taken.
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
        """Return the lines that have come."""
        chunks = self._source.read(0.0)
        return [
            line for chunk in chunks for line in chunk.data.decode("utf-8", "replace").splitlines()
        ]

    def reply(self, text: str) -> None:
        """Send an answer to all who have spoken lately."""
        self._source.write(text.encode() + b"\n")

    def close(self) -> None:
        """Close the port."""
        self._source.close()


class StdinConsole:
    """Lines that are typed, or written by the program that started this one.

    To be made after NumPy and SciPy were imported: on Windows their libraries look at the
    standard input when they are loaded, which waits there until who reads from a pipe has a line.

    Parameters
    ----------
    stream : text file
        Read until its end, which ends the bench.
    reply : callable
        Shows an answer.
    """

    def __init__(self, stream: IO[str], answer: Callable[[str], None]) -> None:
        self._answer = answer
        self._heard: queue.SimpleQueue[str | None] = queue.SimpleQueue()
        self._ended = False
        # A thread, for no system lets all kinds of input be asked without waiting.
        threading.Thread(target=self._read, args=(stream,), daemon=True).start()

    @property
    def ended(self) -> bool:
        """Return whether the input has ended."""
        return self._ended

    def read_lines(self) -> list[str]:
        """Return the lines that have come."""
        found = []
        while not self._heard.empty():
            line = self._heard.get()
            if line is None:
                self._ended = True
            else:
                found.append(line)
        return found

    def reply(self, text: str) -> None:
        """Show an answer."""
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
    """Packs the volts of a bench for a link, and obeys between the ticks.

    Parameters
    ----------
    bench : VirtualBench
    control : CommandConsole or None
        Where lines to obey come from.
    thin : bool
        For a 57,600-baud radio.
    unix_us : int
        Time of day at which the box is switched on, microseconds since 1970.
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
        """Return whether the box was switched off."""
        return self._stopped or (self._control is not None and self._control.ended)

    def stop(self) -> None:
        """Switch the box off."""
        self._stopped = True

    def pack_reply(self, message: Message) -> bytes:
        """Return the frame of an answer to the ground."""
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
