"""What the points of an instrument come to: curve, certificate, drift, and whether all is well."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import datetime

import numpy as np

from calibration.certificate import Certificate
from calibration.choosing import calibrate
from calibration.comparing import Drift, compare
from calibration.fit import CalibrationError, CalibrationPoint
from calibration.plan import InstrumentPlan
from calibration.quality import Calibration
from calibration.wizard.state import HandWork, Taken


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Judgment:
    """What the points come to so far.

    Attributes
    ----------
    calibration : Calibration or None
        None before the points allow a curve.
    certificate : Certificate or None
        As it would be written.
    drift : Drift or None
        Against the certificate in force.
    doubts : tuple of str
        Sentences; a calibration that has none is accepted by itself.
    """

    calibration: Calibration | None = None
    certificate: Certificate | None = None
    drift: Drift | None = None
    doubts: tuple[str, ...] = ()


def judge(
    instrument: InstrumentPlan,
    work: HandWork,
    former: Certificate | None,
    *,
    who: str,
    stamp: datetime,
    temperature: float | None,
) -> Judgment:
    """Return what the points of an instrument come to.

    Parameters
    ----------
    instrument : InstrumentPlan
        Which.
    work : HandWork
        Its points.
    former : Certificate or None
        In force so far.
    who : str
        Takes the readings.
    stamp : datetime
        Of the certificate.
    temperature : float or None
        K.
    """
    if len(work.points) < 2:
        return Judgment()
    supply = supply_of(work.points) if instrument.ratiometric else None
    points = [referred(taken, supply).point for taken in work.points]
    try:
        calibration = calibrate(points, degree=work.degree, travel=instrument.travel)
        certificate = Certificate.from_points(
            instrument.channel,
            instrument.unit,
            points,
            degree=calibration.degree,
            who=who,
            stamp=stamp,
            excitation_voltage=supply,
            ratiometric=supply is not None,
            temperature=temperature,
            instrument=instrument.title,
            notes=f"Positive {instrument.positive}." if instrument.positive else "",
        )
    except CalibrationError as error:
        return Judgment(doubts=(str(error),))
    drift = None
    doubts = [*_outlier_words(instrument, calibration, points)]
    if work.rising is not None and (sum(certificate.end_slopes) > 0.0) != work.rising:
        doubts.append(
            f"{instrument.title} reads reversed: the volts went the other way when it was moved "
            f"{instrument.positive}; check from which side the protractor was read"
        )
    if former is not None and former.unit == instrument.unit:
        try:
            drift = compare(certificate, former)
        except CalibrationError as error:
            doubts.append(str(error))
    return Judgment(
        calibration=calibration, certificate=certificate, drift=drift, doubts=tuple(doubts)
    )


def supply_of(points: Sequence[Taken]) -> float | None:
    """Return the mean supply over the points, V; None where it was not always measured."""
    supplies = [taken.excitation for taken in points]
    known = [supply for supply in supplies if supply is not None]
    return float(np.mean(known)) if known and len(known) == len(supplies) else None


def referred(taken: Taken, supply: float | None) -> Taken:
    """Return a point with the volts that `supply` would have given."""
    if supply is None or not taken.excitation:
        return taken
    ratio = supply / taken.excitation
    return replace(taken, volts=taken.volts * ratio, excitation=supply)


def _outlier_words(
    instrument: InstrumentPlan, calibration: Calibration, points: Sequence[CalibrationPoint]
) -> list[str]:
    return [
        f"point {index + 1}, {instrument.setting_words(points[index].value)} "
        f"{points[index].direction}, does not fit the others; repeat or delete it"
        for index in calibration.quality.outliers
    ]
