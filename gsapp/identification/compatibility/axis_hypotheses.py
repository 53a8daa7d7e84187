"""Reversed and exchanged axes: every channel on trial for being another than its name says.

Every remedy (a sign turned, two channels exchanged) is tried on the same data. One is believed
if the motion then fits far more likely than before, also under the same noise, and the residual of
a channel falls clearly. All signs of lateral channels turned together are a mirror image, which no
kinematics can tell: the fewest turns are taken.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import combinations

import numpy as np

from gsapp.identification.compatibility.instrument_error_fit import (
    InstrumentErrorFit,
    fit_instrument_errors,
    scale_bounds,
)
from gsapp.identification.compatibility.kalman_predictor import NoiseLevels
from gsapp.identification.compatibility.results import (
    InstrumentVerdict,
    SignStatus,
    channel_title,
    format_quantity,
)
from gsapp.identification.compatibility.segments import CompatibilitySegment
from gsapp.identification.compatibility.settings import (
    ACCELERATION_CHANNELS,
    COMPATIBILITY,
    RATE_CHANNELS,
    CompatibilitySettings,
)

_SIGNED_CHANNELS = ("p", "q", "r", "ax", "ay", "an", "alpha", "beta", "phi", "theta")
_GROUPS = (RATE_CHANNELS, ACCELERATION_CHANNELS, ("alpha", "beta"), ("phi", "theta"))
_RELATED_FLOW_ANGLE = {
    "p": "beta", "r": "beta", "ay": "beta", "beta": "beta",
    "q": "alpha", "an": "alpha", "alpha": "alpha", "ax": "V",
}  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class AxisCorrection:
    """A sign turned (one channel) or two channels exchanged."""

    channels: tuple[str, ...]

    @property
    def name(self) -> str:
        """Return ``-ay`` or ``p<>r``."""
        return f"-{self.channels[0]}" if len(self.channels) == 1 else "<>".join(self.channels)

    def apply(self, stretch: CompatibilitySegment) -> CompatibilitySegment:
        """Return the stretch as it is if the remedy is right."""
        if len(self.channels) == 1:
            return stretch.with_swapped_channels({self.channels[0]: -1.0}, {})
        one, other = self.channels
        return stretch.with_swapped_channels({}, {one: other, other: one})


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class AxisCorrectionResult:
    """The fit after what helped was applied."""

    segments: tuple[CompatibilitySegment, ...]
    fit: InstrumentErrorFit
    corrections: tuple[AxisCorrection, ...]
    verdicts: tuple[InstrumentVerdict, ...]


def candidate_corrections(channels: Sequence[str]) -> tuple[AxisCorrection, ...]:
    """Return all that can be tried with these channels."""
    found = [AxisCorrection(channels=(name,)) for name in _SIGNED_CHANNELS if name in channels]
    for group in _GROUPS:
        there = [name for name in group if name in channels]
        found += [AxisCorrection(channels=pair) for pair in combinations(there, 2)]
    return tuple(found)


def find_axis_corrections(
    stretches: Sequence[CompatibilitySegment],
    first: InstrumentErrorFit,
    settings: CompatibilitySettings,
    channels: Sequence[str],
) -> AxisCorrectionResult:
    """Try remedies, one after the other, as long as one helps."""
    current = AxisCorrectionResult(
        segments=tuple(stretches), fit=first, corrections=(), verdicts=()
    )
    for _ in range(COMPATIBILITY.max_corrections):
        if _is_white(current.fit):
            break
        better = _best_correction(current, settings, channels)
        if better is None:
            break
        current = better
    return current


def _is_white(found: InstrumentErrorFit) -> bool:
    """Return whether hardly more than white noise is left: then nothing is to be remedied."""
    quiet = all(
        one.noise.input_factors.max() < COMPATIBILITY.white_noise_factors[0]
        and one.noise.output_factors.max() < COMPATIBILITY.white_noise_factors[1]
        for one in found.segments
    )
    scales = [value for name, value in found.errors.items() if name.endswith(".scale")]
    return quiet and all(abs(value - 1.0) < 0.5 for value in scales)


def _has_large_residuals(found: InstrumentErrorFit) -> bool:
    """Return whether so much is left unexplained that a wrong sign may hide in it."""
    return any(one.noise.input_factors.max() > 300.0 for one in found.segments)


def _best_correction(
    current: AxisCorrectionResult, settings: CompatibilitySettings, channels: Sequence[str]
) -> AxisCorrectionResult | None:
    free = current.fit.free
    chosen = [current.segments[place] for place in _most_excited(current.segments)]
    # Under the noise that a wrong sign asks for, all signs are alike: white noise tells them apart.
    white = [NoiseLevels.white(len(one.outputs)) for one in chosen]

    def tried(remedy: AxisCorrection, *, steps: int) -> float:
        remedied = [remedy.apply(stretch) for stretch in chosen]
        found = fit_instrument_errors(
            remedied, settings, free, noises=white, iterations=steps, bounds=False
        )
        return found.neg2_log_likelihood

    done = {one.channels for one in current.corrections}
    left = [one for one in candidate_corrections(channels) if one.channels not in done]
    for steps, kept in COMPATIBILITY.screening_stages:
        left = sorted(left, key=partial(tried, steps=steps))[:kept]
    # Where a gyro or an accelerometer is missing, what it would say may look like a wrong sign.
    incomplete = any(one.absent for one in current.segments)
    best: AxisCorrectionResult | None = None
    for remedy in left:
        stretches = tuple(remedy.apply(stretch) for stretch in current.segments)
        found = fit_instrument_errors(stretches, settings, free, bounds=False)
        gain = current.fit.neg2_log_likelihood - found.neg2_log_likelihood
        if gain < COMPATIBILITY.min_likelihood_gain or not found.segments:
            continue
        # A fit in gusts may have gone astray: under the same noise, signs as they are get another
        # chance.
        noises = [one.noise for one in found.segments]
        again = fit_instrument_errors(current.segments, settings, free, noises=noises, bounds=False)
        gain = min(gain, again.neg2_log_likelihood - found.neg2_log_likelihood)
        usual = current.fit if np.isinf(again.neg2_log_likelihood) else again
        # What gusts leave in doubt takes more, too.
        strict = 3.0 if incomplete or _has_large_residuals(found) else 1.0
        verdict = _verdict(remedy, usual, found, fall=strict * COMPATIBILITY.min_residual_ratio)
        if verdict is None or gain < strict**3 * COMPATIBILITY.min_likelihood_gain:
            continue
        if best is None or found.neg2_log_likelihood < best.fit.neg2_log_likelihood:
            best = AxisCorrectionResult(
                segments=stretches,
                fit=found,
                corrections=(*current.corrections, remedy),
                verdicts=(*current.verdicts, verdict),
            )
    return best


def _most_excited(stretches: Sequence[CompatibilitySegment]) -> list[int]:
    moved = [
        sum(float(np.ptp(samples)) for name, samples in one.inputs.items() if name in RATE_CHANNELS)
        for one in stretches
    ]
    return sorted(range(len(stretches)), key=lambda place: -moved[place])[
        : COMPATIBILITY.screening_segments
    ]


def _verdict(
    remedy: AxisCorrection, before: InstrumentErrorFit, after: InstrumentErrorFit, *, fall: float
) -> InstrumentVerdict | None:
    """Return the verdict; None where no residual falls."""
    seen: dict[str, tuple[float, float]] = {}
    for one in before.segments:
        for name in one.segment.measured:
            seen[name] = (before.rms(name), after.rms(name))
    if not seen:
        return None
    falls_by = {name: old / max(new, 1e-12) for name, (old, new) in seen.items()}
    channel = max(falls_by, key=lambda name: falls_by[name])
    # The one that speaks to a crew, where it shows as well.
    nearest = _RELATED_FLOW_ANGLE.get(remedy.channels[0], channel)
    if falls_by.get(nearest, 0.0) > COMPATIBILITY.flow_angle_ratio:
        channel = nearest
    old, new = seen[channel]
    if not old > fall * new:
        return None
    falls = (
        f"the residual of {channel_title(channel)} falls from {format_quantity(channel, old)} to "
        f"{format_quantity(channel, new)}"
    )
    names = remedy.channels
    if len(names) == 1:
        sentence = (
            f"the sign of {channel_title(names[0])} appears reversed: with the sign changed, "
            f"{falls}; reverse it in the channel map or the calibration"
        )
    else:
        sentence = (
            f"{channel_title(names[0])} and {channel_title(names[1])} appear swapped: "
            f"exchanged, {falls}; swap them in the channel map"
        )
    return InstrumentVerdict(
        kind="reversed" if len(names) == 1 else "exchanged",
        channels=names,
        sentence=sentence,
        before=old,
        after=new,
        seen_in=channel,
    )


def evaluate_signs(
    found: AxisCorrectionResult, settings: CompatibilitySettings, channels: Sequence[str]
) -> Mapping[str, SignStatus]:
    """Return for each channel whether its sign was put to the test, and with what outcome."""
    turned = {one.channels[0] for one in found.corrections if len(one.channels) == 1}
    bounds = scale_bounds(
        found.fit, settings, [name for name in _SIGNED_CHANNELS if name in channels]
    )
    # With much left unexplained a sign may be wrong unseen.
    clear = found.fit.converged and not _has_large_residuals(found.fit)
    signs: dict[str, SignStatus] = {}
    for name, bound in bounds.items():
        if name in turned:
            signs[name] = "reversed"
        else:
            seen = bound < COMPATIBILITY.max_scale_std and clear
            signs[name] = "right" if seen else "not-observable"
    return signs
