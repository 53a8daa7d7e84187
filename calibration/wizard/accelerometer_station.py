"""Accelerometers: the aircraft laid in six positions, each taken once it lies still."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import datetime

from calibration.inertial import (
    ACCELEROMETERS,
    POSITION_WORDS,
    Position,
    recognize_position,
    six_positions,
    specific_force,
    still_watch,
)
from calibration.plan import InstrumentPlan
from calibration.points import CalibrationError
from calibration.pressures import GroundAir
from calibration.rest import BLOCK, Rest
from calibration.wizard.json_forms import content_of
from calibration.wizard.other_work import AccelerometerWork
from calibration.wizard.slices import Slice
from calibration.wizard.state import Group, Work
from calibration.wizard.station import Answer, Draft, Header, Outcome, Reference, Showing, Station
from calibration.wizard.unrest import Unrest
from calibration.wizard.view import Action, Phase

_STILL = 3.0
"""Seconds of rest in each position."""


class AccelerometerStation(Station):
    """Looks after the accelerometers.

    A position is known by the volts, so that the six may be taken in any order.

    Parameters
    ----------
    group : Group
        Of the three.
    header : Header
        Of the calibration.
    reference : Reference
        Holds the factory's figures.
    """

    def __init__(self, group: Group, header: Header, reference: Reference) -> None:
        self._group = group
        self._header = header
        self._factory = reference.factory
        self._still = still_watch(group.channels, seconds=_STILL, factory=self._factory)
        self._unrest = Unrest()

    def restart(self) -> None:
        """Begin to watch anew: a step was made."""
        self._still.restart()
        self._unrest.restart()

    def feed(self, one: Slice) -> None:
        """Take the samples of a tenth of a second."""
        self._still.feed(one.times, one.volts)
        self._unrest.feed(self._still.reading)

    def phase(self, work: Work) -> Phase:
        """Return which page it is."""
        return "accel_position" if _lain(work).open_positions else "fit"

    def by_itself(self, work: Work) -> Draft | Answer | None:
        """Return the position that the aircraft lies in, if it was not taken yet."""
        lain = _lain(work)
        rest = self._rested
        if rest is None or not self._header.auto:
            return None
        position = recognize_position(rest.volts, factory=self._factory)
        if position is None or position not in lain.open_positions:
            return None
        return _draft(position, rest)

    def can(self, work: Work) -> frozenset[str]:
        """Return the kinds of actions that it answers to now."""
        lain = _lain(work)
        kinds = {"take"} if lain.open_positions else set()
        return frozenset(kinds | {"repeat"} if lain.readings else kinds)

    def act(self, work: Work, action: Action) -> Draft | Answer:
        """Return what an action leads to."""
        lain = _lain(work)
        if action.kind == "take":
            if self._rested is None:
                return Answer(message="it does not lie still yet", tone="error")
            return _draft(lain.open_positions[0], self._rested)
        at = len(lain.readings) - 1 if action.index is None else action.index
        if not 0 <= at < len(lain.readings):
            return Answer(message=f"there is no position {at + 1}", tone="error")
        again = POSITION_WORDS[lain.readings[at].position]
        return Draft(kind="repeat", data={"index": at}, message=f"{again}: once more", tone="")

    def show(self, work: Work, outcome: Outcome) -> Showing:
        """Return what is to be shown."""
        lain = _lain(work)
        reading = self._still.reading
        if not lain.open_positions:
            good = not outcome.doubts
            return Showing(
                instrument=self._group.instruments[0],
                prompt=(
                    "The accelerometers are good: accept them."
                    if good
                    else "Look at the accelerometers, then repeat a position or accept them."
                ),
                spoken="Accelerometers good" if good else "Look at the accelerometers",
            )
        position = lain.open_positions[0]
        return Showing(
            instrument=self._concerned(position),
            prompt=f"Lay the aircraft {POSITION_WORDS[position]}, and let it lie still.",
            spoken=POSITION_WORDS[position].capitalize(),
            amount=round(reading.progress * _STILL / BLOCK) * BLOCK,
            amount_goal=_STILL,
            amount_unit="s",
            position=position,
            warnings=self._warnings(lain),
        )

    def outcome(self, work: Work, stamp: datetime, air: GroundAir | None) -> Outcome:
        """Return the certificates of the accelerometers that can be used."""
        lain = _lain(work)
        if lain.open_positions:
            return Outcome()
        try:
            found = six_positions(lain.readings, factory=self._factory)
        except CalibrationError as error:
            return Outcome(doubts=(str(error),))
        temperature = air.temperature if air is not None else self._header.temperature
        certificates = []
        doubts = [found.doubt] if found.doubt else []
        uncalibrated: dict[str, str] = {}
        remarks: list[str] = []
        for channel in self._group.channels:
            verdict = found.fits[channel].verdict
            (remarks if verdict.passed else doubts).append(verdict.sentence)
            if not verdict.usable:
                uncalibrated[channel] = verdict.sentence
                continue
            certificates.append(
                found.certificate(
                    channel, who=self._header.who, stamp=stamp, temperature=temperature
                )
            )
        return Outcome(
            certificates=tuple(certificates),
            uncalibrated=uncalibrated,
            doubts=tuple(doubts),
            remarks=tuple(remarks),
            ready=True,
        )

    @property
    def _rested(self) -> Rest | None:
        reading = self._still.reading
        return reading.rest if reading.state == "rested" else None

    def _concerned(self, position: Position) -> InstrumentPlan:
        """Return the accelerometer along the axis that is upright."""
        force: Mapping[str, float] = specific_force(position)
        axis = max(ACCELEROMETERS, key=lambda name: abs(force[name]))
        return next(one for one in self._group.instruments if one.channel == axis)

    def _warnings(self, lain: AccelerometerWork) -> tuple[str, ...]:
        if self._rested is not None:
            found = recognize_position(self._rested.volts, factory=self._factory)
            if found is None:
                return (
                    "the volts are not those of any position; if it lies as asked, take it: an "
                    "accelerometer is at fault then",
                )
            if found not in lain.open_positions:
                return (f"{POSITION_WORDS[found]} was taken already",)
        return self._unrest.warnings


def _draft(position: Position, rest: Rest) -> Draft:
    return Draft(
        kind="position",
        data={"position": position, "rest": content_of(rest)},
        message=f"taken: {POSITION_WORDS[position]}",
    )


def _lain(work: Work) -> AccelerometerWork:
    assert isinstance(work, AccelerometerWork)  # noqa: S101 - paired with its work by the state
    return work
