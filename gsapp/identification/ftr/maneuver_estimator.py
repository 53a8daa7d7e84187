"""FTR over maneuvers and flights that are over: the same equations and judgment as in flight."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

from gsapp.aircraft import Aircraft
from gsapp.dynamics.model import Model
from gsapp.flight import Flight
from gsapp.foundation import FlightError
from gsapp.identification.axes import AXIS_SURFACES, Axis, axis_derivatives
from gsapp.identification.channel_faults import check_estimate_support, remove_stuck_channels
from gsapp.identification.coefficient_histories import coefficient_history
from gsapp.identification.coefficients import reconstruct_coefficients
from gsapp.identification.estimate_corrections import constant_term_offsets
from gsapp.identification.ftr.channels import FTRAxis
from gsapp.identification.ftr.online_regression import FTR, FTR_AXES
from gsapp.identification.ftr.regression_rows import KnownEffects, compute_known_effects
from gsapp.identification.ftr.settings import FTR_ALGORITHM, FTRSettings
from gsapp.identification.ftr.solution import RecordInformation
from gsapp.identification.instrument_effects import effective_records
from gsapp.identification.maneuver import Maneuver, mass_over_flight
from gsapp.identification.motion import measured_motion
from gsapp.identification.record_preparation import reconstruct_deflections
from gsapp.identification.results import DerivativeEstimate, Estimate, ResponseFit, ResponseHistory
from gsapp.identification.statistics import response_fit
from gsapp.quantities import Block


def estimate(
    maneuvers: Sequence[Maneuver],
    axis: Axis,
    settings: FTRSettings | None = None,
    *,
    model: Model | None = None,
    given: Collection[str] = (),
) -> Estimate:
    """Estimate derivatives from one maneuver, or from several together.

    Each maneuver is a record with a trim of its own; what they say adds up. The frequencies lie
    as close as the longest of them resolves, unless `settings` say otherwise.

    Parameters
    ----------
    maneuvers : sequence of Maneuver
        Also of several flights, with their own aircraft and masses.
    settings : FTRSettings, optional
        `gate`, `forgetting`, `record_length`, `minimum_speed` and `updates` have no part in this.
    model : Model, optional
        Its effects are taken as known: those on instruments are undone in the record, those on
        the aircraft left out of the targets. Its derivatives have no part in this.
    given : collection of str
        Surfaces that the user knows to have rested, though their records do not change at all.

    Returns
    -------
    Estimate
        Derivatives that were not excited enough are ``unknown`` or ``not-identifiable``. `fit` and
        `histories`, of a single maneuver, are by coefficient: over time, all below the filter of
        equation error, though FTR looked at its own band only.

    Raises
    ------
    FlightError
        If there are no maneuvers.
    """
    if not maneuvers:
        raise FlightError("FTR needs at least one maneuver")
    maneuvers, remarks = remove_stuck_channels(maneuvers, axis)
    chosen = settings or FTRSettings(
        spacing=_resolved_spacing(max(one.t_end - one.t_start for one in maneuvers))
    )
    axes: tuple[FTRAxis, ...] = FTR_AXES if axis == "both" else (axis,)
    information: dict[FTRAxis, RecordInformation] = {}
    warnings: list[str] = []
    records, left = effective_records(maneuvers, model)
    for maneuver in records:
        ftr = _process_maneuver(
            maneuver, axis, axes, chosen, information, compute_known_effects(maneuver, left)
        )
        information = ftr.information()
        many = f"maneuver {maneuver.id}: " if len(maneuvers) > 1 else ""
        warnings += [many + remark for remark in ftr.remarks()]
        warnings += [
            f"{many}no estimate of {name}: {why}"
            for name, why in ftr.unavailable_coefficients().items()
        ]
    found = ftr.estimates()
    names = axis_derivatives(axis)
    derivatives = {
        name: DerivativeEstimate(
            value=found[name].value,
            std=found[name].std,
            cramer_rao=found[name].cramer_rao,
            status=found[name].status,
            confounded_with=found[name].confounded_with,
            why=found[name].why,
        )
        if name in found
        else DerivativeEstimate(value=None, status="unknown", why="no samples")
        for name in names
    }
    free = tuple(name for name in names if derivatives[name].status == "estimated")
    shown = _history(records[0], left, derivatives) if len(records) == 1 else None
    result = Estimate(
        method="ftr",
        axis=axis,
        maneuvers=tuple(one.id for one in maneuvers),
        derivatives=derivatives,
        free=free,
        covariance=ftr.covariance(free),
        fit={} if shown is None else _fits(shown),
        histories=() if shown is None else (shown,),
        converged=bool(free),
        warnings=tuple(dict.fromkeys(warnings)),
        message=("solved" if free else "not enough excitation for an estimate"),
    )
    return check_estimate_support(
        _add_offset_uncertainty(result, records, chosen), maneuvers, given, remarks
    )


def _add_offset_uncertainty(
    estimate: Estimate, maneuvers: Sequence[Maneuver], settings: FTRSettings
) -> Estimate:
    """Return an estimate that says which part of its bounds comes from zeros of instruments."""
    qbars = [measured_motion(one).qbar for one in maneuvers]
    derivatives = dict(estimate.derivatives)
    for name, offset in constant_term_offsets(
        maneuvers, qbars, settings.accelerometer_offset
    ).items():
        if name in estimate.free:
            one = derivatives[name]
            derivatives[name] = replace(one, offset=min(offset, one.std or 0.0))
    return replace(estimate, derivatives=derivatives)


def _history(
    maneuver: Maneuver, model: Model | None, derivatives: Mapping[str, DerivativeEstimate]
) -> ResponseHistory | None:
    """Return measured coefficients beside what the derivatives earned make of their changes.

    None where nothing was earned, or the coefficients cannot be had without a stand-in.
    """
    values = {
        name: one.value
        for name, one in derivatives.items()
        if one.value is not None and not name.endswith("_0")
    }
    # The band begins above zero: a constant is left open.
    courses = {name.partition("_")[0]: 0 for name in values}
    try:
        found = reconstruct_coefficients(maneuver, motion=measured_motion(maneuver), model=model)
    except FlightError:
        return None
    return coefficient_history(found, values, courses)


def _fits(history: ResponseHistory) -> dict[str, ResponseFit]:
    pairs = zip(history.channels, history.measured.T, history.computed.T, strict=True)
    return {name: response_fit(measured, computed) for name, measured, computed in pairs}


def _resolved_spacing(duration: float) -> float:
    return 1.0 / min(max(duration, 4.0), 60.0)


def _process_maneuver(
    maneuver: Maneuver,
    axis: Axis,
    axes: tuple[FTRAxis, ...],
    settings: FTRSettings,
    information: dict[FTRAxis, RecordInformation],
    known: KnownEffects | None,
) -> FTR:
    """Return an FTR that listened to one maneuver, after what was known."""
    if len(maneuver.block) < 3:
        raise FlightError(
            f"maneuver {maneuver.id} of '{maneuver.flight}' has {len(maneuver.block)} samples; "
            "FTR needs some seconds"
        )
    still = tuple(
        name
        for name in AXIS_SURFACES[axis]
        if name not in maneuver.inputs and not maneuver.has(name)
    )
    whole = replace(
        settings,
        gate="maneuvers",
        forgetting=None,
        record_length=None,
        minimum_speed=0.0,
        updates=FTR_ALGORITHM.maneuver_update_rate,
        lookback=maneuver.t_end - maneuver.t_start + 2.0 / FTR_ALGORITHM.maneuver_update_rate + 1.0,
        longest_gap=1e6,
        still=tuple(dict.fromkeys((*settings.still, *still))),
    )
    block = maneuver.block
    if maneuver.clipped:
        values = block.values.copy()
        for name, clipped in maneuver.clipped.items():
            values[clipped, block.channels.index(name)] = float("nan")
        block = Block(channels=block.channels, times=block.times, values=values)
    ftr = FTR(
        maneuver.aircraft,
        whole,
        rate=1.0 / maneuver.dt,
        origin=maneuver.t_start,
        axes=axes,
        measured=[name for name in block.channels if maneuver.has(name)],
        mass=maneuver.mass,
        burning=False,
        aligned=True,
        known=known,
    )
    ftr.set_prior_information(information)
    ftr.begin_window(maneuver.t_start)
    ftr.end_window(maneuver.t_end)
    ftr.feed(block)
    ftr.finish()
    return ftr


def compute_ftr_history(flight: Flight, aircraft: Aircraft) -> FTR:
    """Return an FTR that has listened to a flight from its first to its last sample.

    Raises `FlightError` if there are too few samples a second, or none at all.
    """
    block = reconstruct_deflections(flight.block, aircraft)
    if len(block) < 2 or not math.isfinite(flight.rate):
        raise FlightError(f"the flight '{flight.name}' contains too few samples for FTR")
    heard = FTR(
        aircraft,
        rate=flight.rate,
        origin=float(block.times[0]),
        mass=float(mass_over_flight(flight, aircraft)[0]),
    )
    for start in range(0, len(block), FTR_ALGORITHM.chunk_samples):
        piece = slice(start, start + FTR_ALGORITHM.chunk_samples)
        heard.feed(
            Block(channels=block.channels, times=block.times[piece], values=block.values[piece])
        )
        heard.process_step()
    heard.finish()
    return heard
