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

from gsapp.identification.compatibility.fitting import Fit, fit, scale_bounds
from gsapp.identification.compatibility.preparing import Stretch
from gsapp.identification.compatibility.results import InstrumentVerdict, Sign
from gsapp.identification.compatibility.settings import (
    ACCELERATIONS,
    RATES,
    CompatibilitySettings,
)
from gsapp.identification.compatibility.whitening import Noise
from gsapp.identification.compatibility.wording import quantity, title

_TURNED = ("p", "q", "r", "ax", "ay", "an", "alpha", "beta", "phi", "theta")
_GROUPS = (RATES, ACCELERATIONS, ("alpha", "beta"), ("phi", "theta"))
_GAIN = 20.0
"""In twice the log-likelihood: far beyond chance and beyond what free errors take up."""
_FALL = 1.2
_CLEARLY = 2.0
_NEAREST = {
    "p": "beta", "r": "beta", "ay": "beta", "beta": "beta",
    "q": "alpha", "an": "alpha", "alpha": "alpha", "ax": "V",
}  # fmt: skip
_SIGN_SEEN = 0.2
"""Bound of a scale: a turned sign is ten times that away."""
_QUIET = (3.0, 10.0)
"""Factors on the white noise that filters before the converter account for: of what drives the
motion, of what shows it."""
_SCREENED = 4
"""Stretches on which remedies are tried first; those that move most."""
_SCREENS = ((1, 6), (4, 2))
"""Steps, and how many remedies remain after them."""
_ROUNDS = 3


@dataclass(frozen=True, slots=True, kw_only=True)
class Remedy:
    """A sign turned (one channel) or two channels exchanged."""

    channels: tuple[str, ...]

    @property
    def name(self) -> str:
        """Return ``-ay`` or ``p<>r``."""
        return f"-{self.channels[0]}" if len(self.channels) == 1 else "<>".join(self.channels)

    def applied(self, stretch: Stretch) -> Stretch:
        """Return the stretch as it is if the remedy is right."""
        if len(self.channels) == 1:
            return stretch.exchanged({self.channels[0]: -1.0}, {})
        one, other = self.channels
        return stretch.exchanged({}, {one: other, other: one})


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Remedied:
    """The fit after what helped was applied."""

    stretches: tuple[Stretch, ...]
    fit: Fit
    remedies: tuple[Remedy, ...]
    verdicts: tuple[InstrumentVerdict, ...]


def remedies_for(channels: Sequence[str]) -> tuple[Remedy, ...]:
    """Return all that can be tried with these channels."""
    found = [Remedy(channels=(name,)) for name in _TURNED if name in channels]
    for group in _GROUPS:
        there = [name for name in group if name in channels]
        found += [Remedy(channels=pair) for pair in combinations(there, 2)]
    return tuple(found)


def look_for_remedies(
    stretches: Sequence[Stretch],
    first: Fit,
    settings: CompatibilitySettings,
    channels: Sequence[str],
) -> Remedied:
    """Try remedies, one after the other, as long as one helps."""
    current = Remedied(stretches=tuple(stretches), fit=first, remedies=(), verdicts=())
    for _ in range(_ROUNDS):
        if _explained(current.fit):
            break
        better = _one_more(current, settings, channels)
        if better is None:
            break
        current = better
    return current


def _explained(found: Fit) -> bool:
    """Return whether hardly more than white noise is left: then nothing is to be remedied."""
    quiet = all(
        one.noise.drive.max() < _QUIET[0] and one.noise.show.max() < _QUIET[1]
        for one in found.stretches
    )
    scales = [value for name, value in found.errors.items() if name.endswith(".scale")]
    return quiet and all(abs(value - 1.0) < 0.5 for value in scales)


def _in_doubt(found: Fit) -> bool:
    """Return whether so much is left unexplained that a wrong sign may hide in it."""
    return any(one.noise.drive.max() > 300.0 for one in found.stretches)


def _one_more(
    current: Remedied, settings: CompatibilitySettings, channels: Sequence[str]
) -> Remedied | None:
    free = current.fit.free
    chosen = [current.stretches[place] for place in _most_moving(current.stretches)]
    # Under the noise that a wrong sign asks for, all signs are alike: white noise tells them apart.
    white = [Noise.white(len(one.shown)) for one in chosen]

    def tried(remedy: Remedy, *, steps: int) -> float:
        remedied = [remedy.applied(stretch) for stretch in chosen]
        found = fit(remedied, settings, free, noises=white, iterations=steps, bounds=False)
        return found.unlikelihood

    done = {one.channels for one in current.remedies}
    left = [one for one in remedies_for(channels) if one.channels not in done]
    for steps, kept in _SCREENS:
        left = sorted(left, key=partial(tried, steps=steps))[:kept]
    # Where a gyro or an accelerometer is missing, what it would say may look like a wrong sign.
    incomplete = any(one.absent for one in current.stretches)
    best: Remedied | None = None
    for remedy in left:
        stretches = tuple(remedy.applied(stretch) for stretch in current.stretches)
        found = fit(stretches, settings, free, bounds=False)
        gain = current.fit.unlikelihood - found.unlikelihood
        if gain < _GAIN or not found.stretches:
            continue
        # A fit in gusts may have gone astray: under the same noise, signs as they are get another
        # chance.
        noises = [one.noise for one in found.stretches]
        again = fit(current.stretches, settings, free, noises=noises, bounds=False)
        gain = min(gain, again.unlikelihood - found.unlikelihood)
        usual = current.fit if np.isinf(again.unlikelihood) else again
        # What gusts leave in doubt takes more, too.
        strict = 3.0 if incomplete or _in_doubt(found) else 1.0
        verdict = _verdict(remedy, usual, found, fall=strict * _FALL)
        if verdict is None or gain < strict**3 * _GAIN:
            continue
        if best is None or found.unlikelihood < best.fit.unlikelihood:
            best = Remedied(
                stretches=stretches,
                fit=found,
                remedies=(*current.remedies, remedy),
                verdicts=(*current.verdicts, verdict),
            )
    return best


def _most_moving(stretches: Sequence[Stretch]) -> list[int]:
    moved = [
        sum(float(np.ptp(samples)) for name, samples in one.driving.items() if name in RATES)
        for one in stretches
    ]
    return sorted(range(len(stretches)), key=lambda place: -moved[place])[:_SCREENED]


def _verdict(remedy: Remedy, before: Fit, after: Fit, *, fall: float) -> InstrumentVerdict | None:
    """Return the verdict; None where no residual falls."""
    seen: dict[str, tuple[float, float]] = {}
    for one in before.stretches:
        for name in one.stretch.measured:
            seen[name] = (before.rms(name), after.rms(name))
    if not seen:
        return None
    falls_by = {name: old / max(new, 1e-12) for name, (old, new) in seen.items()}
    channel = max(falls_by, key=lambda name: falls_by[name])
    # The one that speaks to a crew, where it shows as well.
    nearest = _NEAREST.get(remedy.channels[0], channel)
    if falls_by.get(nearest, 0.0) > _CLEARLY:
        channel = nearest
    old, new = seen[channel]
    if not old > fall * new:
        return None
    falls = (
        f"the residual of {title(channel)} falls from {quantity(channel, old)} to "
        f"{quantity(channel, new)}"
    )
    names = remedy.channels
    if len(names) == 1:
        sentence = (
            f"the sign of {title(names[0])} looks reversed: with the sign turned {falls}; turn it "
            "in the channel map or the calibration"
        )
    else:
        sentence = (
            f"{title(names[0])} and {title(names[1])} look exchanged: taken for one another "
            f"{falls}; exchange them in the channel map"
        )
    return InstrumentVerdict(
        kind="reversed" if len(names) == 1 else "exchanged",
        channels=names,
        sentence=sentence,
        before=old,
        after=new,
        seen_in=channel,
    )


def signs_of(
    found: Remedied, settings: CompatibilitySettings, channels: Sequence[str]
) -> Mapping[str, Sign]:
    """Return for each channel whether its sign was put to the test, and with what outcome."""
    turned = {one.channels[0] for one in found.remedies if len(one.channels) == 1}
    bounds = scale_bounds(found.fit, settings, [name for name in _TURNED if name in channels])
    # With much left unexplained a sign may be wrong unseen.
    clear = found.fit.converged and not _in_doubt(found.fit)
    signs: dict[str, Sign] = {}
    for name, bound in bounds.items():
        if name in turned:
            signs[name] = "reversed"
        else:
            seen = bound < _SIGN_SEEN and clear
            signs[name] = "right" if seen else "not-observable"
    return signs
