"""A training flight over a link: the words that move its sticks."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from typing import Final

from gsapp.foundation import FlightError
from gsapp.quantities import Block
from gsapp.virtual.downlink.bench_downlink import CommandConsole
from gsapp.virtual.downlink.flight_downlink import FlightDownlink
from gsapp.virtual.downlink.onboard_messages import Message
from gsapp.virtual.downlink.packet import Packet
from gsapp.virtual.keyboard_pilot import KeyboardPilot
from gsapp.virtual.keyboard_sticks import KeyPositions

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

_EXAMPLES: Final = "'take', 'sticks 0 -1 0', 'size 0.5', 'click throttle 0.05', or 'help'"


def execute_training_command(pilot: KeyboardPilot, line: str) -> str:
    """Do what a line says, and return what is answered; empty for sticks.

    Parameters
    ----------
    pilot : KeyboardPilot
    line : str
        One of `TRAINING_HELP`.

    Raises
    ------
    FlightError
        If it is none of them, or cannot be done; says what to do instead.
    """
    verb, *rest = line.split() or [""]
    if verb == "sticks" and len(rest) in (3, 4):
        pitch, roll, yaw, *throttle = (_number(word, line) for word in rest)
        pilot.set_keys(
            KeyPositions(
                pitch=pitch, roll=roll, yaw=yaw, throttle=throttle[0] if throttle else None
            )
        )
        return ""
    if verb == "click" and len(rest) == 2:
        pilot.step_lever(rest[0], _number(rest[1], line))
        return ""
    if verb == "size" and len(rest) == 1:
        share = _number(rest[0], line)
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
    raise FlightError(f"'{line.strip()}' is unknown; write for example {_EXAMPLES}")


def _number(word: str, line: str) -> float:
    try:
        value = float(word)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise FlightError(
            f"'{word}' in '{line.strip()}' is not a number; write for example {_EXAMPLES}"
        )
    return value


class TrainingDownlink:
    """Packs a training flight for a link, and obeys between the ticks.

    Parameters
    ----------
    downlink : FlightDownlink
        Of the flight that `pilot` flies.
    pilot : KeyboardPilot
    control : CommandConsole
        Where lines to obey come from; when it ends, the flight does.
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
