"""What the effects of a model are known to give, taken out of the regressions' targets."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from gsapp.dynamics.model import Model
from gsapp.dynamics.terms import COEFFICIENTS as ALL
from gsapp.identification.axes import COEFFICIENTS
from gsapp.identification.coefficients import reconstruct
from gsapp.identification.ftr.axis_rows import AxisRows
from gsapp.identification.ftr.channels import FTRAxis
from gsapp.identification.maneuver import Maneuver
from gsapp.quantities import FloatArray

_BEHIND = 9
"""Columns of `AxisRows` behind the regressors: static parts, qbar, spun parts, two more."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class KnownPart:
    """Coefficients that do not come from the derivatives, sample by sample.

    Attributes
    ----------
    coefficients : ndarray, shape (n, 6)
        `gsapp.dynamics.terms.COEFFICIENTS`, at the samples of the grid from its origin on.
    """

    coefficients: FloatArray

    def without(self, axis: FTRAxis, rows: AxisRows, first: int) -> AxisRows:
        """Return rows, from a sample of the grid on, with the known part out of their targets."""
        index = first + np.arange(len(rows.valid))
        inside = (index >= 0) & (index < len(self.coefficients))
        columns = rows.columns.copy()
        static = columns.shape[1] - _BEHIND
        qbar = columns[inside, static + 3]
        for place, name in enumerate(COEFFICIENTS[axis]):
            known = self.coefficients[index[inside], ALL.index(name)]
            columns[inside, static + place] -= qbar * known
        return replace(rows, columns=columns)


def known_part(maneuver: Maneuver, model: Model | None) -> KnownPart | None:
    """Return what a model's effects give over a maneuver; None where it has none.

    Parameters
    ----------
    maneuver : Maneuver
    model : Model or None
        Without effects on instruments and control paths.

    Raises
    ------
    FlightError
        If the coefficients of the maneuver cannot be had at all.
    """
    if model is None or not model.effects:
        return None
    plain = reconstruct(maneuver)
    left = reconstruct(maneuver, model=model, cutoff=plain.smoother.cutoff)
    return KnownPart(coefficients=plain.values - left.values)
