"""The aircraft's model with what this flight has taught so far."""

from __future__ import annotations

from collections.abc import Mapping

from gsapp.aircraft import Aircraft
from gsapp.dynamics.model import Model
from gsapp.dynamics.trim import find_suspect_signs, find_unflyable_reasons
from gsapp.excitation.test_points.settings import INPUTS
from gsapp.identification.ftr.estimates import LiveEstimate


def update_model(
    model: Model, estimates: Mapping[str, LiveEstimate] | None, *, aircraft: Aircraft
) -> Model:
    """Return a model with the derivatives that this flight has earned.

    An estimate takes the place of a derivative if it is earned, its bound is below
    `INPUTS.max_relative_bound` of its value, and the model with it flies with no sign reversed that
    was right before. Biases stay: they belong to trim and to how the instruments were zeroed.

    Parameters
    ----------
    estimates : mapping of str to LiveEstimate, or None
        By name; of body axes, per radian.

    Returns
    -------
    Model
        The same object if nothing was replaced.
    """
    changed: dict[str, float] = {}
    doubts = len(find_suspect_signs(model))
    for name, estimate in (estimates or {}).items():
        if name not in model.derivatives or not _is_reliable(estimate):
            continue
        old, new = model.derivative(name), estimate.value
        if new is None or (old and not 1.0 / INPUTS.max_ratio < new / old < INPUTS.max_ratio):
            continue
        trial = model.with_derivatives({**changed, name: new})
        if not find_unflyable_reasons(aircraft, trial) and len(find_suspect_signs(trial)) <= doubts:
            changed[name] = new
    if not changed:
        return model
    return model.with_derivatives(changed, name=f"{model.name}, as flown")


def _is_reliable(estimate: LiveEstimate) -> bool:
    value, std = estimate.value, estimate.std
    if estimate.name.endswith("_0") or value is None or std is None:
        return False
    return 0.0 < std < INPUTS.max_relative_bound * abs(value)
