"""Which errors of instruments a fit needs: all the usual ones, or those that residuals ask for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import log

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.identification.compatibility.instrument_error_fit import (
    InstrumentErrorFit,
    at_limit,
    fit_instrument_errors,
    likelihood_gains,
    nominal_value,
)
from gsapp.identification.compatibility.results import format_error_with_bound
from gsapp.identification.compatibility.segments import CompatibilitySegment, prepare_segments
from gsapp.identification.compatibility.settings import (
    COMPATIBILITY,
    KINEMATIC_INPUTS,
    RATE_CHANNELS,
    VANE_POSITIONS,
    CompatibilitySettings,
)
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.record_preparation import advance_channels, advance_flags
from gsapp.quantities.fields import Position


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


@dataclass(frozen=True, slots=True, kw_only=True)
class InstrumentError:
    """An instrument that is not as the aircraft file says, by kinematics alone.

    Attributes
    ----------
    channel : str
    kind : {"position", "delay"}
    value, std : float
        Distance of a vane ahead of its position in the aircraft file, m; delay, s.
    position : tuple of float or None
        Of a vane, from the CG of the aircraft file, m.
    alternatives : tuple of str
        Names of errors that explain the records as well, as ``q.delay``.
    """

    channel: str
    kind: str
    value: float
    std: float
    position: Position | None = None
    alternatives: tuple[str, ...] = ()

    @property
    def text(self) -> str:
        """Return it as a sentence."""
        name = f"{self.channel}.{self.kind}"
        value, std = format_error_with_bound(name, abs(self.value), self.std)
        doubt = ""
        if self.alternatives:
            doubt = f" (these maneuvers do not rule out {' or '.join(self.alternatives)} instead)"
        if self.position is None:
            return (
                f"{self.channel} appears to be {value} \N{PLUS-MINUS SIGN} {std} late{doubt}, and "
                "is used at its right time: state its lag or delay in the aircraft file"
            )
        side = "ahead of" if self.value > 0.0 else "behind"
        return (
            f"the {self.channel} vane appears to be {value} \N{PLUS-MINUS SIGN} {std} {side} its "
            f"position in the aircraft file{doubt}, and is used there: correct "
            f"sensors.{self.channel}_vane.position to x = {self.position[0]:.4g} m"
        )


def find_instrument_errors(maneuvers: Sequence[Maneuver]) -> tuple[InstrumentError, ...]:
    """Return vanes that stand elsewhere, and channels that are late: kinematics alone.

    Parameters
    ----------
    maneuvers : sequence of Maneuver
        Of one aircraft. Those with most pitching and yawing are used.

    Returns
    -------
    tuple of InstrumentError
        Those whose size is beyond chance and matters.
    """
    prepared = prepare_segments(maneuvers, None)
    segments = _select_excited_segments(prepared.segments)
    if not segments or not (positions := _positions(segments)):
        return ()
    aircraft = maneuvers[0].aircraft
    settings = scale_settings(CompatibilitySettings(), aircraft)
    free = [name for name in settings.free if name.partition(".")[0] in prepared.channels]
    delays = _delays(segments)
    found = _add_errors(segments, settings, free, positions)
    if not found.converged or not {*positions, *delays} & set(found.free):
        return ()
    final = _with_bounds(found, segments, settings)
    if not final.converged:
        return ()
    errors = [
        *(_vane_position(final, settings, name, aircraft) for name in positions),
        *(_channel_delay(final, name) for name in delays),
    ]
    return tuple(
        replace(one, alternatives=_alternatives(found, segments, settings, one))
        for one in errors
        if one is not None
    )


def correct_instruments(maneuver: Maneuver, errors: Sequence[InstrumentError]) -> Maneuver:
    """Return a maneuver with its vanes where they were found and its channels on time."""
    if not errors:
        return maneuver
    sensors = maneuver.aircraft.sensors
    delays = {one.channel: one.value for one in errors if one.kind == "delay"}
    clipped = {
        name: advance_flags(flags, delays[name] / maneuver.dt) if name in delays else flags
        for name, flags in maneuver.clipped.items()
    }
    for one in errors:
        if one.kind == "delay":
            continue
        name = f"{one.channel}_vane"
        vane = getattr(sensors, name)
        x, y, z = vane.position
        moved = vane.model_copy(update={"position": (x + one.value, y, z)})
        sensors = sensors.model_copy(update={name: moved})
    aircraft = maneuver.aircraft.model_copy(update={"sensors": sensors})
    block = advance_channels(maneuver.block, delays)
    return replace(maneuver, aircraft=aircraft, block=block, clipped=clipped)


def _alternatives(
    found: InstrumentErrorFit,
    segments: Sequence[CompatibilitySegment],
    settings: CompatibilitySettings,
    error: InstrumentError,
) -> tuple[str, ...]:
    """Return the errors that explain the records as well in the place of one."""
    own = f"{error.channel}.{error.kind}"
    rivals = [
        name
        for name in (*_positions(segments), *_delays(segments))
        if name not in found.free and _axis(name) == _axis(own)
    ]
    as_good = []
    for name in rivals:
        tried = fit_instrument_errors(
            segments,
            settings,
            [kept for kept in found.free if kept != own] + [name],
            bounds=False,
            begin=found,
            iterations=COMPATIBILITY.max_iterations,
        )
        worse = tried.neg2_log_likelihood - found.neg2_log_likelihood
        if tried.converged and worse < COMPATIBILITY.min_likelihood_gain:
            as_good.append(name)
    return tuple(as_good)


def _axis(name: str) -> str:
    channel = name.partition(".")[0]
    return {"q": "alpha", "r": "beta"}.get(channel, channel)


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
    gyro = {"alpha": "q", "beta": "r"}[channel]
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
        channel=channel, kind="position", value=ahead, std=std, position=(x + ahead, y, z)
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


def _select_excited_segments(
    segments: Sequence[CompatibilitySegment],
) -> list[CompatibilitySegment]:
    """Return the segments in which most pitching, and most yawing, is seen; in their order."""
    selected = set[int]()
    for gyro in ("q", "r"):
        power = [float(np.var(one.inputs[gyro]) * one.times.size * one.dt) for one in segments]
        selected.update(np.argsort(power)[-COMPATIBILITY.screening_segments // 2 :].tolist())
    return [segments[index] for index in sorted(selected)]


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
        tried = [
            fit_instrument_errors(
                segments,
                settings,
                [*found.free, name],
                bounds=False,
                begin=found,
                iterations=COMPATIBILITY.max_iterations,
            )
            for name in rivals
        ]
        candidates = [name for name in candidates if name not in rivals]
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
