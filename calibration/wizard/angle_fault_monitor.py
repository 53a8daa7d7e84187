"""What is wrong with an instrument that is set by hand, as far as the volts tell while it is moved.

Noise and the ends of the converter show at once. That an instrument is dead, swapped or reversed
shows only against a movement: when the crew says that there was one, when another instrument was
moved and held in its place, or when none has come for long.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence

import numpy as np

from calibration.certificate import Certificate
from calibration.instrument_faults import InstrumentFault, find_faults
from calibration.plan import InstrumentPlan
from calibration.wizard.approach_side import ApproachTracker
from calibration.wizard.sample_slices import SampleSlice
from calibration.wizard.settings import WIZARD
from gsapp.quantities import FloatArray


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
    """Watches an instrument, and those that it may be swapped with.

    Parameters
    ----------
    others : sequence of str
        Channels of all other instruments that are set by hand.
    reference : Certificate or None
        In force, or nominal; it tells which way the volts should go.
    """

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
        """Return what is wrong at present."""
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
        """Look at what came, every now and then.

        Parameters
        ----------
        moved : bool
            Whether the instrument itself was seen to move.
        sign_asked : bool
            Whether the crew was asked for one great movement of this instrument alone.
        """
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

    def _dead(self, words: str) -> InstrumentFault:
        return InstrumentFault(
            kind="dead",
            channel=self._instrument.channel,
            sentence=f"{self._instrument.title}: {words}",
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
