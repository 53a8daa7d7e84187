r"""What an estimate takes from beside its maneuver: missing channels, another CG, zeros.

The source's flight B had lost airspeed and angle of attack, and was analyzed with averages of the
other flights. A constant is wrong by as much as other maneuvers differ; what that does to each
derivative is found by fitting again with the constant moved by that much, and goes into the bounds.

A fit balances moments about the CG as flown; models and the means of a campaign are about that of
the aircraft file. With :math:`s = (x, y, z)` from the file's CG to the one flown the moment about
the file's is :math:`M + s \times F`, which for each regressor :math:`k` of the build-up reads

.. math::
    C_{m,k} + \frac{x}{\bar c} C_{N,k} - \frac{z}{\bar c} C_{A,k}, \quad
    C_{l,k} - \frac{z}{b} C_{Y,k}, \quad
    C_{n,k} + \frac{x}{b} C_{Y,k}.

This is linear in the derivatives, so an estimate and its covariance are carried over exactly. A CG
off the plane of symmetry (y) adds asymmetric terms that the build-up has only as constants: they
stay in ``Cl_0`` and ``Cn_0``.

However long a record is, no mean of a force tells the zero of its accelerometer from CN_0, CA_0 and
CY_0. The same instrument flies in every maneuver, so this part of a bound does not shrink with
their number.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from gsapp.aircraft import Geometry
from gsapp.dynamics.model import Model
from gsapp.foundation import FlightError
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.preparation_settings import PREPARATION
from gsapp.identification.results import DerivativeEstimate, Estimate
from gsapp.quantities import FloatArray, name_in_text
from gsapp.quantities.constants import DEGREE
from gsapp.quantities.fields import Position


@dataclass(frozen=True, slots=True, kw_only=True)
class AssumedConstant:
    """A constant and how wrong it may be, SI."""

    value: float
    std: float


def campaign_assumed_constants(maneuvers: Sequence[Maneuver]) -> dict[str, AssumedConstant]:
    """Return what stands in for airspeed (m/s) and angle of attack (rad) where they are missing.

    `maneuvers`: of a campaign: means and spread over those that measured them; where none did, what
    the aircraft file suggests, cruise speed and the middle of the linear range.
    """
    if not maneuvers:
        return {}
    limits = maneuvers[0].aircraft.limits
    low, high = limits.alpha_linear
    cruise = PREPARATION.cruise_speed_ratio * limits.stall_speed
    guessed = {
        "V": AssumedConstant(value=cruise, std=PREPARATION.speed_spread * cruise),
        "alpha": AssumedConstant(value=0.5 * (low + high), std=0.25 * (high - low)),
    }
    found = {}
    for name, guess in guessed.items():
        flown = [value for one in maneuvers if (value := _trim_mean(one, name)) is not None]
        if flown:
            found[name] = _mean_over_maneuvers(np.array(flown), guess.std)
        elif guess.std > 0.0:
            found[name] = guess
    return found


def _mean_over_maneuvers(flown: FloatArray, guess: float) -> AssumedConstant:
    """Return what another maneuver was flown at: the mean, as uncertain as they scatter."""
    center = float(flown.mean())
    squares = float(np.sum((flown - center) ** 2)) + PREPARATION.spread_prior_weight * guess**2
    variance = (
        squares / (PREPARATION.spread_prior_weight + flown.size - 1) * (1.0 + 1.0 / flown.size)
    )
    return AssumedConstant(value=center, std=float(np.sqrt(variance)))


def _trim_mean(maneuver: Maneuver, name: str) -> float | None:
    if not maneuver.has(name):
        return None
    early = maneuver.samples(name)[
        maneuver.block.times <= maneuver.t_start + PREPARATION.trim_duration
    ]
    early = early[np.isfinite(early)]
    return float(early.mean()) if early.size else None


def required_constants(
    maneuvers: Sequence[Maneuver], known: Mapping[str, AssumedConstant], given: Mapping[str, float]
) -> dict[str, AssumedConstant]:
    """Return which of the stand-ins some maneuver needs; a constant given by the user comes first.

    `maneuvers`: fitted together.
    `given`: by the user, who answers for them.
    """
    return {
        name: one
        for name, one in known.items()
        if name not in given and any(not maneuver.has(name) for maneuver in maneuvers)
    }


def _std_text(name: str, one: AssumedConstant) -> str:
    return f"{one.std:.1f} m/s" if name == "V" else f"{one.std / DEGREE:.1f} deg"


def estimate_with_constants(
    estimate: Callable[[Mapping[str, float]], Estimate], assumed: Mapping[str, AssumedConstant]
) -> Estimate:
    """Return an estimate whose bounds allow for the error of assumed constants.

    `estimate`: with these constants in the place of what was not measured, SI.
    """
    values = {name: one.value for name, one in assumed.items()}
    found = estimate(values)
    if not assumed or not found.converged:
        return found
    moved = []
    for name, one in assumed.items():
        for value in (one.value + one.std, one.value - one.std):
            changed = estimate({**values, name: value})
            if changed.converged:
                break
        moved.append(changed)
    return widen_bounds(found, moved, assumed)


def widen_bounds(
    found: Estimate, moved: Sequence[Estimate], assumed: Mapping[str, AssumedConstant]
) -> Estimate:
    """Return an estimate with the squares of what each change made of it added to its bounds.

    `moved`: with each of the constants in `assumed` moved by its deviation.
    """
    covariance = np.array(found.covariance)
    derivatives = dict(found.derivatives)
    kept = []
    for place, name in enumerate(found.free):
        values = [one.value(name) for one in moved]
        if any(value is None for value in values):
            derivatives[name] = DerivativeEstimate(
                value=None,
                status="unknown",
                why="not estimable with another value of the substituted channel",
            )
        else:
            kept.append(place)
    names = [found.free[place] for place in kept]
    covariance = covariance[np.ix_(kept, kept)]
    for one in moved:
        change = np.array([(one.value(name) or 0.0) - (found.value(name) or 0.0) for name in names])
        covariance += np.outer(change, change)
    for place, name in enumerate(names):
        derivatives[name] = replace(derivatives[name], std=float(np.sqrt(covariance[place, place])))
    said = (
        f"the bounds allow for {_std_text(name, one)} of error in the {name_in_text(name)} used "
        "instead"
        for name, one in assumed.items()
    )
    return replace(
        found,
        derivatives=derivatives,
        free=tuple(names),
        covariance=covariance,
        warnings=(*found.warnings, *said),
    )


NO_CG_SHIFT: Final[Position] = (0.0, 0.0, 0.0)


def common_cg_shift(maneuvers: Sequence[Maneuver]) -> Position:
    """Return where the CG of some maneuvers lies from the aircraft file's, m.

    Raises `FlightError` if they were flown with CGs so far apart that one fit has no one reference.
    """
    shifts = np.array([one.cg_shift for one in maneuvers])
    apart = float(np.ptp(shifts[:, ::2], axis=0).max())
    if apart > PREPARATION.cg_tolerance:
        raise FlightError(
            f"the maneuvers were flown with CGs {1e3 * apart:.0f} mm apart, but a joint fit has "
            "one moment reference; fit them separately"
        )
    x, y, z = shifts.mean(axis=0).tolist()
    return x, y, z


def derivatives_about_flown_cg(
    derivatives: Mapping[str, float],
    shift: Position,
    geometry: Geometry,
    others: Mapping[str, float] | None = None,
) -> dict[str, float]:
    """Return derivatives that are about the file's CG as they are about the one flown.

    Parameters
    ----------
    derivatives : mapping of str to float
        Names outside the build-up are passed on.
    shift : tuple of float
        From the file's CG to the one flown, m.
    others : mapping of str to float, optional
        Force derivatives that are known though not among `derivatives`. One that is known
        nowhere counts as zero.
    """
    known = {**(others or {}), **derivatives}
    return {
        name: value
        - sum(
            share * known.get(force, 0.0)
            for force, share in _force_contributions(name, shift, geometry)
        )
        for name, value in derivatives.items()
    }


def model_about_flown_cg(model: Model, shift: Position, geometry: Geometry) -> Model:
    """Return a model as it is about the CG flown."""
    return model.with_derivatives(derivatives_about_flown_cg(model.derivatives, shift, geometry))


def estimate_about_file_cg(estimate: Estimate, shift: Position, geometry: Geometry) -> Estimate:
    """Return an estimate with its moments about the file's CG.

    Values and covariance are carried over exactly, uncorrected bounds in the same ratio. A
    moment derivative whose force derivative was not earned stays about the CG flown, and the
    estimate says so.
    """
    if not any(_force_contributions(name, shift, geometry) for name in estimate.derivatives):
        return estimate
    free = estimate.free
    matrix = np.eye(len(free))
    derivatives = dict(estimate.derivatives)
    left: list[str] = []
    for name, one in estimate.derivatives.items():
        forces = _force_contributions(name, shift, geometry)
        if one.value is None or not forces:
            continue
        values = [estimate.value(force) for force, _ in forces]
        if any(value is None for value in values):
            left.append(name)
            continue
        moved = sum(
            share * (value or 0.0) for (_, share), value in zip(forces, values, strict=True)
        )
        derivatives[name] = replace(one, value=one.value + moved)
        for force, share in forces:
            if name in free and force in free:
                matrix[free.index(name), free.index(force)] = share
    covariance = matrix @ estimate.covariance @ matrix.T
    for row, name in enumerate(free):
        if name in derivatives:
            derivatives[name] = _with_bound(derivatives[name], float(covariance[row, row]))
    warnings = estimate.warnings
    if left:
        warnings = (
            *warnings,
            f"{', '.join(left)} are about the CG as flown: the forces needed to transfer them "
            "were not estimated",
        )
    return replace(estimate, derivatives=derivatives, covariance=covariance, warnings=warnings)


def _force_contributions(
    name: str, shift: Position, geometry: Geometry
) -> tuple[tuple[str, float], ...]:
    """Return what a moment derivative takes from each force derivative of its regressor."""
    return tuple(_force_factors(name, shift, geometry))


def _force_factors(name: str, shift: Position, geometry: Geometry) -> Iterator[tuple[str, float]]:
    coefficient, _, regressor = name.partition("_")
    x, _, z = shift
    by_force = {
        "Cm": (("CN", x / geometry.chord), ("CA", -z / geometry.chord)),
        "Cl": (("CY", -z / geometry.span),),
        "Cn": (("CY", x / geometry.span),),
    }
    for force, share in by_force.get(coefficient, ()):
        if share:
            yield f"{force}_{regressor}", share


def _with_bound(one: DerivativeEstimate, variance: float) -> DerivativeEstimate:
    if one.std is None or one.std <= 0.0:
        return one
    std = math.sqrt(variance)
    raw = None if one.cramer_rao is None else one.cramer_rao * std / one.std
    return replace(one, std=std, cramer_rao=raw)


_CONSTANT_TERMS: Final = ("CN_0", "CA_0", "CY_0")


def constant_term_offsets(
    maneuvers: Sequence[Maneuver],
    qbars: Sequence[FloatArray],
    zero: float = PREPARATION.accelerometer_offset,
) -> dict[str, float]:
    """Return what zeros leave open in the constants, by name.

    `qbars`, shape (n,): dynamic pressure in each of them, Pa.
    `zero`: uncertain acceleration along each force, m/s^2.
    """
    # The same instrument flew in all of them: a mean is no better.
    per_acceleration = float(
        np.mean(
            [
                one.mass / (one.aircraft.geometry.wing_area * float(np.mean(qbar)))
                for one, qbar in zip(maneuvers, qbars, strict=True)
            ]
        )
    )
    return dict.fromkeys(_CONSTANT_TERMS, zero * per_acceleration)


def add_offset_uncertainty(estimate: Estimate, offsets: Mapping[str, float]) -> Estimate:
    """Return an estimate whose bounds of constants include `constant_term_offsets`."""
    derivatives, covariance = dict(estimate.derivatives), np.array(estimate.covariance)
    for name, offset in offsets.items():
        if name not in estimate.free:
            continue
        index = estimate.free.index(name)
        covariance[index, index] += offset**2
        derivatives[name] = replace(
            derivatives[name], std=float(np.sqrt(covariance[index, index])), offset=offset
        )
    return replace(estimate, derivatives=derivatives, covariance=covariance)
