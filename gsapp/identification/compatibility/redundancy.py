"""Instruments for one quantity against one another.

Redundant sensors (``q``, ``q.2``, ``q.3``), the two halves of a surface pair, a surface and the
combined control made from it, airspeed and dynamic pressure: each pair has one truth. With three,
the one that the two others outvote is named.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations

import numpy as np

from gsapp.decoding.air_data import true_airspeed
from gsapp.foundation.name_suggestions import join_names
from gsapp.identification.compatibility.results import (
    InstrumentVerdict,
    SensorComparison,
    channel_title,
    format_quantity,
)
from gsapp.identification.compatibility.settings import COMPATIBILITY, CompatibilitySettings
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.motion import measured_motion
from gsapp.quantities import FloatArray, channel
from gsapp.quantities.channels import base_id
from gsapp.quantities.constants import DEGREE

_PAIRS = (
    ("elevator_left", "elevator_right"),
    ("aileron_left", "aileron_right"),
    ("rudder", "dr"),
)
_SURFACE = {"bias": 1.0 * DEGREE, "scale": 0.1, "delay": 0.02}
_AIRSPEED = "airspeed from dynamic pressure"


def compare_redundant_sensors(
    maneuvers: Sequence[Maneuver], settings: CompatibilitySettings
) -> tuple[tuple[SensorComparison, ...], tuple[InstrumentVerdict, ...]]:
    """Compare all instruments that measure one quantity.

    Returns
    -------
    comparisons : tuple of SensorComparison
        One for each pair.
    verdicts : tuple of InstrumentVerdict
        One for each quantity whose instruments disagree.
    """
    comparisons: list[SensorComparison] = []
    verdicts: list[InstrumentVerdict] = []
    for signals in _redundant_groups(maneuvers):
        names = tuple(signals)
        noise = _noise_from_triplet(signals)
        found = [
            _compare(one, other, signals, maneuvers, settings, noise)
            for one, other in combinations(names, 2)
        ]
        comparisons += [one for one in found if one is not None]
        verdicts += _disagreement_verdicts(names, [one for one in found if one is not None])
    return tuple(comparisons), tuple(verdicts)


def _redundant_groups(maneuvers: Sequence[Maneuver]) -> list[dict[str, FloatArray]]:
    """Return the groups of channels for one quantity, each over all maneuvers in a row."""
    channels = dict.fromkeys(
        name for one in maneuvers for name in one.block.channels if one.has(name)
    )
    groups: list[tuple[str, ...]] = []
    for name in channels:
        if base_id(name) == name:
            group = tuple(other for other in channels if base_id(other) == name)
            if len(group) > 1:
                groups.append(group)
    groups += [pair for pair in _PAIRS if set(pair) <= channels.keys()]
    found = [
        {name: np.concatenate([one.samples(name) for one in maneuvers]) for name in group}
        for group in groups
    ]
    pressure = next((name for name in ("dynamic_pressure", "qbar") if name in channels), None)
    if "V" in channels and pressure is not None:
        made = [
            true_airspeed(one.samples(pressure), measured_motion(one).input("rho"))
            for one in maneuvers
        ]
        found.append(
            {
                "V": np.concatenate([one.samples("V") for one in maneuvers]),
                _AIRSPEED: np.concatenate(made),
            }
        )
    return [
        signals
        for signals in found
        if np.isfinite(np.sum([*signals.values()], axis=0)).sum()
        >= COMPATIBILITY.min_redundant_samples
    ]


def _noise_from_triplet(signals: Mapping[str, FloatArray]) -> dict[str, float]:
    """Return the noise of each of three instruments from their three differences."""
    if len(signals) < 3:
        return {}
    noise = {}
    for name in signals:
        one, other = [key for key in signals if key != name][:2]
        a, b, c = (
            float(np.nanvar(signals[x] - signals[y]))
            for x, y in ((name, one), (name, other), (one, other))
        )
        noise[name] = max(0.5 * (a + b - c), 0.0) ** 0.5
    return noise


def _compare(
    reference: str,
    other: str,
    signals: Mapping[str, FloatArray],
    maneuvers: Sequence[Maneuver],
    settings: CompatibilitySettings,
    noise: Mapping[str, float],
) -> SensorComparison | None:
    x, y = signals[reference], signals[other]
    good = np.isfinite(x) & np.isfinite(y)
    if good.sum() < COMPATIBILITY.min_redundant_samples:
        return None
    a, b = x[good], y[good]
    bias = float(b.mean() - a.mean())
    spread = float(np.std(b - a))
    moving = max(np.var(a), np.var(b)) > COMPATIBILITY.min_motion_ratio * max(
        _difference_noise(b - a) ** 2, 1e-18
    )
    scale = delay = None
    left = spread
    if moving:
        scale = _total_least_squares_slope(a, b)
        delay = _estimate_delay(x, y, maneuvers[0].dt)
        left = float(np.std(b - b.mean() - scale * (a - a.mean())))
    limits = _limits(reference, settings)
    wrong = []
    uncertain = COMPATIBILITY.redundant_sigmas * left / np.sqrt(max(good.sum() / 25.0, 1.0))
    name = channel_title(other)
    if abs(bias) > limits["bias"] + uncertain:
        wrong.append(f"is {format_quantity(_unit_of(reference), bias)} off")
    if scale is not None and not np.std(a) < uncertain:
        doubt = uncertain / float(np.std(a))
        if scale < 0.0:
            wrong.append("moves the other way")
        elif abs(scale - 1.0) > limits["scale"] + doubt:
            wrong.append(f"shows {scale:.2f} times as much")
    if delay is not None and abs(delay) > limits["delay"]:
        wrong.append(f"comes {1e3 * abs(delay):.0f} ms {'later' if delay > 0.0 else 'earlier'}")
    if not wrong and spread > 3.0 * limits["bias"]:
        wrong.append(f"differs by {format_quantity(_unit_of(reference), spread)} (rms)")
    return SensorComparison(
        reference=reference,
        other=other,
        bias=bias,
        scale=scale,
        delay=delay,
        noise=(noise[reference], noise[other]) if noise else None,
        difference=float(np.sqrt(np.mean((b - a) ** 2))),
        agree=not wrong,
        sentence=f"against {channel_title(reference)}, {name} {' and '.join(wrong)}"
        if wrong
        else "",
    )


def _unit_of(name: str) -> str:
    return "V" if name == _AIRSPEED else name


def _limits(name: str, settings: CompatibilitySettings) -> Mapping[str, float]:
    base = base_id(name)
    try:
        return {kind: settings.tolerable_size(f"{base}.{kind}") for kind in _SURFACE}
    except KeyError:
        return {**_SURFACE, "bias": COMPATIBILITY.precision_ratio * channel(base).precision}


def _total_least_squares_slope(a: FloatArray, b: FloatArray) -> float:
    """Return the slope of b over a where both are noisy alike (the long axis of the cloud)."""
    (xx, xy), (_, yy) = np.cov(a, b)
    if xy == 0.0:
        return 0.0
    return float((yy - xx + np.hypot(yy - xx, 2.0 * xy)) / (2.0 * xy))


def _difference_noise(samples: FloatArray) -> float:
    return float(np.std(np.diff(samples)) / np.sqrt(2.0))


def _estimate_delay(x: FloatArray, y: FloatArray, dt: float) -> float:
    """Return how late y is against x, s: where the two are the most alike, a parabola between."""
    reach = max(1, round(COMPATIBILITY.max_redundant_delay / dt))
    middle = slice(reach, x.size - reach)
    if x.size < 4 * reach:
        return 0.0
    alike = []
    for shift in range(-reach, reach + 1):
        late = y[reach + shift : x.size - reach + shift]
        good = np.isfinite(late) & np.isfinite(x[middle])
        alike.append(_correlation(x[middle][good], late[good]))
    best = int(np.argmax(alike))
    if not 0 < best < 2 * reach:
        return (best - reach) * dt
    before, at, after = alike[best - 1 : best + 2]
    bend = before - 2.0 * at + after
    part = 0.5 * (before - after) / bend if bend else 0.0
    return (best - reach + part) * dt


def _correlation(a: FloatArray, b: FloatArray) -> float:
    if a.size < 2 or not (np.ptp(a) and np.ptp(b)):
        return 0.0
    return abs(float(np.corrcoef(a, b)[0, 1]))


def _disagreement_verdicts(
    names: Sequence[str], found: Sequence[SensorComparison]
) -> list[InstrumentVerdict]:
    wrong = [one for one in found if not one.agree]
    if not wrong:
        return []
    worst = max(wrong, key=lambda one: one.difference)
    outvoted = [
        name
        for name in names
        if len(names) > 2
        and all(one.agree != (name in (one.reference, one.other)) for one in found)
    ]
    if len(outvoted) == 1:
        others = join_names([channel_title(name) for name in names if name != outvoted[0]])
        said = next(one.sentence for one in wrong)
        sentence = f"{channel_title(outvoted[0])} is outvoted: {others} agree; {said}"
        channels: tuple[str, ...] = (outvoted[0],)
    else:
        sentence = f"{worst.sentence}; one of the two is wrong"
        channels = (worst.reference, worst.other)
    return [
        InstrumentVerdict(
            kind="disagreement",
            channels=channels,
            sentence=sentence,
            before=worst.difference,
        )
    ]
