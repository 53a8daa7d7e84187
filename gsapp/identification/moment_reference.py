r"""Moments about the aircraft file's CG, from flights that had theirs elsewhere.

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
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from gsapp.aircraft import Geometry
from gsapp.dynamics.model import Model
from gsapp.foundation import FlightError
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.preparation_settings import PREPARATION
from gsapp.identification.results import DerivativeEstimate, Estimate
from gsapp.quantities.fields import Position

NO_CG_SHIFT: Final[Position] = (0.0, 0.0, 0.0)


def common_cg_shift(maneuvers: Sequence[Maneuver]) -> Position:
    """Return where the CG of some maneuvers lies from the aircraft file's, m.

    Raises
    ------
    FlightError
        If they were flown with CGs so far apart that one fit has no one reference.
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
