"""Channels that are reversed or stuck, and surfaces that nobody saw move.

A reversed channel turns a whole pattern of derivatives over. A reversed pitch gyro leaves Cm_q
alone (both sides change) but turns over Cm_alpha and Cm_de; a reversed elevator turns over Cm_de
only; a reversed alpha vane Cm_alpha and CN_alpha. So the channel is named whose pattern fits.

What a stuck instrument did not see must not pass for a motion that was not there.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from gsapp.dynamics.model import Model
from gsapp.dynamics.trim import find_suspect_signs
from gsapp.flight.maneuvers.dead_instruments import is_stuck, sensor_noise
from gsapp.foundation import FlightError
from gsapp.identification.axes import AXIS_SURFACES, Axis
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.preparation_settings import PREPARATION
from gsapp.identification.record_preparation import COMMAND_CHANNELS
from gsapp.identification.results import DerivativeEstimate, Estimate
from gsapp.quantities import SURFACE_NAMES

_USUAL_SIGNS: Mapping[str, int] = {
    "CN_alpha": 1,
    "CN_de": 1,
    "Cm_alpha": -1,
    "Cm_q": -1,
    "Cm_de": -1,
    "CY_beta": -1,
    "CY_dr": 1,
    "Cl_beta": -1,
    "Cl_p": -1,
    "Cl_da": 1,
    "Cn_beta": 1,
    "Cn_r": -1,
    "Cn_dr": -1,
}
"""Signs that an aircraft of the usual layout has."""
_UNCERTAIN_SIGNS = frozenset({"CN_de", "CY_dr", "Cl_beta"})
"""These may differ on a sound aircraft: they tell channels apart, but raise no alarm alone."""
_REVERSED_PATTERNS: Mapping[str, tuple[str, ...]] = {
    "elevator (de)": ("Cm_de", "CN_de"),
    "aileron (da)": ("Cl_da",),
    "rudder (dr)": ("Cn_dr", "CY_dr"),
    "angle of attack (alpha)": ("CN_alpha", "Cm_alpha"),
    "sideslip (beta)": ("CY_beta", "Cl_beta", "Cn_beta"),
    "roll rate (p)": ("Cl_beta", "Cl_da"),
    "pitch rate (q)": ("Cm_alpha", "Cm_de"),
    "yaw rate (r)": ("Cn_beta", "Cn_dr"),
    "normal acceleration (an)": ("CN_alpha", "CN_de"),
    "side acceleration (ay)": ("CY_beta", "CY_dr"),
}
"""By channel: the derivatives whose sign changes when it is reversed."""


def suspicious_signs(estimate: Estimate) -> tuple[str, ...]:
    """Return which channels, or else derivatives, look reversed; one sentence each.

    `estimate`: by any method.
    """
    return sign_warnings(
        {
            name: (one.value, one.std)
            for name, one in estimate.derivatives.items()
            if one.status == "estimated" and one.value is not None and one.std
        }
    )


def sign_warnings(derivatives: Mapping[str, tuple[float, float]]) -> tuple[str, ...]:
    """Return which channels, or else derivatives, look reversed; one sentence each.

    `derivatives`: value and bound by name. Only those three bounds from zero are judged.
    """
    values = {
        name: value
        for name, (value, std) in derivatives.items()
        if name in _USUAL_SIGNS and abs(value) > PREPARATION.sign_sigmas * std
    }
    wrong = {name for name, value in values.items() if value * _USUAL_SIGNS[name] < 0.0}
    right = values.keys() - wrong
    found = []
    while wrong - _UNCERTAIN_SIGNS:
        # The channel that explains most, and would spoil nothing that is right.
        fitting = [
            (len(wrong.intersection(turned)), channel)
            for channel, turned in _REVERSED_PATTERNS.items()
            if wrong.intersection(turned) - _UNCERTAIN_SIGNS and right.isdisjoint(turned)
        ]
        if not fitting:
            break
        most = max(count for count, _ in fitting)
        channels = [channel for count, channel in fitting if count == most]
        turned = sorted(wrong.intersection(*(_REVERSED_PATTERNS[one] for one in channels)))
        if not turned:
            turned = sorted(wrong.intersection(_REVERSED_PATTERNS[channels[0]]))
            channels = channels[:1]
        numbers = " and ".join(f"{name} = {values[name]:.3g}" for name in turned)
        found.append(
            f"the sign of {' or of '.join(channels)} appears wrong: {numbers} "
            f"{'has' if len(turned) == 1 else 'have'} the opposite sign on every usual aircraft"
        )
        wrong -= set(turned)
    rest = {name: values[name] for name in wrong}
    return (*found, *find_suspect_signs(Model(derivatives=rest)))


_EXCITED_STATES: Final[Mapping[Axis, tuple[str, ...]]] = {
    "lon": ("alpha", "q"),
    "lat": ("beta", "p", "r"),
    "both": ("alpha", "q", "beta", "p", "r"),
}
"""What an input of each axis must move."""


def check_sample_count(maneuver: Maneuver) -> None:
    """Raise `FlightError` where a maneuver has too few samples for anything."""
    count = len(maneuver.block)
    if count < PREPARATION.min_samples:
        raise FlightError(
            f"maneuver {maneuver.id} of '{maneuver.flight}' has {count} samples; at least "
            f"{PREPARATION.min_samples} are needed: widen the cut"
        )


def _is_stuck(maneuver: Maneuver, channel: str) -> bool:
    """Return whether a channel was measured and moves by less than its own noise."""
    samples = maneuver.samples(channel)
    samples = samples[np.isfinite(samples)]
    return samples.size >= PREPARATION.min_samples and is_stuck(
        samples, sensor_noise(maneuver.aircraft)[channel]
    )


def remove_stuck_channels(
    maneuvers: Sequence[Maneuver], axis: Axis
) -> tuple[list[Maneuver], list[str]]:
    """Return maneuvers without the instruments that are stuck, and what to say of those.

    For methods that take motion as it was measured.

    Raises `FlightError` if a maneuver has too few samples.
    """
    found: list[Maneuver] = []
    remarks: list[str] = []
    for maneuver in maneuvers:
        check_sample_count(maneuver)
        whole, stuck = without_stuck_channels(maneuver, axis)
        found.append(whole)
        remarks += [f"maneuver {maneuver.id}: {one}" for one in stuck]
    return found, remarks


def unmeasured_surfaces_text(unseen: Mapping[str, str], evidence: str = "") -> str:
    """Return in a sentence why nothing is earned where a surface was not seen.

    `unseen`: from `unmeasured_surfaces`; not empty.
    `evidence`: that it moved.
    """
    name, words = next(iter(unseen.items()))
    text = f"{words}, {evidence}" if evidence else words
    return (
        f"{text}: if it moved, all values are wrong; repair the record, or state that it rested "
        f"(--stand-in {name}=0)"
    )


def withhold_values(found: Estimate, why: str) -> Estimate:
    """Return an estimate none of whose numbers is earned."""
    return replace(
        found,
        derivatives={
            name: DerivativeEstimate(value=None, status="unknown", why=why)
            if one.status == "estimated"
            else one
            for name, one in found.derivatives.items()
        },
        free=(),
        covariance=np.empty((0, 0)),
        warnings=(why, *found.warnings),
    )


def check_estimate_support(
    found: Estimate, maneuvers: Sequence[Maneuver], given: Collection[str], remarks: Sequence[str]
) -> Estimate:
    """Return an estimate by a method that takes motion as measured, with what is to be said.

    Where a surface is stuck nothing is earned: such a method has no residuals to tell whether it
    moved. Where nothing is stuck, reversed signs are named.

    Parameters
    ----------
    maneuvers : sequence of Maneuver
        That it is from.
    given : collection of str
        As for `unmeasured_surfaces`.
    remarks : sequence of str
        From `remove_stuck_channels`.
    """
    unseen = {
        name: text
        for maneuver in maneuvers
        for name, text in unmeasured_surfaces(maneuver, found.axis, given)
        if maneuver.has(name)
    }
    signs = () if unseen or remarks else suspicious_signs(found)
    found = replace(found, warnings=(*remarks, *signs, *found.warnings))
    return withhold_values(found, unmeasured_surfaces_text(unseen)) if unseen else found


def without_stuck_channels(maneuver: Maneuver, axis: Axis) -> tuple[Maneuver, tuple[str, ...]]:
    """Return a maneuver without the instruments that are stuck, and what to say of each.

    `axis`: only what its surfaces must have moved can be told from what rests.
    """
    if set(AXIS_SURFACES[axis]).isdisjoint(maneuver.inputs):
        return maneuver, ()
    stuck = [name for name in _EXCITED_STATES[axis] if _is_stuck(maneuver, name)]
    if not stuck:
        return maneuver, ()
    block = maneuver.block
    kept = block.select([name for name in block.channels if name not in stuck])
    said = tuple(
        f"{name} stays at {_constant_value(maneuver, name):g} throughout: its instrument is "
        "stuck and is ignored"
        for name in stuck
    )
    return replace(maneuver, block=kept), said


def unmeasured_surfaces(
    maneuver: Maneuver, axis: Axis, given: Collection[str] = ()
) -> Iterator[tuple[str, str]]:
    """Yield each surface of an axis whose motion nobody saw, with that in words.

    `given`: surfaces that the user gave a constant for, and so answers for.
    """
    controls = maneuver.aircraft.controls
    kinds = {"de": controls.de.kind, "da": controls.da.kind, "dr": controls.dr.kind}
    for name in AXIS_SURFACES[axis]:
        if name in given:
            continue
        if not maneuver.has(name):
            yield (
                name,
                f"the {SURFACE_NAMES[name]} ({name}) was not "
                f"measured{_command_only_hint(maneuver, name)}",
            )
        elif _is_stuck(maneuver, name) and kinds[name] == "position":
            # A command that nobody gave is known to rest.
            yield (
                name,
                f"{name} stays at {_constant_value(maneuver, name):.4g} rad throughout (stuck?)",
            )


def _constant_value(maneuver: Maneuver, channel: str) -> float:
    return float(np.nanmax(maneuver.samples(channel)))


def _command_only_hint(maneuver: Maneuver, name: str) -> str:
    """Return what can be done where the command of a surface is all that was recorded."""
    command = COMMAND_CHANNELS[name]
    if not maneuver.has(command):
        return ""
    return (
        f', but its command ({command}) was: write kind = "command" with lag and delay of the '
        f"servo under [controls.{name}] of the aircraft file, and that will do"
    )
