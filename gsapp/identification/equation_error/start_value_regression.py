"""Start values for a fit that goes on from them: least squares, a number for everything."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from gsapp.dynamics.buildup import linear_variables
from gsapp.dynamics.model import Model
from gsapp.identification.coefficients import Coefficients
from gsapp.identification.equation_error.equations import excitation_threshold
from gsapp.identification.equation_error.settings import EQUATION_ERROR
from gsapp.identification.equation_error.smoothed_coefficients import smooth_coefficients
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.motion import MeasuredMotion
from gsapp.quantities import FloatArray


def estimate_start_values(
    maneuvers: Sequence[Maneuver],
    free: Sequence[str],
    *,
    held: Mapping[str, float] | None = None,
    stand_ins: Mapping[str, float] | None = None,
    model: Model | None = None,
    motions: Sequence[MeasuredMotion] | None = None,
) -> dict[str, float]:
    """Return numbers to start from, by derivative, in a millisecond or two.

    Plain least squares without bounds. What cannot be told apart is shared out; what was not
    measured or has not moved is left out. `estimate` is the one to believe.

    `free`: derivatives.
    `held`, `stand_ins`, `model`, `motions`: as in `gsapp.identification.equation_error.estimator`.
    """
    found = smooth_coefficients(
        maneuvers,
        stand_ins=stand_ins,
        model=model,
        cutoff=EQUATION_ERROR.start_value_cutoff,
        motions=motions,
    )
    fixed = {} if model is None else dict(model.derivatives)
    fixed = {name: value for name, value in fixed.items() if name not in free}
    fixed.update(held or {})
    start: dict[str, float] = {}
    columns = [_regressor_columns(one) for one in found]
    for coefficient in dict.fromkeys(name.partition("_")[0] for name in free):
        names = [name for name in free if name.startswith(f"{coefficient}_")]
        pieces = [
            _regression_rows(one, table, coefficient, names, fixed)
            for one, table in zip(found, columns, strict=True)
            if coefficient not in one.missing
        ]
        if not pieces:
            continue
        X = np.concatenate([piece[0] for piece in pieces])
        y = np.concatenate([piece[1] for piece in pieces])
        if len(y) < len(names):
            continue
        moved = [
            index
            for index, name in enumerate(names)
            if X[:, index].any()
            and (
                name.endswith("_0") or X[:, index].std() > excitation_threshold(name[3:], found[0])
            )
        ]
        scale = np.maximum(np.linalg.norm(X[:, moved], axis=0), 1e-300)
        solution = (
            np.linalg.lstsq(X[:, moved] / scale, y, rcond=EQUATION_ERROR.singular_value_cutoff)[0]
            / scale
        )
        start.update(zip([names[index] for index in moved], solution.tolist(), strict=True))
    return start


def _regressor_columns(one: Coefficients) -> dict[str, FloatArray]:
    suffixes = {**linear_variables("Cm"), **linear_variables("Cn")}
    smoothed = one.smoothed_variables(tuple(suffixes.values()))[:: one.smoother.stride]
    table = dict(zip(suffixes, smoothed.T, strict=True))
    table["0"] = np.ones(len(smoothed))
    return table


def _regression_rows(
    one: Coefficients,
    table: Mapping[str, FloatArray],
    coefficient: str,
    names: Sequence[str],
    fixed: Mapping[str, float],
) -> tuple[FloatArray, FloatArray]:
    stride = one.smoother.stride
    y = one.values[::stride, one.column(coefficient)]
    good = one.valid_samples(coefficient)[::stride]
    for name, value in fixed.items():
        head, _, suffix = name.partition("_")
        if head == coefficient and value != 0.0:
            y = y - value * table[suffix]
    reads = linear_variables(coefficient)
    suffixes = [name.partition("_")[2] for name in names]
    for suffix in suffixes:
        if suffix != "0":
            good = good & one.variable_valid[reads[suffix]][::stride]
    X = np.column_stack([table[suffix] for suffix in suffixes])
    if not one.integrated.isdisjoint(suffixes):
        # An integrated angle has an offset and a drift: they are taken out of both sides.
        ramp = np.linspace(-1.0, 1.0, y.size)
        drift = np.linalg.qr(np.column_stack((np.ones(y.size), ramp, ramp * ramp))[good])[0]
        both = np.column_stack((X, y))[good]
        both = both - drift @ (drift.T @ both)
        return both[:, :-1], both[:, -1]
    return X[good], y[good]
