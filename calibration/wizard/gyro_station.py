"""Rate gyros: a still period for all of them, then a turn there and back about each axis."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import datetime

from calibration.inertial import (
    ACCELEROMETERS,
    GyroZero,
    Turn,
    TurnWatch,
    gyro_certificate,
    gyro_zero,
    still_watch,
)
from calibration.plan import InstrumentPlan
from calibration.points import CalibrationError
from calibration.pressures import GroundAir
from calibration.rest import BLOCK
from calibration.wizard.json_forms import content_of
from calibration.wizard.other_work import AskedTurn, GyroWork
from calibration.wizard.slices import Slice
from calibration.wizard.state import Group, Work
from calibration.wizard.station import Answer, Draft, Header, Outcome, Reference, Showing, Station
from calibration.wizard.unrest import Unrest
from calibration.wizard.view import Action, Phase

_STILL = 5.0
"""Seconds of rest for the zeros."""
_SILENT = "The {} gyro did not answer to a turn; check its wires."
_MOST_OF = 0.6
"""Share of the angle asked for that makes a turn; laying the aircraft on the table makes none."""


class GyroStation(Station):
    """Looks after the gyros.

    Parameters
    ----------
    group : Group
        Of all gyros.
    header : Header
        Of the calibration.
    reference : Reference
        Holds the factory's figures.
    """

    def __init__(self, group: Group, header: Header, reference: Reference) -> None:
        self._group = group
        self._header = header
        self._factory = reference.factory
        # Accelerometers tell a slow steady turn from rest, where they are recorded.
        beside = [name for name in ACCELEROMETERS if name in header.plan.channels]
        self._beside = tuple(beside) if len(beside) == len(ACCELEROMETERS) else ()
        self._still = still_watch(
            (*group.channels, *self._beside), seconds=_STILL, factory=self._factory
        )
        self._unrest = Unrest()
        least = [_MOST_OF * one.turn for one in group.instruments if one.turn is not None]
        self._turn = TurnWatch(
            group.channels, least=min(least, default=180.0), factory=self._factory
        )

    def restart(self) -> None:
        """Begin to watch anew: a step was made."""
        self._still.restart()
        self._unrest.restart()
        self._turn.restart()

    def feed(self, one: Slice) -> None:
        """Take the samples of a tenth of a second."""
        self._still.feed(one.times, one.volts)
        self._unrest.feed(self._still.reading)
        self._turn.feed(one.times, one.volts)

    def phase(self, work: Work) -> Phase:
        """Return which page it is."""
        gyro = _gyro(work)
        if gyro.rest is None:
            return "gyro_still"
        return "gyro_turn" if gyro.open_turns else "fit"

    def by_itself(self, work: Work) -> Draft | Answer | None:
        """Return the rest or the turn that was seen."""
        gyro = _gyro(work)
        phase = self.phase(gyro)
        if phase == "gyro_still":
            reading = self._still.reading
            if reading.state != "rested" or reading.rest is None:
                return None
            rest = content_of(reading.rest)
            return Draft(kind="still", data={"rest": rest}, message="zeros of the gyros taken")
        if phase == "gyro_turn" and self._turn.reading.state == "turned":
            return self._turned(gyro)
        return None

    def can(self, work: Work) -> frozenset[str]:
        """Return the kinds of actions that it answers to now."""
        gyro = _gyro(work)
        kinds = {"next", "take"} if self.phase(gyro) == "gyro_turn" else set()
        return frozenset(kinds | {"repeat", "delete"} if gyro.turns else kinds)

    def act(self, work: Work, action: Action) -> Draft | Answer:
        """Return what an action leads to."""
        gyro = _gyro(work)
        if action.kind == "next":
            return Draft(
                kind="leave_out",
                data={"slot": gyro.open_turns[0]},
                message="without this turn; the factory's scale counts where none was made",
                tone="",
            )
        if action.kind == "take":
            return self._without_answer(gyro)
        at = len(gyro.turns) - 1 if action.index is None else action.index
        if not 0 <= at < len(gyro.turns):
            return Answer(message=f"there is no turn {at + 1}", tone="error")
        message = "the turn once more" if action.kind == "repeat" else "the turn is deleted"
        return Draft(kind=action.kind, data={"index": at}, message=message, tone="")

    def show(self, work: Work, outcome: Outcome) -> Showing:
        """Return what is to be shown."""
        gyro = _gyro(work)
        phase = self.phase(gyro)
        if phase == "gyro_still":
            reading = self._still.reading
            return Showing(
                instrument=self._group.instruments[0],
                prompt="Leave the aircraft alone until the zeros of the gyros are taken.",
                spoken="Gyros. Hands off",
                amount=round(reading.progress * _STILL / BLOCK) * BLOCK,
                amount_goal=_STILL,
                amount_unit="s",
                warnings=self._unrest.warnings,
            )
        points = tuple(turn.point for _, turn in gyro.turns)
        if phase == "gyro_turn":
            asked = gyro.asked[gyro.open_turns[0]]
            turning = self._turn.reading
            return Showing(
                instrument=self._instrument(asked.channel),
                prompt=self._turn_prompt(asked),
                spoken=self._turn_spoken(asked),
                target=asked.angle,
                amount=turning.angle,
                amount_goal=abs(asked.angle),
                amount_unit="deg",
                points=points,
            )
        good = not outcome.doubts
        return Showing(
            instrument=self._group.instruments[0],
            prompt=(
                "The gyros are good: accept them."
                if good
                else "Look at the gyros, then accept what can be used."
            ),
            spoken="Gyros good" if good else "Look at the gyros",
            points=points,
        )

    def outcome(self, work: Work, stamp: datetime, air: GroundAir | None) -> Outcome:
        """Return the certificates of the gyros that can be used."""
        gyro = _gyro(work)
        if gyro.rest is None:
            return Outcome()
        certificates, doubts, remarks = [], [], []
        uncalibrated: dict[str, str] = {}
        for channel in self._group.channels:
            if channel in gyro.silent:
                uncalibrated[channel] = _SILENT.format(channel)
                doubts.append(uncalibrated[channel])
                continue
            zero = gyro_zero(channel, gyro.rest, factory=self._factory)
            turns = [turn for _, turn in gyro.turns if turn.channel == channel]
            try:
                certificate = gyro_certificate(
                    zero,
                    turns,
                    who=self._header.who,
                    stamp=stamp,
                    temperature=air.temperature if air is not None else self._header.temperature,
                    factory=self._factory,
                )
            except CalibrationError as error:
                uncalibrated[channel] = str(error)
                doubts.append(str(error))
                continue
            certificates.append(certificate)
            doubts += _doubts(zero, turns)
            remarks += [zero.verdict.sentence, *_passed(turns)]
        return Outcome(
            certificates=tuple(certificates),
            uncalibrated=uncalibrated,
            doubts=tuple(doubts),
            remarks=tuple(remarks),
            ready=True,
        )

    def _turned(self, gyro: GyroWork) -> Draft | Answer:
        slot = gyro.open_turns[0]
        asked = gyro.asked[slot]
        try:
            turn = self._turn.turn(asked.channel, asked.angle)
        except CalibrationError as error:
            self._turn.restart()
            return Answer(message=str(error), tone="error")
        kind = turn.verdict.kind
        if kind == "clipped":
            self._turn.restart()
            return Answer(message=turn.verdict.sentence, tone="error")
        return Draft(
            kind="turn",
            data={"slot": slot, "turn": content_of(turn)},
            message=turn.verdict.sentence,
            tone="taken" if turn.verdict.usable else "error",
        )

    def _without_answer(self, gyro: GyroWork) -> Draft | Answer:
        """Take the crew's word that the table was turned, though no gyro saw it."""
        if self._turn.reading.state in ("turning", "stopping"):
            return Answer(message="a turn is seen: let the table stand, it is taken by itself")
        channel = gyro.asked[gyro.open_turns[0]].channel
        return Draft(
            kind="silent", data={"gyro": channel}, message=_SILENT.format(channel), tone="error"
        )

    def _instrument(self, channel: str) -> InstrumentPlan:
        return next(one for one in self._group.instruments if one.channel == channel)

    def _turn_prompt(self, asked: AskedTurn) -> str:
        instrument = self._instrument(asked.channel)
        way = instrument.positive if asked.angle > 0.0 else instrument.negative
        state = self._turn.reading.state
        angle = f"{abs(asked.angle):g} deg"
        if state == "unsettled":
            return f"{_UPRIGHT[asked.channel]} Let the table stand still."
        if state == "ready":
            return f"Turn the table {angle}, {way}, within its marks, then let it stand."
        return f"Turn on to {angle}, {way}, then let it stand."

    def _turn_spoken(self, asked: AskedTurn) -> str:
        instrument = self._instrument(asked.channel)
        way = instrument.positive if asked.angle > 0.0 else instrument.negative
        if self._turn.reading.state == "unsettled":
            return f"{instrument.title} on the table"
        return f"Turn {abs(asked.angle):g}, {way}"


_UPRIGHT: Mapping[str, str] = {
    "p": "Put the aircraft on the turntable, nose straight down or up.",
    "q": "Put the aircraft on the turntable, one wing straight up.",
    "r": "Put the aircraft on the turntable, upright.",
}


def _gyro(work: Work) -> GyroWork:
    assert isinstance(work, GyroWork)  # noqa: S101 - the state pairs stations with their work
    return work


def _doubts(zero: GyroZero, turns: list[Turn]) -> list[str]:
    verdicts = [zero.verdict, *(turn.verdict for turn in turns)]
    return [verdict.sentence for verdict in verdicts if not verdict.passed]


def _passed(turns: list[Turn]) -> list[str]:
    return [turn.verdict.sentence for turn in turns if turn.verdict.passed]
