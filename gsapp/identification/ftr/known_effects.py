"""What the effects of a model are known to give, taken out of the regressions' targets."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from gsapp.dynamics.model import Model
from gsapp.dynamics.terms import COEFFICIENTS as ALL
from gsapp.identification.axes import AXIS_COEFFICIENTS
from gsapp.identification.coefficients import reconstruct_coefficients
from gsapp.identification.ftr.channels import FTRAxis
from gsapp.identification.ftr.regression_rows import RegressionRows
from gsapp.identification.maneuver import Maneuver
from gsapp.quantities import FloatArray

_EXTRA_COLUMNS = 9
"""Columns of `RegressionRows` behind the regressors: static parts, qbar, spun parts, two more."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class KnownEffects:
    """Coefficients that do not come from the derivatives, sample by sample."""

    coefficients: FloatArray
    """Shape (n, 6). `gsapp.dynamics.terms.COEFFICIENTS`, at the samples of the grid from its origin
    on."""

    def subtract_from(self, axis: FTRAxis, rows: RegressionRows, first: int) -> RegressionRows:
        """Return rows, from a sample of the grid on, with the known part out of their targets."""
        index = first + np.arange(len(rows.valid))
        inside = (index >= 0) & (index < len(self.coefficients))
        columns = rows.columns.copy()
        static = columns.shape[1] - _EXTRA_COLUMNS
        qbar = columns[inside, static + 3]
        for place, name in enumerate(AXIS_COEFFICIENTS[axis]):
            known = self.coefficients[index[inside], ALL.index(name)]
            columns[inside, static + place] -= qbar * known
        return replace(rows, columns=columns)


def compute_known_effects(maneuver: Maneuver, model: Model | None) -> KnownEffects | None:
    """Return what a model's effects give over a maneuver; None where it has none.

    `model`: without effects on instruments and control paths.

    Raises
    ------
    FlightError
        If the coefficients of the maneuver cannot be had at all.
    """
    if model is None or not model.effects:
        return None
    plain = reconstruct_coefficients(maneuver)
    left = reconstruct_coefficients(maneuver, model=model, cutoff=plain.smoother.cutoff)
    return KnownEffects(coefficients=plain.values - left.values)
