"""What is wrong with an instrument, while one surface alone is moved by hand.

The person is asked to move one surface, once, to one side and to hold it there. Its own volts must
follow, no other's may; what follows instead, or does not, names the fault.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from calibration.adc import ADC_FULL_SCALE, ADC_RESOLUTION, is_clipped
from calibration.settings import CALIBRATION
from gsapp.quantities import FloatArray, channel

FaultKind = Literal["dead", "noisy", "clipped", "swapped", "reversed"]


@dataclass(frozen=True, slots=True, kw_only=True)
class InstrumentFault:
    """One fault of one instrument."""

    kind: FaultKind
    channel: str
    swapped_with: str = ""
    """The channel that followed in its place, where swapped."""
    sentence: str = ""
    """What was seen, and what to do."""


def find_faults(
    moved: str,
    volts: Mapping[str, FloatArray],
    *,
    movement: bool = True,
    sense: int = 0,
    slope_sign: int = 0,
) -> tuple[InstrumentFault, ...]:
    """Judge an instrument while its surface, and no other, was moved.

    Parameters
    ----------
    volts : mapping of str to ndarray, shape (n,)
        Channel -> its volts over the same time, V, from before the movement until after it; NaN
        where missing. Channels that cannot have moved along only: not the partner of a surface
        that is driven by the same rod.
    movement : bool
        Whether a movement is known to be in it. Without one only noisy and clipped can be told.
    sense : {-1, 0, +1}
        Whether the surface stands at a larger (+1) or smaller value at the end than at the
        beginning; 0 if that is not known.
    slope_sign : {-1, 0, +1}
        Sign of value against volts as the certificate before, or the partner, has it; 0 if not
        known. With `sense` it tells whether the instrument is reversed.

    Returns
    -------
    tuple of InstrumentFault
        Empty where all is well. One that is dead, swapped or clipped has no other.
    """
    own = _Movement.of(volts[moved])
    followed = own.excursion > CALIBRATION.min_response_counts * ADC_RESOLUTION
    if movement and not followed:
        return (_diagnose_no_response(moved, own, _find_responding_channel(moved, volts)),)
    title = channel(moved).title
    if own.clipped >= CALIBRATION.fault_clipped_share:
        return (
            InstrumentFault(
                kind="clipped",
                channel=moved,
                sentence=f"{title}: the voltage reaches the end of the ADC range ({own.end:.2f} "
                "V); turn the potentiometer's body until its center reads about "
                f"{0.5 * ADC_FULL_SCALE:.1f} V",
            ),
        )
    found: list[InstrumentFault] = []
    if own.noise > CALIBRATION.fault_noise_counts * ADC_RESOLUTION:
        found.append(
            InstrumentFault(
                kind="noisy",
                channel=moved,
                sentence=f"{title}: noise of {1e3 * own.noise:.0f} mV; check the wiper and the "
                "shield",
            )
        )
    if followed and sense and slope_sign and np.sign(own.change) == -sense * slope_sign:
        found.append(
            InstrumentFault(
                kind="reversed",
                channel=moved,
                sentence=f"{title}: the volts went {'up' if own.change > 0.0 else 'down'} in "
                "the wrong direction; its end wires are swapped, or it was moved the "
                "wrong way",
            )
        )
    return tuple(found)


def _diagnose_no_response(moved: str, own: _Movement, follower: str) -> InstrumentFault:
    """Return what it means that a surface was moved and its own volts were not."""
    title = channel(moved).title
    if follower:
        return InstrumentFault(
            kind="swapped",
            channel=moved,
            swapped_with=follower,
            sentence=f"{title} was moved, and the volts of {channel(follower).title} followed "
            "instead; their plugs are swapped",
        )
    return InstrumentFault(
        kind="dead",
        channel=moved,
        sentence=f"{title} was moved, but its voltage stayed at {own.middle:.2f} V; check plug, "
        "wiper and supply",
    )


def _find_responding_channel(moved: str, volts: Mapping[str, FloatArray]) -> str:
    """Return the other channel that moved most, if one moved; empty otherwise."""
    excursions = {
        name: _Movement.of(samples).excursion for name, samples in volts.items() if name != moved
    }
    most = max(excursions, key=lambda name: excursions[name], default="")
    return (
        most if most and excursions[most] > CALIBRATION.min_response_counts * ADC_RESOLUTION else ""
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class _Movement:
    """How the volts of one channel moved."""

    excursion: float
    """Between the lowest and the highest running median, V, beyond what noise explains."""
    change: float
    """From the first tenth of the samples to the last, V."""
    noise: float
    """Standard deviation from one sample to the next, V; what is lost at times counts in full."""
    clipped: float
    """Share of samples at an end of the converter."""
    middle: float
    """Median, V."""
    end: float
    """The volts farthest from the middle of the converter."""

    @classmethod
    def of(cls, samples: FloatArray) -> _Movement:
        good = samples[np.isfinite(samples)]
        if good.size < CALIBRATION.min_fault_samples:
            nan = float("nan")
            return cls(excursion=0.0, change=0.0, noise=0.0, clipped=0.0, middle=nan, end=nan)
        length = max(good.size // 20, 3)
        parts = np.array_split(good, max(good.size // length, 2))
        medians = np.array([np.median(part) for part in parts])
        # Second differences, free of any steady movement; the median, free of lost contacts.
        bends = np.diff(good, 2) / np.sqrt(6.0)
        usual = float(np.median(np.abs(bends))) / 0.6745
        tenth = max(good.size // 10, 1)
        return cls(
            excursion=max(float(np.ptp(medians)) - 6.0 * usual / np.sqrt(length), 0.0),
            change=float(np.median(good[-tenth:]) - np.median(good[:tenth])),
            noise=float(np.sqrt(np.mean(bends**2))),
            clipped=float(np.mean(is_clipped(good))),
            middle=float(np.median(good)),
            end=float(good[np.argmax(np.abs(good - 0.5 * ADC_FULL_SCALE))]),
        )
