"""An instrument set by hand: when a sign is proven, when a point may be taken, what is wrong.

Noise and the ends of the converter show at once. That an instrument is dead, swapped or reversed
shows only against a movement: when the crew says that there was one, when another instrument was
moved and held in its place, or when none has come for long.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from calibration.certificate import Certificate
from calibration.instrument_faults import InstrumentFault, find_faults
from calibration.plan import InstrumentPlan
from calibration.points import Direction
from calibration.settings import WIZARD
from calibration.voltage_monitor import VoltageMonitor, VoltageReading
from calibration.wizard.procedure import SampleSlice
from calibration.wizard.state import AngleProgress, RecordedPoint, ScheduledSetting
from gsapp.quantities import FloatArray, channel, from_si

ApproachSide = Literal["below", "above"]


class ApproachTracker:
    """Remembers where volts were before they came to rest.

    It is fed means over short, equal times, so that noise is small against `apart`.
    """

    def __init__(self) -> None:
        self._means: list[float] = []

    def restart(self) -> None:
        """Forget where the volts were: from here on they must move anew."""
        self._means.clear()

    def feed(self, mean: float) -> None:
        if math.isfinite(mean):
            self._means.append(mean)
            del self._means[: -WIZARD.max_means]

    def approach_side(self, volts: float, apart: float) -> ApproachSide | None:
        """Return the side from which the volts last came to a rest at `volts`.

        Parameters
        ----------
        volts : float
            Where they rest, V.
        apart : float
            How far away from there counts as elsewhere, V.

        Returns
        -------
        {"below", "above"} or None
            None where they were nowhere else since the last restart.
        """
        for mean in reversed(self._means):
            if abs(mean - volts) > apart:
                return "below" if mean < volts else "above"
        return None


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
        """Return what the volts stand for, in the unit of the plan."""
        certificate = drawn or self._reference
        if certificate is None or self.reading.state == "absent":
            return None
        return self._by(certificate, self.reading)

    def expected_rising(self) -> bool | None:
        """Return whether volts rise towards positive values by the reference."""
        return None if self._reference is None else sum(self._reference.end_slopes) > 0.0

    def detect_sign(self, *, confirmed: bool) -> StepProposal:
        """Return whether the movement to the positive side was seen."""
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
        """Return whether the point of a setting can be taken now."""
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


class _OtherInstrument:
    """Another instrument: whether it was moved far and is held there."""

    def __init__(self) -> None:
        self._arrival = ApproachTracker()
        self._last: deque[float] = deque(maxlen=round(WIZARD.sign_hold / WIZARD.slice_duration))

    def restart(self) -> None:
        self._arrival.restart()
        self._last.clear()

    def feed(self, volts: FloatArray) -> None:
        known = volts[np.isfinite(volts)]
        if known.size:
            mean = float(known.mean())
            self._arrival.feed(mean)
            self._last.append(mean)

    @property
    def held_elsewhere(self) -> bool:
        last = self._last
        if len(last) < (last.maxlen or 0) or max(last) - min(last) > WIZARD.held_volts:
            return False
        return self._arrival.approach_side(last[-1], WIZARD.min_sign_movement) is not None


class AngleFaultMonitor:
    """Watches an instrument, and those that it may be swapped with."""

    def __init__(
        self,
        instrument: InstrumentPlan,
        others: Sequence[str],
        reference: Certificate | None,
    ) -> None:
        self._instrument = instrument
        self._slope = 0 if reference is None else int(np.sign(sum(reference.end_slopes)))
        self._others = {name: _OtherInstrument() for name in others}
        self._trail: deque[SampleSlice] = deque(
            maxlen=round(WIZARD.sample_retention / WIZARD.slice_duration)
        )
        self._due = 0
        self._unmoved = 0.0
        self._seen: tuple[InstrumentFault, ...] = ()
        self._told: tuple[InstrumentFault, ...] = ()

    @property
    def faults(self) -> tuple[InstrumentFault, ...]:
        return self._seen

    def restart(self) -> None:
        """Look at what comes from here on only."""
        self._trail.clear()
        self._due = 0
        self._unmoved = 0.0
        self._seen = self._told = ()
        for other in self._others.values():
            other.restart()

    def feed(self, one: SampleSlice) -> None:
        self._trail.append(one)
        for name, other in self._others.items():
            other.feed(one.volts[name])

    def update(self, *, moved: bool, sign_asked: bool) -> None:
        """Look at what came, every now and then."""
        self._unmoved = 0.0 if moved else self._unmoved + WIZARD.slice_duration
        self._due += 1
        if self._due < round(WIZARD.check_interval / WIZARD.slice_duration):
            return
        self._due = 0
        if moved:
            self._told = ()
        found = self._at_once() or self._told
        if not found and sign_asked and not moved:
            found = self._without_movement()
        self._seen = self._same(found)

    def diagnose_after_movement(self) -> tuple[InstrumentFault, ...]:
        """Return what is wrong, now that the crew has moved it to the positive side.

        That stays so until the instrument itself is seen to move.
        """
        names = [name for name, other in self._others.items() if other.held_elsewhere]
        found = self._open_wire() or find_faults(
            self._instrument.channel,
            self._volts((self._instrument.channel, *names), WIZARD.sample_retention),
            sense=1,
            slope_sign=self._slope,
        )
        self._seen = self._told = self._same(found)
        return self._seen

    def _same(self, found: tuple[InstrumentFault, ...]) -> tuple[InstrumentFault, ...]:
        before = {(fault.kind, fault.swapped_with): fault for fault in self._seen}
        return tuple(before.get((fault.kind, fault.swapped_with), fault) for fault in found)

    def _at_once(self) -> tuple[InstrumentFault, ...]:
        """Return what needs no movement to be seen."""
        if self._length < WIZARD.recent_time:
            return ()
        open_wire = self._open_wire()
        if open_wire:
            return open_wire
        own = self._instrument.channel
        recent = find_faults(own, self._volts((own,), WIZARD.recent_time), movement=False)
        return tuple(fault for fault in recent if fault.kind in ("noisy", "clipped"))

    def _open_wire(self) -> tuple[InstrumentFault, ...]:
        """Return that it is dead, if it was at an end of the converter from the beginning on."""
        name = self._instrument.channel
        volts = self._volts((name,), WIZARD.sample_retention)[name]
        known = volts[np.isfinite(volts)]
        if not known.size or np.ptp(known) > 0.005:
            return ()
        if 0.005 < float(known.mean()) < 4.99:
            return ()
        return (self._dead(f"reads {known.mean():.2f} V constantly; check plug, wiper and supply"),)

    def _without_movement(self) -> tuple[InstrumentFault, ...]:
        """Return what it means that others were moved, or that nothing was, while it was asked."""
        own = self._instrument.channel
        names = [name for name, other in self._others.items() if other.held_elsewhere]
        if names:
            found = find_faults(own, self._volts((own, *names), WIZARD.sample_retention))
            return tuple(fault for fault in found if fault.kind == "swapped")
        if self._unmoved >= WIZARD.movement_timeout:
            seconds = f"{WIZARD.movement_timeout:.0f} s"
            return (
                self._dead(
                    f"no movement for {seconds}; if it was moved, it is dead: check plug, wiper "
                    "and supply"
                ),
            )
        return ()

    def _dead(self, text: str) -> InstrumentFault:
        return InstrumentFault(
            kind="dead",
            channel=self._instrument.channel,
            sentence=f"{self._instrument.title}: {text}",
        )

    @property
    def _length(self) -> float:
        return len(self._trail) * WIZARD.slice_duration

    def _volts(self, names: tuple[str, ...], seconds: float) -> dict[str, FloatArray]:
        slices = list(self._trail)[-round(seconds / WIZARD.slice_duration) :]
        return {
            name: np.concatenate([one.volts[name] for one in slices]) if slices else np.empty(0)
            for name in names
        }
