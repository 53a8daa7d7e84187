"""The coefficients of several maneuvers, smoothed alike."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from gsapp.dynamics.model import Model
from gsapp.foundation import FlightError
from gsapp.identification.coefficients import Coefficients, reconstruct_coefficients
from gsapp.identification.instrument_effects import effective_records
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.motion import MeasuredMotion, measured_motion
from gsapp.identification.smoothing import select_cutoff


def smooth_coefficients(
    maneuvers: Sequence[Maneuver],
    motions: Sequence[MeasuredMotion] | None = None,
    *,
    stand_ins: Mapping[str, float] | None = None,
    model: Model | None = None,
    cutoff: float | None = None,
    delays: Mapping[str, float] | None = None,
) -> list[Coefficients]:
    """Return the coefficients of all maneuvers, smoothed with the highest cutoff that one needs.

    Parameters as in `gsapp.identification.coefficients.reconstruct_coefficients`.

    Raises
    ------
    FlightError
        If there is no maneuver.
    """
    if not maneuvers:
        raise FlightError("no maneuver to estimate from; name at least one")
    if motions is None:
        maneuvers, model = effective_records(maneuvers, model)
        motions = [measured_motion(maneuver, stand_ins=stand_ins) for maneuver in maneuvers]
    if cutoff is None:
        cutoff = max(
            select_cutoff(motion.states[:, 1:6], maneuver.dt)
            for maneuver, motion in zip(maneuvers, motions, strict=True)
        )
    return [
        reconstruct_coefficients(maneuver, motion=motion, model=model, cutoff=cutoff, delays=delays)
        for maneuver, motion in zip(maneuvers, motions, strict=True)
    ]
