"""What the instruments of a maneuver show, cut into unbroken stretches."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.decoding.air_data import true_airspeed
from gsapp.foundation import FlightError
from gsapp.foundation.name_suggestions import join_names
from gsapp.identification.compatibility.settings import (
    COMPATIBILITY,
    KINEMATIC_INPUTS,
    KINEMATIC_OUTPUTS,
    MIN_NOISE,
)
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.motion import measured_motion
from gsapp.identification.smoothing import contiguous_slices, interpolate_missing
from gsapp.quantities import BoolArray, FloatArray

_CALIBRATED = ("V", "alpha", "beta")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CompatibilitySegment:
    """Unbroken samples of one maneuver."""

    maneuver: str
    aircraft: Aircraft
    times: FloatArray  # Shape (n,). Flight time, s.
    dt: float
    inputs: Mapping[str, FloatArray]
    """Shape (n,). Rates (rad/s) and specific forces (m/s^2; an positive up) as shown, none
    missing."""
    outputs: Mapping[str, FloatArray]
    """Shape (n,). V, alpha, beta, phi, theta as shown; NaN where missing."""
    absent: frozenset[str]  # Of `inputs`: those that no instrument measured and that are zero here.
    noise: Mapping[str, float]  # White noise of each, rms of a sample.
    assumed_speed: float | None = None
    """m/s, where airspeed was not measured; `outputs` then holds it as V."""

    @property
    def measured(self) -> frozenset[str]:
        """Return the channels of `outputs` that an instrument shows."""
        guessed = {"V"} if self.assumed_speed is not None else set()
        return frozenset(self.outputs.keys() - guessed)

    def with_swapped_channels(
        self, signs: Mapping[str, float], order: Mapping[str, str]
    ) -> CompatibilitySegment:
        """Return the stretch with signs turned and channels read from one another's place."""

        def remedied(table: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
            both = {**self.inputs, **self.outputs}
            return {name: signs.get(name, 1.0) * both[order.get(name, name)] for name in table}

        noise = {name: self.noise[order.get(name, name)] for name in self.noise}
        return replace(
            self, inputs=remedied(self.inputs), outputs=remedied(self.outputs), noise=noise
        )


@dataclass(slots=True)
class PreparedSegments:
    """Stretches of all maneuvers, and what there is to say about the channels."""

    segments: list[CompatibilitySegment] = field(default_factory=list)
    stuck: dict[str, list[str]] = field(default_factory=dict)
    """Channels that stayed constant while the aircraft moved, with the maneuvers."""
    warnings: list[str] = field(default_factory=list)

    def hide(self, channel: str) -> None:
        """Leave a channel of `CompatibilitySegment.outputs` out of the stretches."""
        self.segments = [
            replace(one, outputs={k: v for k, v in one.outputs.items() if k != channel})
            for one in self.segments
        ]

    @property
    def channels(self) -> tuple[str, ...]:
        present = set[str]()
        for stretch in self.segments:
            present |= (stretch.inputs.keys() - stretch.absent) | stretch.measured
        return tuple(name for name in (*KINEMATIC_INPUTS, *KINEMATIC_OUTPUTS) if name in present)


def estimate_white_noise(samples: FloatArray) -> float:
    """Return the white noise (rms of a sample) of a signal, from where no aircraft moves.

    The median power between a quarter and nearly half of the sample rate, tones left aside.

    `samples`, shape (n,): none missing.
    """
    count = samples.size
    centered = samples - np.linspace(samples[:5].mean(), samples[-5:].mean(), count)
    power = np.abs(np.fft.rfft(np.hanning(count) * centered)) ** 2 / (0.375 * count)
    high = power[count // 4 : int(0.48 * count)]
    # The median of an exponential distribution is ln 2 of its mean.
    return float(np.sqrt(np.median(high) / np.log(2.0))) if high.size else 0.0


def prepare_segments(maneuvers: Sequence[Maneuver], aircraft: Aircraft | None) -> PreparedSegments:
    """Collect the stretches of maneuvers.

    `aircraft`: in place of the one that each maneuver knows.
    """
    found = PreparedSegments()
    for maneuver in maneuvers:
        _prepare_maneuver(found, maneuver, aircraft or maneuver.aircraft)
    found.warnings[:] = dict.fromkeys(found.warnings)
    return found


def _prepare_maneuver(found: PreparedSegments, maneuver: Maneuver, aircraft: Aircraft) -> None:
    title = f"maneuver {maneuver.id}"
    count = len(maneuver.block)
    if count < COMPATIBILITY.min_segment_samples:
        found.warnings.append(
            f"{title} has {count} samples; too few to compare instruments: give at least "
            f"{COMPATIBILITY.min_segment_samples}"
        )
        return
    dt = maneuver.dt
    signals = {name: maneuver.samples(name) for name in (*KINEMATIC_INPUTS, *KINEMATIC_OUTPUTS)}
    signals["V"], guessed = _airspeed_or_guess(maneuver, signals["V"])
    _drop_stuck(found, maneuver, signals)
    there = {name for name, samples in signals.items() if np.isfinite(samples).any()}
    absent = frozenset(name for name in KINEMATIC_INPUTS if name not in there)
    shown = [name for name in KINEMATIC_OUTPUTS if name in there]
    if not there & {"alpha", "beta", "V", "phi", "theta"}:
        found.warnings.append(
            f"{title}: alpha, beta, airspeed and attitude are missing; nothing to compare rates "
            "and accelerations with"
        )
        return
    if len(absent) == len(KINEMATIC_INPUTS):
        found.warnings.append(
            f"{title}: no rates and no accelerations; the motion cannot be reconstructed"
        )
        return
    missing = [name for name in (*KINEMATIC_INPUTS, *_CALIBRATED) if name not in there]
    if missing:
        found.warnings.append(
            f"{title}: {join_names(missing)} {'was' if len(missing) == 1 else 'were'} not "
            "measured; related errors are unknown"
        )
    broken = _unbridgeable_gaps(signals, KINEMATIC_INPUTS, absent, dt)
    kept = 0
    for piece in contiguous_slices(~broken):
        visible = {
            name: signals[name][piece]
            for name in shown
            if np.isfinite(signals[name][piece]).sum() >= COMPATIBILITY.min_segment_samples // 2
        }
        if not visible or piece.stop - piece.start < max(
            COMPATIBILITY.min_segment_samples, COMPATIBILITY.min_duration / dt
        ):
            continue
        kept += 1
        driving = {
            name: np.zeros(piece.stop - piece.start)
            if name in absent
            else interpolate_missing(signals[name][piece], ~np.isfinite(signals[name][piece]))
            for name in KINEMATIC_INPUTS
        }
        if guessed is not None:
            visible["V"] = np.full(piece.stop - piece.start, guessed)
        found.segments.append(
            CompatibilitySegment(
                maneuver=maneuver.id,
                aircraft=aircraft,
                times=maneuver.block.times[piece],
                dt=dt,
                inputs=driving,
                outputs=visible,
                absent=absent,
                noise=_white_noise_levels(driving, visible, absent, aircraft),
                assumed_speed=guessed,
            )
        )
    if not kept:
        found.warnings.append(
            f"{title}: no {COMPATIBILITY.min_duration:g} s in a row have rates, accelerations and "
            "anything to compare them with"
        )


def _airspeed_or_guess(maneuver: Maneuver, samples: FloatArray) -> tuple[FloatArray, float | None]:
    """Return airspeed as shown, from whichever air data there are, or a guess at it."""
    if np.isfinite(samples).any():
        return samples, None
    for name in ("qbar", "dynamic_pressure"):
        if maneuver.has(name):
            rho = measured_motion(maneuver).input("rho")
            qbar = maneuver.samples(name)
            return np.where(np.isfinite(qbar), true_airspeed(qbar, rho), np.nan), None
    try:
        return samples, float(measured_motion(maneuver).state("V").mean())
    except FlightError:
        return samples, 30.0


def _drop_stuck(
    found: PreparedSegments, maneuver: Maneuver, signals: dict[str, FloatArray]
) -> None:
    """Take out channels that stayed constant while others moved."""
    for name, samples in signals.items():
        seen = samples[np.isfinite(samples)]
        if seen.size >= COMPATIBILITY.min_segment_samples and not np.ptp(seen):
            found.stuck.setdefault(name, []).append(maneuver.id)
            signals[name] = np.full_like(samples, np.nan)


def _unbridgeable_gaps(
    signals: Mapping[str, FloatArray], names: Sequence[str], absent: frozenset[str], dt: float
) -> BoolArray:
    """Return the samples in gaps of the driving channels too long to bridge, shape (n,)."""
    count = next(iter(signals.values())).size
    found = np.zeros(count, dtype=bool)
    for name in names:
        if name in absent:
            continue
        for gap in contiguous_slices(~np.isfinite(signals[name])):
            at_end = gap.start == 0 or gap.stop == count
            if at_end or (gap.stop - gap.start) * dt > COMPATIBILITY.max_filled_gap:
                found[gap] = True
    return found


def _white_noise_levels(
    driving: Mapping[str, FloatArray],
    shown: Mapping[str, FloatArray],
    absent: frozenset[str],
    aircraft: Aircraft,
) -> dict[str, float]:
    stated = {name: one.noise for name, one in aircraft.sensors.by_channel.items()}
    noise = {}
    for name, samples in {**driving, **shown}.items():
        if name in absent:
            continue
        clean = interpolate_missing(samples, ~np.isfinite(samples))
        floor = max(0.3 * stated.get(name, 0.0), MIN_NOISE[name])
        noise[name] = max(estimate_white_noise(clean), floor)
    return noise
