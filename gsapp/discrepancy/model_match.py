"""Whether a model belongs to the flights at all: a missing effect is small beside the lift."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gsapp.discrepancy.settings import SEARCH
from gsapp.dynamics.flight_model import FlightModel
from gsapp.dynamics.model import Model
from gsapp.foundation import FlightError
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.motion import measured_motion
from gsapp.quantities import FloatArray
from gsapp.quantities.constants import GRAVITY


def check_model_match(model: Model, maneuvers: Sequence[Maneuver]) -> None:
    """Raise if a model gives quite another normal force than these maneuvers show.

    Values that are 10 to 20 % wrong pass, and so does any single effect of the catalog; a model,
    an aircraft file or a speed that is of another aircraft does not. A vane that is mounted askew
    moves the level of the force and hardly its answer to what the pilot does; such flights pass.

    Parameters
    ----------
    model : Model
        The one that was given.
    maneuvers : sequence of Maneuver
        Those that hold a normal acceleration and an angle of attack count.

    Raises
    ------
    FlightError
        Saying by how much, and what to check.
    """
    measured, modeled = [], []
    for one in maneuvers:
        samples = one.samples("an")
        good = np.isfinite(samples)
        if not (good.any() and one.has("alpha")):
            continue
        flight_model = FlightModel(one.aircraft, model)
        motion = measured_motion(one)
        state, inputs = tuple(motion.states.T), tuple(motion.inputs.T)
        settled = flight_model.steady_states(state, inputs)
        upward = -np.asarray(flight_model.evaluate((*state, *settled), inputs).loads[2])
        measured.append(samples[good])
        modeled.append((np.broadcast_to(upward, samples.shape) / one.mass)[good])
    if not measured:
        return
    flown, given = np.concatenate(measured), np.concatenate(modeled)
    off = float(np.median(np.abs(given - flown)))
    usual = float(np.median(np.abs(flown)))
    if (
        not off <= SEARCH.max_level_error * usual
        and not SEARCH.response_ratio_range[0]
        < _response_ratio(measured, modeled)
        < SEARCH.response_ratio_range[1]
    ):
        raise FlightError(
            f"the model '{model.name}' seems to be of another aircraft: in these maneuvers it "
            f"gives {np.median(given) / GRAVITY:.2g} g where {np.median(flown) / GRAVITY:.2g} g "
            "were measured; check model and aircraft file (mass, wing area) and the zero of the "
            "alpha vane, or leave the model out and the linear build-up is fitted"
        )


def _response_ratio(measured: Sequence[FloatArray], modeled: Sequence[FloatArray]) -> float:
    """Return how much a modeled force moves about its level where the measured one moves by 1."""
    flown = np.concatenate([one - np.median(one) for one in measured])
    given = np.concatenate([one - np.median(one) for one in modeled])
    return float(given @ flown / max(float(flown @ flown), 1e-12))
