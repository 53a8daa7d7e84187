"""Which errors of instruments a fit needs: all the usual ones, or those that residuals ask for."""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Sequence
from dataclasses import replace
from math import log

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.identification.compatibility.instrument_error import InstrumentError
from gsapp.identification.compatibility.instrument_error_fit import (
    InstrumentErrorFit,
    at_limit,
    fit_instrument_errors,
    likelihood_gains,
    nominal_value,
)
from gsapp.identification.compatibility.segments import CompatibilitySegment, prepare_segments
from gsapp.identification.compatibility.settings import (
    COMPATIBILITY,
    KINEMATIC_INPUTS,
    RATE_CHANNELS,
    TOLERABLE_ERRORS,
    VANE_POSITIONS,
    CompatibilitySettings,
)
from gsapp.identification.maneuver import Maneuver


def scale_settings(settings: CompatibilitySettings, aircraft: Aircraft) -> CompatibilitySettings:
    """Return settings in which positions of vanes are plausible for the size of an aircraft."""
    span = aircraft.geometry.span
    plausible = dict.fromkeys(VANE_POSITIONS, COMPATIBILITY.plausible_position * span)
    tolerable = dict.fromkeys(VANE_POSITIONS, COMPATIBILITY.tolerable_position * span)
    return replace(
        settings,
        plausible={**plausible, **settings.plausible},
        tolerable={**tolerable, **settings.tolerable},
    )


def select_errors(
    segments: Sequence[CompatibilitySegment],
    settings: CompatibilitySettings,
    free: Sequence[str],
) -> InstrumentErrorFit:
    """Fit the errors that the instruments need to agree.

    All of `free` where that fit converges and no vane seems to stand elsewhere or instrument to be
    late; else the biases of gyros and accelerometers and, one after the other, the error that
    raises the likelihood most.

    Parameters
    ----------
    segments : sequence of CompatibilitySegment
    settings : CompatibilitySettings
    free : sequence of str
        Errors of instruments that are there.

    Returns
    -------
    InstrumentErrorFit
        Its bounds may not be corrected for color.
    """
    full = fit_instrument_errors(segments, settings, free, bounds=False)
    positions = _positions(segments)
    is_suspect = full.converged and any(_is_excessive(full, settings, name) for name in full.free)
    if full.converged and not is_suspect and not _significant_gains(full, settings, positions):
        return full
    found = _with_bounds(_add_errors(segments, settings, free, []), segments, settings)
    is_misplaced = found.converged and any(
        _is_misplaced(found, settings, name) for name in positions
    )
    if not is_misplaced or (
        full.converged and _schwarz_criterion(full) < _schwarz_criterion(found)
    ):
        return full
    return found


def find_instrument_errors(maneuvers: Sequence[Maneuver]) -> tuple[InstrumentError, ...]:
    """Return vanes that are not as the aircraft file says, and late channels: kinematics alone.

    Parameters
    ----------
    maneuvers : sequence of Maneuver
        Of one aircraft. Those with most pitching and yawing are used.

    Returns
    -------
    tuple of InstrumentError
        Those whose size is beyond chance and matters. Nothing of beta where neither aileron nor
        rudder was an input.
    """
    # What yaws an aircraft without aileron or rudder are gusts, which make sideslip of their
    # own; through bank and side force, ailerons and rudder excite pitching as well.
    hidden = all({"da", "dr"}.isdisjoint(one.inputs) for one in maneuvers)
    segments, channels = _select_excited_segments(maneuvers, "beta" if hidden else "")
    if not segments or not (positions := _positions(segments)):
        return ()
    aircraft = maneuvers[0].aircraft
    settings = scale_settings(CompatibilitySettings(), aircraft)
    free = [name for name in settings.free if name.partition(".")[0] in channels]
    delays = _delays(segments)
    vanes = [name.partition(".")[0] for name in positions]
    calibrations = [f"{name}.{kind}" for name in vanes for kind in ("bias", "scale")]
    found = _add_errors(segments, settings, free, [*positions, *calibrations])
    if not found.converged or not {*positions, *delays, *calibrations} & set(found.free):
        return ()
    final = _with_bounds(found, segments, settings)
    if not final.converged:
        return ()
    errors = [
        *(_vane_position(final, settings, name, aircraft) for name in positions),
        *(_channel_delay(final, name) for name in delays),
        *(_vane_bias(final, segments, settings, name, aircraft) for name in vanes),
        *(_vane_scale(final, name, aircraft) for name in vanes),
    ]
    return tuple(
        _with_alternatives(final, segments, settings, one) for one in errors if one is not None
    )


def _with_alternatives(
    found: InstrumentErrorFit,
    segments: Sequence[CompatibilitySegment],
    settings: CompatibilitySettings,
    error: InstrumentError,
) -> InstrumentError:
    """Return an error with those that explain the records as well in its place."""
    own = f"{error.channel}.{error.kind}"
    if error.kind == "bias":
        # A box of gyros that is tilted shows the same.
        tilt = f"a tilt of the gyros by the same angle about {_TILT_AXES[error.channel]}"
        return replace(error, alternatives=(tilt,))
    if error.kind == "scale":
        gyro = f"{_GYROS[error.channel]}.scale"
        return error if gyro in found.free else replace(error, alternatives=(gyro,))
    moved = [name for name in VANE_POSITIONS if _is_misplaced(found, settings, name)]
    shifts = [(found.errors[name], found.std(name)) for name in moved]
    together = len(shifts) == len(VANE_POSITIONS) and abs(
        shifts[0][0] - shifts[1][0]
    ) < COMPATIBILITY.significant_sigmas * np.hypot(shifts[0][1], shifts[1][1])
    # Kinematics know where vanes are from the accelerometer only.
    shared = ("an accelerometer as far the other way",) if own in moved and together else ()
    rivals = [
        name
        for name in (*_positions(segments), *_delays(segments))
        if name not in found.free and _axis(name) == _axis(own)
    ]
    sets: list[tuple[str, ...]] = [(name,) for name in rivals]
    if error.kind == "position":
        sets.append(tuple(name for name in _GYRO_BOX_DELAYS if name not in found.free))
    as_good: list[dict[str, float]] = []
    for names in sets:
        if not names or (len(names) > 1 and as_good):
            continue
        tried = fit_instrument_errors(
            segments,
            settings,
            [*(kept for kept in found.free if kept != own), *names],
            bounds=False,
            begin=found,
            iterations=COMPATIBILITY.max_iterations,
        )
        worse = tried.neg2_log_likelihood - found.neg2_log_likelihood
        if tried.converged and worse < COMPATIBILITY.min_likelihood_gain:
            sure = [
                name
                for name in names
                if abs(tried.errors[name]) > COMPATIBILITY.significant_sigmas * tried.std(name)
            ]
            values = {name: tried.errors[name] for name in sure or names}
            if _is_one_filter(list(values.values())):
                as_good.append(values)
    return replace(
        error,
        alternatives=(*shared, *(" and ".join(one) for one in as_good)),
        rivals=tuple(as_good),
    )


def _is_one_filter(delays: Sequence[float]) -> bool:
    """Return whether delays of several gyros may be that of the box which holds them."""
    least, most = min(delays, key=abs), max(delays, key=abs)
    return 0.0 <= most / least <= COMPATIBILITY.max_delay_ratio if least else False


_GYRO_BOX_DELAYS = tuple(f"{name}.delay" for name in RATE_CHANNELS)
_GYROS = {"alpha": "q", "beta": "r"}
"""What turns the aircraft in the plane of each vane."""
_TILT_AXES = {"alpha": "y", "beta": "z"}


def _axis(name: str) -> str:
    channel = name.partition(".")[0]
    return next((vane for vane, gyro in _GYROS.items() if gyro == channel), channel)


def _with_bounds(
    found: InstrumentErrorFit,
    segments: Sequence[CompatibilitySegment],
    settings: CompatibilitySettings,
) -> InstrumentErrorFit:
    """Return a fit with bounds corrected for color; the same where it did not converge."""
    if not found.converged:
        return found
    noises = [one.noise for one in found.segments]
    return fit_instrument_errors(segments, settings, found.free, noises=noises, begin=found)


def _vane_position(
    found: InstrumentErrorFit, settings: CompatibilitySettings, name: str, aircraft: Aircraft
) -> InstrumentError | None:
    """Return a vane whose distance from where it should be is sure and matters, else None."""
    if not _is_misplaced(found, settings, name):
        return None
    ahead, std = found.errors[name], found.std(name)
    channel = name.partition(".")[0]
    gyro = _GYROS[channel]
    response = max(
        float(
            np.std(one.segment.inputs[gyro] / one.prediction.path.velocity[:, 0])
            / one.segment.noise[channel]
        )
        for one in found.segments
        if channel in one.segment.noise
    )
    if (
        abs(ahead) * response < COMPATIBILITY.min_position_effect
        or abs(ahead) > COMPATIBILITY.max_position * aircraft.geometry.span
    ):
        return None
    x, y, z = getattr(aircraft.sensors, f"{channel}_vane").position
    return InstrumentError(
        channel=channel,
        kind="position",
        value=ahead,
        std=std,
        position=(x + ahead, y, z),
    )


def _channel_delay(found: InstrumentErrorFit, name: str) -> InstrumentError | None:
    """Return a channel whose delay is sure and matters, else None."""
    if name not in found.free:
        return None
    delay, std = found.errors[name], found.std(name)
    if delay < COMPATIBILITY.position_sigmas * std or at_limit(name, delay):
        return None
    channel = name.partition(".")[0]
    return InstrumentError(channel=channel, kind="delay", value=delay, std=std)


def _vane_bias(
    found: InstrumentErrorFit,
    segments: Sequence[CompatibilitySegment],
    settings: CompatibilitySettings,
    channel: str,
    aircraft: Aircraft,
) -> InstrumentError | None:
    """Return the zero of a vane if it is sure, else None.

    It shows in what rolling makes of one flow angle into the other, v' = p w. What airspeed adds,
    u' = -q w, is no proof: pitots have errors of their own that look like it.
    """
    name = f"{channel}.bias"
    if name not in found.free:
        return None
    noises = []
    for one in found.segments:
        factors = one.noise.output_factors.copy()
        if "V" in one.prediction.channels:
            factors[one.prediction.channels.index("V")] *= COMPATIBILITY.loose_airspeed_factor
        noises.append(replace(one.noise, output_factors=factors))
    alone = fit_instrument_errors(segments, settings, found.free, noises=noises, begin=found)
    bias, std = alone.errors[name], alone.std(name)
    if (
        not alone.converged
        or abs(bias) < COMPATIBILITY.position_sigmas * std
        or abs(bias) > settings.plausible_size(name)
    ):
        return None
    stated = getattr(aircraft.sensors, f"{channel}_vane").bias
    return InstrumentError(
        channel=channel, kind="bias", value=bias, std=std, file_value=stated + bias
    )


def _vane_scale(
    found: InstrumentErrorFit, channel: str, aircraft: Aircraft
) -> InstrumentError | None:
    """Return a vane that shows surely more or less than gyros in good order explain, else None."""
    name = f"{channel}.scale"
    if name not in found.free or not any(name in one.clearly_observable for one in found.segments):
        return None
    scale, std = found.errors[name], found.std(name)
    excess = abs(scale - 1.0) - TOLERABLE_ERRORS[f"{_GYROS[channel]}.scale"]
    if excess < COMPATIBILITY.position_sigmas * std or not 0.5 < scale < 2.0:
        return None
    upwash = getattr(aircraft.sensors, f"{channel}_vane").upwash
    return InstrumentError(
        channel=channel, kind="scale", value=scale, std=std, file_value=upwash * scale
    )


def _select_excited_segments(
    maneuvers: Sequence[Maneuver], hidden: str
) -> tuple[list[CompatibilitySegment], set[str]]:
    """Return the segments in which most pitching, and most yawing, is seen; in their order.

    Also the channels that any segment has, without the `hidden` one. No other segments are held:
    there may be those of a thousand flights.
    """
    channels = set[str]()
    most: dict[str, list[tuple[float, int, CompatibilitySegment]]] = {"q": [], "r": []}
    numbers = itertools.count()
    for maneuver in maneuvers:
        prepared = prepare_segments([maneuver], None)
        prepared.hide(hidden)
        channels.update(prepared.channels)
        for one in prepared.segments:
            number = next(numbers)
            for gyro, ranked in most.items():
                power = float(np.var(one.inputs[gyro]) * one.times.size * one.dt)
                heapq.heappush(ranked, (power, number, one))
                if len(ranked) > COMPATIBILITY.screening_segments // 2:
                    heapq.heappop(ranked)
    selected = {number: one for ranked in most.values() for _, number, one in ranked}
    return [selected[number] for number in sorted(selected)], channels


def _positions(segments: Sequence[CompatibilitySegment]) -> list[str]:
    measured = set[str]().union(*(one.measured for one in segments))
    return [name for name in VANE_POSITIONS if name.partition(".")[0] in measured]


def _delays(segments: Sequence[CompatibilitySegment]) -> list[str]:
    """Return the delays that look like a vane elsewhere, of channels that were measured."""
    measured = set[str]().union(*(one.measured for one in segments))
    missing = set[str]().union(*(one.absent for one in segments))
    return [
        *(f"{name}.delay" for name in ("alpha", "beta") if name in measured),
        *(f"{name}.delay" for name in ("q", "r") if name not in missing),
    ]


def _add_errors(
    segments: Sequence[CompatibilitySegment],
    settings: CompatibilitySettings,
    free: Sequence[str],
    targets: Sequence[str],
) -> InstrumentErrorFit:
    """Fit biases of what is integrated, then add errors as long as one of `targets` is asked for.

    As long as any is asked for where `targets` is empty.
    """
    biases = [f"{name}.bias" for name in KINEMATIC_INPUTS if f"{name}.bias" in free]
    found = fit_instrument_errors(
        segments, settings, biases, bounds=False, iterations=COMPATIBILITY.max_iterations
    )
    gyros = [f"{name}.scale" for name in RATE_CHANNELS if f"{name}.bias" in free]
    candidates = [*_positions(segments), *(name for name in (*free, *gyros) if name not in biases)]
    while found.converged and (asked := _significant_gains(found, settings, candidates)):
        if targets and not set(asked) & set(targets):
            break
        # Position, delay and scale of a vane, and a late gyro, look much alike: all are tried and
        # the likeliest stays, in doubt the position, which aircraft files state least often.
        channel = next(iter(asked)).partition(".")[0]
        rivals = [name for name in asked if name.partition(".")[0] == channel]
        if targets:
            rivals += [name for name in _GYRO_DELAYS.get(channel, ()) if name not in found.free]
        begins = _worthwhile_errors(found, segments, settings, rivals)
        candidates = [name for name in candidates if name not in rivals]
        tried = [
            fit_instrument_errors(
                segments,
                settings,
                [*found.free, name],
                bounds=False,
                begin=begin,
                iterations=COMPATIBILITY.max_iterations,
            )
            for name, begin in begins.items()
        ]
        possible = [one for one in tried if one.free[-1] in asked or _is_grave_delay(one)]
        best = min(
            possible,
            default=found,
            key=lambda one: (
                one.neg2_log_likelihood
                - COMPATIBILITY.min_likelihood_gain * one.free[-1].endswith(".position")
            ),
        )
        gain = found.neg2_log_likelihood - best.neg2_log_likelihood
        if best.converged and gain > COMPATIBILITY.min_likelihood_gain:
            found = best
            candidates += [name for name in asked if name in rivals and name not in best.free]
    return found


def _worthwhile_errors(
    found: InstrumentErrorFit,
    segments: Sequence[CompatibilitySegment],
    settings: CompatibilitySettings,
    rivals: Sequence[str],
) -> dict[str, InstrumentErrorFit]:
    """Return which of several errors to fit with noise of their own, each with where to begin.

    Those that, with the noise held, explain at least half of what the best of them does.
    """
    if len(rivals) == 1:
        return {rivals[0]: found}
    held = [one.noise for one in found.segments]
    tried = {
        name: fit_instrument_errors(
            segments,
            settings,
            [*found.free, name],
            noises=held,
            bounds=False,
            begin=found,
            iterations=COMPATIBILITY.trial_iterations,
        )
        for name in rivals
    }
    least = min(one.neg2_log_likelihood for one in tried.values())
    enough = 0.5 * (found.neg2_log_likelihood + least)
    return {name: one for name, one in tried.items() if one.neg2_log_likelihood <= enough}


_GYRO_DELAYS = {"alpha": ("q.delay",), "beta": ("r.delay",)}
"""What makes the vane of a channel seem out of place."""


def _is_grave_delay(found: InstrumentErrorFit) -> bool:
    """Return whether the error added last is a delay that shifts the motion by a phase.

    Small ones are everyday, and no gyro shows what is to come.
    """
    gyro = found.free[-1].partition(".")[0]
    power, change = 0.0, 0.0
    for one in found.segments:
        count = max(1, round(1.0 / (COMPATIBILITY.motion_rate * one.segment.dt)))
        rates = one.segment.inputs[gyro]
        means = rates[: rates.size // count * count].reshape(-1, count).mean(axis=1)
        power += float(np.var(means)) * means.size
        change += float(np.sum(np.diff(means) ** 2)) / (count * one.segment.dt) ** 2
    phase = found.errors[found.free[-1]] * np.sqrt(change / max(power, 1e-300))
    return bool(found.converged and phase > COMPATIBILITY.min_delay_phase)


def _is_misplaced(found: InstrumentErrorFit, settings: CompatibilitySettings, name: str) -> bool:
    """Return whether a vane is surely not where the aircraft file puts it."""
    if name not in found.free:
        return False
    excess = abs(found.errors[name]) - settings.tolerable_size(name)
    return excess > COMPATIBILITY.position_sigmas * found.std(name)


def _is_excessive(found: InstrumentErrorFit, settings: CompatibilitySettings, name: str) -> bool:
    """Return whether a scale or a delay of a vane, which a position looks like, is beyond doubt."""
    channel, _, kind = name.partition(".")
    if channel not in ("alpha", "beta") or kind == "bias":
        return False
    excess = abs(found.errors[name] - nominal_value(name)) - settings.tolerable_size(name)
    return excess > COMPATIBILITY.significant_sigmas * found.std(name)


def _significant_gains(
    found: InstrumentErrorFit, settings: CompatibilitySettings, names: Sequence[str]
) -> dict[str, float]:
    """Return the errors that would make the fit far likelier, with their gains, the best first."""
    gains = likelihood_gains(found, settings, names) if names else {}
    order = sorted(names, key=lambda name: -gains[name])
    return {name: gains[name] for name in order if gains[name] > COMPATIBILITY.min_likelihood_gain}


def _schwarz_criterion(found: InstrumentErrorFit) -> float:
    """Return Schwarz's criterion: twice the negative log-likelihood, parameters counted."""
    count = sum(len(one.innovations) for one in found.segments)
    return found.neg2_log_likelihood + len(found.free) * log(max(count, 2))
