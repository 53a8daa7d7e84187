"""What a search needs before it begins, and what the record keeps from it."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.discrepancy.effect_catalog import all_effects, excluded_effects, find_effect
from gsapp.discrepancy.results import InstrumentRemark
from gsapp.discrepancy.settings import SEARCH
from gsapp.dynamics.flight_model import FlightModel
from gsapp.dynamics.model import Model
from gsapp.flight.maneuvers.signals import LEVERS
from gsapp.foundation import FlightError
from gsapp.foundation.name_suggestions import format_names
from gsapp.identification.channel_faults import check_sample_count
from gsapp.identification.compatibility import (
    CompatibilitySettings,
    InstrumentVerdict,
    check_compatibility,
)
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.motion import measured_motion
from gsapp.quantities import FloatArray, channel
from gsapp.quantities.constants import GRAVITY


def check_instruments(
    maneuvers: Sequence[Maneuver], *, try_signs: bool = True
) -> tuple[InstrumentRemark, ...]:
    """Return what the data compatibility check says, of maneuvers from all over the flights.

    `try_signs` looks for reversed and exchanged axes: most of the work, and of no use where a model
    explains the flights down to the noise.
    """
    settings = CompatibilitySettings(try_signs=try_signs, iterations=SEARCH.max_check_iterations)
    flown = sorted(maneuvers, key=lambda one: (one.flight, one.block.times[0]))
    every = -(-len(flown) // SEARCH.max_checked_maneuvers)
    try:
        found = check_compatibility(flown[::every], settings=settings)
    except FlightError as error:
        return (InstrumentRemark(channel="", words=str(error), consistent=False),)
    if not found.verdicts:
        return (InstrumentRemark(channel="", words=found.summary, consistent=found.consistent),)
    return tuple(
        InstrumentRemark(
            channel=", ".join(one.channels),
            words=one.sentence,
            consistent=False,
            effect=_effect(one),
        )
        for one in found.verdicts
    )


def _effect(verdict: InstrumentVerdict) -> str:
    """Return the effect of the catalog that a verdict proves; empty if none."""
    known = {one.id for one in all_effects()}
    if verdict.kind == "reversed":
        names = [f"sensor.{verdict.channels[0]}.reversed"]
    elif verdict.kind == "exchanged":
        names = [
            f"sensor.{'_'.join(pair)}.swapped"
            for pair in (verdict.channels, verdict.channels[::-1])
        ]
    else:
        names = []
    return next((name for name in names if name in known), "")


_NEEDED = ("alpha", "q", "an")
_MIN_INPUT_RANGE = {"de": 0.01, "da": 0.01, "dr": 0.01, "flap": 0.05, "throttle": 0.08}
"""Ranges (rad; throttle 0 to 1) over all maneuvers from which an input counts as moved."""
_SUBSTITUTE_CHANNELS = {"throttle": "thrust"}


def comparable_maneuvers(maneuvers: Sequence[Maneuver]) -> list[Maneuver]:
    """Return the maneuvers without those of throttle or flap alone that were flown another way.

    With the flap as where a surface moved, steps of the throttle show what it does. In the approach
    they come with the flap out, in ground effect: all that would pass for the effect looked for.
    """
    own = [one for one in maneuvers if not one.inputs or {*one.inputs} - {*LEVERS}]
    least = _MIN_INPUT_RANGE["flap"]
    places = [_flap_range(one) for one in own]
    low, high = (
        min((one for one, _ in places), default=0.0) - least,
        max((one for _, one in places), default=0.0) + least,
    )

    def is_usual(one: Maneuver) -> bool:
        least_flap, most_flap = _flap_range(one)
        return low < least_flap and most_flap < high

    return [one for one in maneuvers if one in own or is_usual(one)]


def _flap_range(maneuver: Maneuver) -> tuple[float, float]:
    samples = maneuver.samples("flap") if maneuver.has("flap") else np.zeros(1)
    return float(np.nanmin(samples)), float(np.nanmax(samples))


def check_maneuvers(maneuvers: Sequence[Maneuver], aircraft: Aircraft) -> None:
    """Raise FlightError where nothing could be learned.

    If there are too few maneuvers, one of them is too short, a channel lacks without which nothing
    can be said, or the flights are of another aircraft.
    """
    if len(maneuvers) == 1:
        raise FlightError(
            f"only one maneuver ({maneuvers[0].id} of '{maneuvers[0].flight}'): an effect could "
            f"not be validated on another; fly at least {SEARCH.min_maneuvers}, doublets on each "
            "surface, at two speeds"
        )
    if len(maneuvers) < SEARCH.min_maneuvers:
        raise FlightError(
            f"{len(maneuvers)} maneuvers are too few to hold any out; fly at least "
            f"{SEARCH.min_maneuvers}, better 16: doublets on each surface, small and large, at two "
            "speeds"
        )
    for one in maneuvers:
        check_sample_count(one)
        lacking = [name for name in _NEEDED if not one.has(name)]
        if lacking:
            raise FlightError(
                f"maneuver {one.id} of '{one.flight}' has no {', '.join(lacking)}; record flow "
                "angles, rates and accelerations, or exclude the maneuver"
            )
        if one.aircraft.name != aircraft.name:
            raise FlightError(
                f"maneuver {one.id} of '{one.flight}' was flown by '{one.aircraft.name}', and the "
                f"aircraft file is of '{aircraft.name}'; give the file that belongs to the flight"
            )


def moving_inputs(maneuvers: Sequence[Maneuver]) -> frozenset[str]:
    """Return the inputs that move enough in these maneuvers for their effects to be seen."""
    found = set()
    for name, least in _MIN_INPUT_RANGE.items():
        channel = name
        if not any(one.has(name) for one in maneuvers):
            channel = _SUBSTITUTE_CHANNELS.get(name, name)
        low, high = np.inf, -np.inf
        for one in maneuvers:
            if one.has(channel):
                samples = one.samples(channel)
                low = min(low, float(np.nanmin(samples)))
                high = max(high, float(np.nanmax(samples)))
        if (channel != name and high > low) or high - low >= least:
            found.add(name)
    return frozenset(found)


def highest_alpha(maneuvers: Sequence[Maneuver]) -> float | None:
    """Return the angle of attack that the flights reach for a hundredth of a maneuver, rad."""
    shown = [one.samples("alpha") for one in maneuvers if one.has("alpha")]
    tops = [float(np.nanpercentile(one, 99.0)) for one in shown if np.isfinite(one).any()]
    return max(tops, default=None)


def check_forced_effects(
    forced: Sequence[str], aircraft: Aircraft, maneuvers: Sequence[Maneuver]
) -> None:
    """Raise FlightError where an effect was asked for that these flights cannot show.

    It says what to record or fly. Raise UnknownNameError if the catalog has no such effect.
    """
    channels: Collection[str] = {
        name for one in maneuvers for name in one.block.channels if one.has(name)
    }
    reasons = excluded_effects(
        aircraft,
        channels,
        moving=moving_inputs(maneuvers),
        variants=True,
        highest_alpha=highest_alpha(maneuvers),
    )
    for effect in forced:
        wanted = find_effect(effect)
        if effect in reasons:
            raise FlightError(
                f"'{effect}' ({wanted.title}) cannot be evaluated: {reasons[effect]}; "
                f"{wanted.remedy or wanted.separated_by}"
            )


def check_model_match(model: Model, maneuvers: Sequence[Maneuver]) -> None:
    """Raise FlightError if a model gives quite another normal force than these maneuvers show.

    Values that are 10 to 20 % wrong pass, and so does any single effect of the catalog; a model,
    an aircraft file or a speed that is of another aircraft does not. A vane that is mounted askew
    moves the level of the force and hardly its answer to what the pilot does; such flights pass.
    Maneuvers that hold a normal acceleration and an angle of attack count. The sentence says by how
    much, and what to check.
    """
    measured, modeled = [], []
    for one in maneuvers:
        samples = one.samples("an")
        good = np.isfinite(samples)
        if not (good.any() and one.has("alpha")):
            continue
        flight_model = FlightModel(one.aircraft, model)
        motion = measured_motion(one)
        state, inputs = tuple(motion.states.T), tuple(motion.inputs.T)
        settled = flight_model.steady_states(state, inputs)
        upward = -np.asarray(flight_model.evaluate((*state, *settled), inputs).loads[2])
        measured.append(samples[good])
        modeled.append((np.broadcast_to(upward, samples.shape) / one.mass)[good])
    if not measured:
        return
    flown, given = np.concatenate(measured), np.concatenate(modeled)
    off = float(np.median(np.abs(given - flown)))
    usual = float(np.median(np.abs(flown)))
    if (
        not off <= SEARCH.max_level_error * usual
        and not SEARCH.response_ratio_range[0]
        < _response_ratio(measured, modeled)
        < SEARCH.response_ratio_range[1]
    ):
        raise FlightError(
            f"the model '{model.name}' seems to be of another aircraft: in these maneuvers it "
            f"gives {np.median(given) / GRAVITY:.2g} g where {np.median(flown) / GRAVITY:.2g} g "
            "were measured; check model and aircraft file (mass, wing area) and the zero of the "
            "alpha vane, or leave the model out and the linear build-up is fitted"
        )


def _response_ratio(measured: Sequence[FloatArray], modeled: Sequence[FloatArray]) -> float:
    """Return how much a modeled force moves about its level where the measured one moves by 1."""
    flown = np.concatenate([one - np.median(one) for one in measured])
    given = np.concatenate([one - np.median(one) for one in modeled])
    return float(given @ flown / max(float(flown @ flown), 1e-12))


_NAMED = 3
"""Effects named in a sentence; the others are counted."""
_NEEDS = "needs "
"""How the catalog begins a reason that lies in the record, not in the effect."""


def record_remarks(maneuvers: Sequence[Maneuver], aircraft: Aircraft) -> tuple[str, ...]:
    """Return a sentence for each channel that is clipped or lacks, and for a CG that moved."""
    return (
        *_clipping_remarks(maneuvers),
        *_missing_channel_remarks(maneuvers, aircraft),
        *_cg_remarks(maneuvers),
    )


def _cg_remarks(maneuvers: Sequence[Maneuver]) -> list[str]:
    """Return what another CG than the aircraft file's means for moments."""
    ahead = [1e3 * one.cg_shift[0] for one in maneuvers]
    if not ahead or max(map(abs, ahead)) < SEARCH.cg_tolerance:
        return []
    mean = sum(ahead) / len(ahead)
    found = [
        f"the CG was {abs(mean):.0f} mm {'ahead' if mean > 0.0 else 'aft'} of the aircraft file's: "
        "moments are about the CG as flown, those of a model about the file's"
    ]
    apart = max(ahead) - min(ahead)
    if apart >= SEARCH.cg_tolerance:
        found.append(
            f"the maneuvers were flown with CGs up to {apart:.0f} mm apart: this alone may "
            "explain differences in moments; search flights of one loading separately"
        )
    return found


def _clipping_remarks(maneuvers: Sequence[Maneuver]) -> list[str]:
    places: dict[str, list[str]] = {}
    for one in maneuvers:
        for name, flags in one.clipped.items():
            share = float(flags.mean())
            if share > 0.0:
                places.setdefault(name, []).append(f"{one.id} ({max(share, 0.01):.0%})")
    return [
        f"{channel(name).symbol} is clipped in maneuver{'s' if len(where) > 1 else ''} "
        f"{', '.join(where)}: those samples are ignored; use smaller inputs or a wider-range "
        "instrument"
        for name, where in places.items()
    ]


def _missing_channel_remarks(maneuvers: Sequence[Maneuver], aircraft: Aircraft) -> list[str]:
    channels = {name for one in maneuvers for name in one.block.channels if one.has(name)}
    effects: dict[str, list[str]] = {}
    for effect, reason in excluded_effects(
        aircraft, channels, moving=moving_inputs(maneuvers)
    ).items():
        if reason.startswith(_NEEDS):
            effects.setdefault(reason, []).append(effect)
    return [
        f"{format_names(names, _NAMED)} cannot be evaluated: "
        f"{'each ' if len(names) > 1 else 'it '}{reason}"
        for reason, names in effects.items()
    ]
