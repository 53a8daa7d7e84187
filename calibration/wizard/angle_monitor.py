"""Watching one instrument that is set by hand: when a sign is proven, when a point may be taken."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from calibration.certificate import Certificate
from calibration.plan import InstrumentPlan
from calibration.points import Direction
from calibration.voltage_monitor import VoltageMonitor, VoltageReading
from calibration.wizard.angle_progress import AngleProgress, RecordedPoint
from calibration.wizard.approach_side import ApproachSide, ApproachTracker
from calibration.wizard.setting_schedule import ScheduledSetting
from calibration.wizard.settings import WIZARD
from gsapp.quantities import FloatArray, channel, from_si

PointHint = Literal[
    "", "absent", "clipped", "unmoved", "moving", "noisy", "past", "wrong_side", "elsewhere",
    "wait", "little", "against",
]  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class StepProposal:
    """What the volts allow at this moment."""

    data: dict[str, Any] | None = None
    """Of the step that may be taken now."""
    hint: PointHint = ""
    """Why none may, or what is odd about it; empty where all is well."""
    value: float | None = None
    """Where the instrument seems to stand, by the points taken so far, in its unit."""


class AngleMonitor:
    """Follows the volts of one instrument between two steps.

    Parameters
    ----------
    reference : Certificate or None
        In force, or nominal; it tells what movement to expect.
    trusted : bool
        Whether the reference also tells where the instrument stands before a point does: where
        it is only checked, it was taken on this very instrument.
    """

    def __init__(
        self,
        instrument: InstrumentPlan,
        reference: Certificate | None,
        *,
        trusted: bool = False,
    ) -> None:
        self._instrument = instrument
        self._reference = reference
        self._trusted = trusted
        self._watch = VoltageMonitor(shortest=WIZARD.min_averaging if trusted else None)
        self._arrival = ApproachTracker()

    @property
    def reading(self) -> VoltageReading:
        """Return the volts as they are."""
        return self._watch.reading

    def restart(self) -> None:
        """Demand a movement, since a step was made. From which side it came is not forgotten."""
        self._watch.restart()

    def reset(self) -> None:
        self._watch.restart()
        self._arrival.restart()

    def feed(self, times: FloatArray, volts: FloatArray, excitation: FloatArray) -> None:
        self._watch.feed(times, volts, excitation)
        present = volts[np.isfinite(volts)]
        if present.size:
            self._arrival.feed(float(present.mean()))

    def current_value(self, drawn: Certificate | None = None) -> float | None:
        """Return what the volts stand for, in the unit of the plan.

        Parameters
        ----------
        drawn : Certificate, optional
            Of the points taken now; by the reference where there is none.
        """
        certificate = drawn or self._reference
        if certificate is None or self.reading.state == "absent":
            return None
        return self._by(certificate, self.reading)

    def expected_rising(self) -> bool | None:
        """Return whether volts rise towards positive values by the reference."""
        return None if self._reference is None else sum(self._reference.end_slopes) > 0.0

    def detect_sign(self, *, confirmed: bool) -> StepProposal:
        """Return whether the movement to the positive side was seen.

        Parameters
        ----------
        confirmed : bool
            Whether the crew says that what was seen was the movement asked for.
        """
        reading = self.reading
        if reading.state in ("absent", "clipped"):
            return StepProposal(hint="absent" if reading.state == "absent" else "clipped")
        side = self._arrival.approach_side(reading.volts, WIZARD.min_sign_movement)
        if side is None:
            moved = self._side(reading) is not None
            return StepProposal(hint="little" if moved else "unmoved")
        rising = side == "below"
        if not confirmed:
            if reading.state != "steady" or reading.steady_for < WIZARD.sign_hold:
                return StepProposal(hint="moving")
            if self.expected_rising() not in (None, rising):
                return StepProposal(hint="against")
        return StepProposal(data={"rising": rising})

    def detect_point(self, work: AngleProgress, at: int, *, by_key: bool) -> StepProposal:
        """Return whether the point of a setting can be taken now.

        Parameters
        ----------
        work : AngleProgress
            What was taken so far; its sign is proven.
        at : int
            Place of the setting in `work`.
        by_key : bool
            Whether the crew says that the instrument stands at the setting.
        """
        reading = self.reading
        if reading.state == "absent":
            return StepProposal(hint="absent")
        if reading.state == "clipped":
            return StepProposal(hint="clipped")
        slot = work.slots[at]
        direction = _direction(self._side(reading), rising=bool(work.rising))
        value = self._standing(work, reading)
        if reading.state == "moving":
            return StepProposal(hint="moving", value=value)
        hint = self._doubt(slot, direction, value, reading, work)
        if hint and not by_key:
            return StepProposal(hint=hint, value=value)
        data = {
            "value": slot.value,
            "volts": reading.volts,
            "direction": direction,
            "slot": at,
            "excitation": reading.excitation,
            "std": reading.std,
            "uncertainty": reading.uncertainty,
        }
        return StepProposal(data=data, hint=hint, value=value)

    def _doubt(
        self,
        slot: ScheduledSetting,
        direction: Direction,
        value: float | None,
        reading: VoltageReading,
        work: AngleProgress,
    ) -> PointHint:
        """Return why a rest is perhaps not the one asked for."""
        if direction == "single" or not reading.moved:
            return "unmoved"
        if reading.state == "noisy":
            return "noisy"
        spacing = self._spacing(work)
        wrong_side = slot.direction not in ("single", direction)
        if (
            wrong_side
            and slot.is_turning_point
            and _beyond(slot, value, WIZARD.passed_share * spacing)
        ):
            return "past"
        if value is not None and abs(value - slot.value) > self._tolerance(work):
            return "elsewhere"
        if wrong_side:
            return "wrong_side"
        return "wait" if reading.steady_for < self._hold(slot, value, reading, work) else ""

    def _hold(
        self,
        slot: ScheduledSetting,
        value: float | None,
        reading: VoltageReading,
        work: AngleProgress,
    ) -> float:
        """Return how long a rest must last before it is taken by itself, s."""
        if self._holds(slot, reading):
            return WIZARD.confirmed_hold
        sure = value is not None or self._as_expected(slot, reading, work)
        return WIZARD.hold if sure else WIZARD.unsure_hold

    def _holds(self, slot: ScheduledSetting, reading: VoltageReading) -> bool:
        """Return whether it is where the certificate that is checked says, and known well enough.

        A hand that is still looking for its mark rests beside it; a noisy one takes longer.
        """
        certificate = self._reference
        if not self._trusted or certificate is None:
            return False
        volts = np.array([reading.volts, reading.volts + reading.uncertainty])
        supply = None if reading.excitation is None else np.array([reading.excitation])
        here, beside = self._in_unit(certificate.evaluate(volts, supply)).tolist()
        bound = float(self._in_unit(certificate.uncertainty(volts[:1], supply))[0])
        return bool(
            abs(here - slot.value) <= bound and abs(beside - here) <= WIZARD.known_share * bound
        )

    def _side(self, reading: VoltageReading) -> ApproachSide | None:
        apart = max(WIZARD.min_volts_apart, WIZARD.min_stds_apart * reading.std)
        return self._arrival.approach_side(reading.volts, apart)

    def _spacing(self, work: AngleProgress) -> float:
        return float(np.diff(np.unique([slot.value for slot in work.slots])).min())

    def _tolerance(self, work: AngleProgress) -> float:
        settings = {taken.value for taken in work.points}
        sure = len(settings) > 1 or (self._trusted and not settings)
        return (WIZARD.near_share if sure else WIZARD.near_share_one) * self._spacing(work)

    def _standing(self, work: AngleProgress, reading: VoltageReading) -> float | None:
        """Return where the instrument stands by the points taken; None before they can tell."""
        # The nearest point, and the nearest of another setting: a line through them follows a
        # curve well enough.
        points = sorted(work.points, key=lambda taken: abs(taken.volts - reading.volts))
        if not points:
            trusted = self._reference if self._trusted else None
            return None if trusted is None else self._by(trusted, reading)
        first = points[0]
        slope = self._slope(first, points[1:])
        if slope is not None:
            return first.value + slope * (reading.volts - first.volts)
        return first.value if abs(reading.volts - first.volts) < WIZARD.same_setting_volts else None

    def _slope(self, first: RecordedPoint, others: Sequence[RecordedPoint]) -> float | None:
        """Return the value per volt about a point: by another point, else by the reference."""
        second = next((taken for taken in others if taken.value != first.value), None)
        if second is not None and abs(second.volts - first.volts) > WIZARD.min_volts_apart:
            return (second.value - first.value) / (second.volts - first.volts)
        if second is not None or self._reference is None:
            return None
        low, high = self._reference.range
        values = self._in_unit(self._reference.evaluate(np.array((low, high))))
        return float(values[1] - values[0]) / (high - low)

    def _as_expected(
        self, slot: ScheduledSetting, reading: VoltageReading, work: AngleProgress
    ) -> bool:
        if self._reference is None:
            return False
        return abs(
            self._by(self._reference, reading) - slot.value
        ) < WIZARD.near_share * self._spacing(work)

    def _by(self, certificate: Certificate, reading: VoltageReading) -> float:
        supply = None if reading.excitation is None else np.array([reading.excitation])
        return float(self._in_unit(certificate.evaluate(np.array([reading.volts]), supply))[0])

    def _in_unit(self, values: FloatArray) -> FloatArray:
        return from_si(values, self._instrument.unit, channel(self._instrument.channel).quantity)


def _beyond(slot: ScheduledSetting, value: float | None, apart: float) -> bool:
    if value is None:
        return True
    return value < slot.value - apart if slot.direction == "up" else value > slot.value + apart


def _direction(side: ApproachSide | None, *, rising: bool) -> Direction:
    if side is None:
        return "single"
    return "up" if (side == "below") == rising else "down"
