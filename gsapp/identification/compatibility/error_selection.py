"""Which errors of instruments a fit needs: all the usual ones, or those that residuals ask for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import log, sqrt

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.identification.compatibility.instrument_error_fit import (
    InstrumentErrorFit,
    fit_instrument_errors,
    likelihood_gains,
)
from gsapp.identification.compatibility.instrument_text import format_error_with_bound
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


def settings_for(settings: CompatibilitySettings, aircraft: Aircraft) -> CompatibilitySettings:
    """Return settings in which positions of vanes are plausible for the size of an aircraft."""
    span = aircraft.geometry.span
    likely = dict.fromkeys(VANE_POSITIONS, COMPATIBILITY.plausible_position * span)
    everyday = dict.fromkeys(VANE_POSITIONS, COMPATIBILITY.tolerable_position * span)
    return replace(
        settings,
        plausible={**likely, **settings.plausible},
        tolerable={**everyday, **settings.tolerable},
    )


def select_errors(
    stretches: Sequence[CompatibilitySegment],
    settings: CompatibilitySettings,
    free: Sequence[str],
) -> InstrumentErrorFit:
    """Fit the errors that the instruments need to agree.

    All of `free` where that fit converges and no vane asks for another position; else the biases
    of gyros and accelerometers and, one after the other, the error that raises the likelihood most.

    Parameters
    ----------
    stretches : sequence of CompatibilitySegment
    settings : CompatibilitySettings
    free : sequence of str
        Errors of instruments that are there.

    Returns
    -------
    InstrumentErrorFit
        Without bounds corrected for color.
    """
    full = fit_instrument_errors(stretches, settings, free, bounds=False)
    positions = _positions(stretches)
    if full.converged and not _asked_for(full, settings, positions):
        return full
    found = _add_errors(stretches, settings, free, [])
    if not found.converged or (full.converged and _criterion(full) < _criterion(found)):
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
    """

    channel: str
    ahead: float
    std: float
    position: Position

    @property
    def toml(self) -> str:
        """Return its position as the aircraft file gives it."""
        return "[" + ", ".join(f'"{one:.4g} m"' for one in self.position) + "]"

    @property
    def text(self) -> str:
        """Return it as a sentence."""
        value, std = format_error_with_bound(f"{self.channel}.position", abs(self.ahead), self.std)
        side = "ahead of" if self.ahead > 0.0 else "behind"
        return (
            f"the {self.channel} vane appears to be {value} \N{PLUS-MINUS SIGN} {std} {side} its "
            "position in the aircraft file, and is used there; to confirm it, write under "
            f"[sensors.{self.channel}_vane] position = {self.toml}"
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
    stretches = _liveliest(prepared.segments)
    if not stretches or not (positions := _positions(stretches)):
        return ()
    settings = settings_for(CompatibilitySettings(), maneuvers[0].aircraft)
    free = [name for name in settings.free if name.partition(".")[0] in prepared.channels]
    found = _add_errors(stretches, settings, free, positions)
    if not found.converged or not set(positions) & set(found.free):
        return ()
    final = fit_instrument_errors(
        stretches, settings, found.free, noises=[one.noise for one in found.segments], begin=found
    )
    aircraft = maneuvers[0].aircraft
    return tuple(
        placed
        for name in positions
        if final.converged and (placed := _placed(final, settings, name, aircraft)) is not None
    )


def at_found_positions(maneuver: Maneuver, vanes: Sequence[VanePosition]) -> Maneuver:
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


def _placed(
    found: InstrumentErrorFit, settings: CompatibilitySettings, name: str, aircraft: Aircraft
) -> VanePosition | None:
    """Return a vane whose distance from where it should be is sure and matters, else None."""
    if name not in found.free:
        return None
    place = found.free.index(name)
    ahead, std = found.errors[name], sqrt(max(float(found.covariance[place, place]), 0.0))
    channel = name.partition(".")[0]
    gyro = {"alpha": "q", "beta": "r"}[channel]
    seen = max(
        float(
            np.std(one.segment.inputs[gyro] / one.prediction.path.velocity[:, 0])
            / one.segment.noise[channel]
        )
        for one in found.segments
        if channel in one.segment.noise
    )
    if (
        abs(ahead) < settings.tolerable_size(name) + COMPATIBILITY.significant_sigmas * std
        or abs(ahead) * seen < COMPATIBILITY.min_position_effect
    ):
        return None
    x, y, z = getattr(aircraft.sensors, f"{channel}_vane").position
    return VanePosition(channel=channel, ahead=ahead, std=std, position=(x + ahead, y, z))


def _liveliest(stretches: Sequence[CompatibilitySegment]) -> list[CompatibilitySegment]:
    """Return the stretches in which most pitching, and most yawing, is seen; in their order."""
    kept = set[int]()
    for gyro in ("q", "r"):
        power = [float(np.var(one.inputs[gyro]) * one.times.size * one.dt) for one in stretches]
        kept.update(np.argsort(power)[-COMPATIBILITY.screening_segments // 2 :].tolist())
    return [stretches[place] for place in sorted(kept)]


def _positions(stretches: Sequence[CompatibilitySegment]) -> list[str]:
    shown = set[str]().union(*(one.measured for one in stretches))
    return [name for name in VANE_POSITIONS if name.partition(".")[0] in shown]


def _add_errors(
    stretches: Sequence[CompatibilitySegment],
    settings: CompatibilitySettings,
    free: Sequence[str],
    until: Sequence[str],
) -> InstrumentErrorFit:
    """Fit biases of what is integrated, then add errors as long as one of `until` is asked for.

    As long as any is asked for where `until` is empty.
    """
    biases = [f"{name}.bias" for name in KINEMATIC_INPUTS if f"{name}.bias" in free]
    found = fit_instrument_errors(
        stretches, settings, biases, bounds=False, iterations=COMPATIBILITY.max_iterations
    )
    gyros = [f"{name}.scale" for name in RATE_CHANNELS if f"{name}.bias" in free]
    rest = [*_positions(stretches), *(name for name in (*free, *gyros) if name not in biases)]
    while found.converged and (asked := _asked_for(found, settings, rest)):
        if until and not set(asked) & set(until):
            break
        rest.remove(asked[0])
        tried = fit_instrument_errors(
            stretches,
            settings,
            [*found.free, asked[0]],
            bounds=False,
            begin=found,
            iterations=COMPATIBILITY.max_iterations,
        )
        gain = found.neg2_log_likelihood - tried.neg2_log_likelihood
        if tried.converged and gain > COMPATIBILITY.min_likelihood_gain:
            found = tried
    return found


def _asked_for(
    found: InstrumentErrorFit, settings: CompatibilitySettings, names: Sequence[str]
) -> list[str]:
    """Return the errors that would make the fit far likelier, the best first."""
    gains = likelihood_gains(found, settings, names) if names else {}
    asked = [name for name in names if gains[name] > COMPATIBILITY.min_likelihood_gain]
    return sorted(asked, key=lambda name: -gains[name])


def _criterion(found: InstrumentErrorFit) -> float:
    """Return Schwarz's criterion: twice the negative log-likelihood, parameters counted."""
    count = sum(len(one.innovations) for one in found.segments)
    return found.neg2_log_likelihood + len(found.free) * log(max(count, 2))
