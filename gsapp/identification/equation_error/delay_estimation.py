"""How late vanes and surfaces come against the gyros.

A filter before the converter on all channels but the rates (notes, section 2), or a servo taken
for its surface, shifts one side of the moment equations in time. Half a sample at 100 Hz bends
damping and control derivatives by 5 to 8 %, far beyond their bounds, and the fit looks perfect.
The shift itself is seen well: to first order it adds tau (sum of slope times rate of the
regressor), one more column.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from gsapp.dynamics.buildup import linear_variables
from gsapp.identification.axes import Axis
from gsapp.identification.coefficients import Coefficients
from gsapp.identification.equation_error.equations import CoefficientCache, build_equation
from gsapp.identification.equation_error.regression import Equation, ManeuverRows, solve_equation
from gsapp.quantities import FloatArray

DELAYED_CHANNELS = ("V", "alpha", "beta", "de", "da", "dr", "ax", "ay", "an")
"""Channels that pass the filter; p, q, r do not."""
_MOMENTS: Mapping[Axis, tuple[str, ...]] = {
    "lon": ("Cm",),
    "lat": ("Cl", "Cn"),
    "both": ("Cm", "Cl", "Cn"),
}


def estimate_relative_delay(
    found: Sequence[Coefficients], axis: Axis, inputs: Sequence[str]
) -> tuple[float, float] | None:
    """Return how late vanes and surfaces come against the gyros, s, and its bound.

    `found`: of the maneuvers, smoothed alike, with the delays known so far undone.
    `inputs`: surfaces that were moved.

    Returns
    -------
    tuple of float, or None
        Mean over the moments of the axis, by inverse variance. None where no moment tells.
    """
    shifts = []
    for coefficient in _MOMENTS[axis]:
        names = [
            f"{coefficient}_{suffix}"
            for suffix in ("0", *linear_variables(coefficient))
            if suffix not in ("de", "da", "dr") or suffix in inputs
        ]
        equation = build_equation(coefficient, names, {}, found, CoefficientCache()).equation
        if equation is not None:
            shifts.append(_estimate_shift(equation))
    shifts = [(value, std) for value, std in shifts if np.isfinite(std) and std > 0.0]
    if not shifts:
        return None
    weights = np.array([1.0 / std**2 for _, std in shifts])
    values = np.array([value for value, _ in shifts])
    mean = float(weights @ values / weights.sum())
    # Moments that disagree know less than each claims.
    spread = float(weights @ (values - mean) ** 2) / max(len(shifts) - 1, 1)
    return mean, float(np.sqrt(max(1.0, spread) / weights.sum()))


def _estimate_shift(equation: Equation) -> tuple[float, float]:
    """Return the shift and its bound from one equation."""
    late = [
        index
        for index, name in enumerate(equation.names)
        if name.partition("_")[2] in ("alpha", "beta", "de", "da", "dr")
    ]
    theta = solve_equation(equation).values
    for _ in range(2):
        columns = [
            _differentiate_columns(matrix[:, late], equation.maneuver_rows, equation.dt)
            @ theta[late]
            for matrix in (equation.X, equation.Z)
        ]
        width = len(equation.names)
        wider = replace(
            equation,
            X=np.column_stack((equation.X, columns[0])),
            Z=np.column_stack((equation.Z, columns[1])),
            names=(*equation.names, "shift"),
            noise=np.pad(equation.noise, (0, 1)),
        )
        try:
            solution = solve_equation(wider)
        except np.linalg.LinAlgError:
            return 0.0, np.inf
        theta = solution.values[:width]
    return float(solution.values[-1]), float(solution.std[-1])


def _differentiate_columns(
    columns: FloatArray, stretches: Sequence[ManeuverRows], dt: float
) -> FloatArray:
    """Return the derivatives of smoothed columns, stretch by stretch."""
    out = np.zeros_like(columns)
    for stretch in stretches:
        own = columns[stretch.rows]
        for part in stretch.segments:
            if part.stop - part.start > 2:
                out[stretch.rows][part] = np.gradient(own[part], dt, axis=0, edge_order=2)
    return out
