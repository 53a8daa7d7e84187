"""Which errors of instruments a fit needs: all the usual ones, or those that residuals ask for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import log

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.identification.compatibility.instrument_error_fit import (
    InstrumentErrorFit,
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

    All of `free` where that fit converges and no vane seems to stand elsewhere; else the biases
    of gyros and accelerometers and, one after the other, the error that raises the likelihood most.

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
class VanePosition:
    """A vane that is not where the aircraft file puts it.

    Attributes
    ----------
    channel : {"alpha", "beta"}
    ahead, std : float
        Distance ahead of its position in the aircraft file, m.
    position : tuple of float
        From the CG of the aircraft file, m.
    delay : float or None
        The delay (s) with which the vane at its old position would do as well.
    """

    channel: str
    ahead: float
    std: float
    position: Position
    delay: float | None = None

    @property
    def text(self) -> str:
        """Return it as a sentence."""
        value, std = format_error_with_bound(f"{self.channel}.position", abs(self.ahead), self.std)
        side = "ahead of" if self.ahead > 0.0 else "behind"
        doubt = ""
        if self.delay is not None:
            doubt = (
                f" (or {self.channel} is {1e3 * abs(self.delay):.0f} ms "
                f"{'late' if self.delay > 0.0 else 'early'}: these maneuvers do not tell which)"
            )
        return (
            f"the {self.channel} vane appears to be {value} \N{PLUS-MINUS SIGN} {std} {side} its "
            f"position in the aircraft file{doubt}, and is used there: correct "
            f"sensors.{self.channel}_vane.position to x = {self.position[0]:.4g} m"
        )


def find_vane_positions(maneuvers: Sequence[Maneuver]) -> tuple[VanePosition, ...]:
    """Return the vanes that stand elsewhere than the aircraft file says: kinematics alone.

    Parameters
    ----------
    maneuvers : sequence of Maneuver
        Of one aircraft. Those with most pitching and yawing are used.

    Returns
    -------
    tuple of VanePosition
        Those whose distance is beyond chance and matters.
    """
    prepared = prepare_segments(maneuvers, None)
    segments = _select_excited_segments(prepared.segments)
    if not segments or not (positions := _positions(segments)):
        return ()
    settings = scale_settings(CompatibilitySettings(), maneuvers[0].aircraft)
    free = [name for name in settings.free if name.partition(".")[0] in prepared.channels]
    found = _add_errors(segments, settings, free, positions)
    if not found.converged or not set(positions) & set(found.free):
        return ()
    final = _with_bounds(found, segments, settings)
    return tuple(
        replace(vane, delay=_find_equivalent_delay(final, segments, settings, name))
        for name in positions
        if final.converged
        and (vane := _vane_position(final, settings, name, maneuvers[0].aircraft)) is not None
    )


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


def _find_equivalent_delay(
    found: InstrumentErrorFit,
    segments: Sequence[CompatibilitySegment],
    settings: CompatibilitySettings,
    position: str,
) -> float | None:
    """Return the delay (s) that explains a vane as well as its position does; None where none."""
    delay = position.replace(".position", ".delay")
    if delay in found.free:
        return None
    tried = fit_instrument_errors(
        segments,
        settings,
        [name for name in found.free if name != position] + [delay],
        noises=[one.noise for one in found.segments],
        bounds=False,
        begin=found,
        iterations=COMPATIBILITY.max_iterations,
    )
    worse = tried.neg2_log_likelihood - found.neg2_log_likelihood
    if not tried.converged or worse > COMPATIBILITY.min_likelihood_gain:
        return None
    return tried.errors[delay]


def with_vane_positions(maneuver: Maneuver, vanes: Sequence[VanePosition]) -> Maneuver:
    """Return a maneuver whose aircraft has its vanes where they were found."""
    if not vanes:
        return maneuver
    sensors = maneuver.aircraft.sensors
    for one in vanes:
        name = f"{one.channel}_vane"
        vane = getattr(sensors, name)
        x, y, z = vane.position
        moved = vane.model_copy(update={"position": (x + one.ahead, y, z)})
        sensors = sensors.model_copy(update={name: moved})
    return replace(maneuver, aircraft=maneuver.aircraft.model_copy(update={"sensors": sensors}))


def _vane_position(
    found: InstrumentErrorFit, settings: CompatibilitySettings, name: str, aircraft: Aircraft
) -> VanePosition | None:
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
    return VanePosition(channel=channel, ahead=ahead, std=std, position=(x + ahead, y, z))


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
    while found.converged and (significant := _significant_gains(found, settings, candidates)):
        if targets and not set(significant) & set(targets):
            break
        # Position, delay and scale of a vane look much alike: all are tried, the likeliest stays,
        # in doubt one of `targets`.
        channel = next(iter(significant)).partition(".")[0]
        rivals = [name for name in significant if name.partition(".")[0] == channel]
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
        best = min(
            tried,
            key=lambda one: (
                one.neg2_log_likelihood
                - COMPATIBILITY.min_likelihood_gain * (one.free[-1] in targets)
            ),
        )
        gain = found.neg2_log_likelihood - best.neg2_log_likelihood
        if best.converged and gain > COMPATIBILITY.min_likelihood_gain:
            found = best
            candidates += [name for name in rivals if name not in best.free]
    return found


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
