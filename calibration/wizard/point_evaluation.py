"""What the points of an instrument come to: curve, certificate, drift, and whether all is well."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from datetime import datetime

import numpy as np

from calibration.certificate import Certificate
from calibration.curve_selection import create_certificate, fit_calibration
from calibration.drift import Drift, check_certificate, compute_drift
from calibration.plan import InstrumentPlan
from calibration.points import DIRECTION_TEXT, CalibrationError, CalibrationPoint
from calibration.quality import Calibration
from calibration.settings import WIZARD
from calibration.wizard.procedure import CalibrationOutcome, JournalHeader
from calibration.wizard.state import AngleProgress, RecordedPoint


def evaluate_points(
    instrument: InstrumentPlan,
    work: AngleProgress,
    header: JournalHeader,
    *,
    former: Certificate | None,
    partner: Certificate | None,
    stamp: datetime,
    temperature: float | None,
) -> CalibrationOutcome:
    """Return what the points of a calibration come to."""
    if len(work.points) < 2:
        return CalibrationOutcome()
    supply = mean_supply_voltage(work.points) if instrument.ratiometric else None
    points = [refer_to_supply(taken, supply) for taken in work.points]
    try:
        calibration = fit_calibration(
            points,
            degree=work.degree,
            travel=instrument.travel,
            setting_error=instrument.setting_error,
        )
        certificate = create_certificate(
            calibration,
            points,
            channel_id=instrument.channel,
            unit=instrument.unit,
            who=header.who,
            stamp=stamp,
            excitation_voltage=supply,
            ratiometric=supply is not None,
            temperature=temperature,
            instrument=instrument.title,
            notes=f"Positive {instrument.positive}.",
        )
    except CalibrationError as error:
        return CalibrationOutcome(issues=(str(error),))
    drift, complaint = _drift(certificate, former)
    alike, unlike = _compare_with_partner(instrument, certificate, partner)
    doubts = [
        *_outlier_text(instrument, calibration, points),
        *_sign_text(instrument, work, certificate),
        *_drift_text(drift, calibration),
        *complaint,
        *unlike,
    ]
    remarks = [*alike, *_coverage_text(calibration)]
    if drift is not None and drift.sentence not in doubts:
        remarks.insert(0, drift.sentence)
    if instrument.ratiometric and supply is None:
        remarks.append("the supply was not measured: volts are used as read")
    return CalibrationOutcome(
        certificates=(certificate,),
        issues=tuple(doubts),
        remarks=tuple(remarks),
        ready=True,
        calibration=calibration,
        drift=drift,
    )


def evaluate_check(work: AngleProgress, certificate: Certificate | None) -> CalibrationOutcome:
    """Return what the points of a three-point check come to."""
    if len(work.points) < 2 or certificate is None:
        return CalibrationOutcome()
    supply = certificate.excitation_voltage if certificate.ratiometric else None
    points = [refer_to_supply(taken, supply) for taken in work.points]
    try:
        result = check_certificate(certificate, points)
    except CalibrationError as error:
        return CalibrationOutcome(issues=(str(error),))
    return CalibrationOutcome(
        ready=True,
        check_result=result,
        issues=() if result.passed else (result.sentence,),
        remarks=(result.sentence,) if result.passed else (),
    )


def mean_supply_voltage(points: Sequence[RecordedPoint]) -> float | None:
    """Return the mean supply over the points, V; None where it was not always measured."""
    known = [taken.excitation for taken in points if taken.excitation is not None]
    return float(np.mean(known)) if known and len(known) == len(points) else None


def refer_to_supply(taken: RecordedPoint, supply: float | None) -> CalibrationPoint:
    """Return a point with the volts that `supply` would have given."""
    if supply is None or not taken.excitation:
        return taken.point
    return replace(taken.point, volts=taken.volts * supply / taken.excitation)


def _outlier_text(
    instrument: InstrumentPlan, calibration: Calibration, points: Sequence[CalibrationPoint]
) -> list[str]:
    found = []
    for index in calibration.quality.outliers:
        point = points[index]
        parts = (
            f"point {index + 1}",
            instrument.format_setting(point.value),
            DIRECTION_TEXT[point.direction],
            "does not fit the others; repeat or delete it",
        )
        found.append(", ".join(part for part in parts if part))
    return found


def _sign_text(
    instrument: InstrumentPlan, work: AngleProgress, certificate: Certificate
) -> tuple[str, ...]:
    if work.rising is None or (sum(certificate.end_slopes) > 0.0) == work.rising:
        return ()
    return (
        f"{instrument.title}: the points go in the opposite direction to when it was moved "
        f"{instrument.positive}; check from which side the protractor was read",
    )


def _drift(
    certificate: Certificate, former: Certificate | None
) -> tuple[Drift | None, tuple[str, ...]]:
    """Return the drift since the former certificate, and what keeps it from being told."""
    if former is None:
        return None, ()
    if (sum(certificate.end_slopes) > 0.0) != (sum(former.end_slopes) > 0.0):
        return None, (
            "the voltage direction is opposite to the certificate of "
            f"{former.stamp:%Y-%m-%d %H:%M}; accept it if the instrument was remounted the "
            "other way round",
        )
    try:
        return compute_drift(certificate, former), ()
    except CalibrationError as error:
        return None, (str(error),)


def _drift_text(drift: Drift | None, calibration: Calibration) -> tuple[str, ...]:
    if drift is None or not drift.significant:
        return ()
    low, high = calibration.quality.covered
    much = (
        abs(drift.zero) > WIZARD.max_zero_drift * (high - low)
        or abs(drift.slope) > WIZARD.max_slope_drift
    )
    return (drift.sentence,) if much else ()


def _compare_with_partner(
    instrument: InstrumentPlan, certificate: Certificate, partner: Certificate | None
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return how left and right compare: where they are alike, and where they are not."""
    if partner is None or partner.unit != instrument.unit:
        return (), ()
    own, other = (abs(_volts_per_unit(one)) for one in (certificate, partner))
    sentence = (
        f"{own:.4f} V/{instrument.unit}, the other side {other:.4f} V/{instrument.unit}: "
        f"{100.0 * (own / other - 1.0):+.0f} %"
    )
    if abs(own / other - 1.0) <= WIZARD.max_slope_difference:
        return (sentence,), ()
    return (), (f"left and right differ: {sentence}; check the settings of both",)


def _volts_per_unit(certificate: Certificate) -> float:
    low, high = certificate.range
    values = np.polynomial.polynomial.polyval(np.array((low, high)), certificate.coefficients)
    return (high - low) / float(values[1] - values[0])


def _coverage_text(calibration: Calibration) -> tuple[str, ...]:
    coverage = calibration.quality.coverage
    if coverage is None or coverage >= WIZARD.min_coverage:
        return ()
    return (f"only {100.0 * coverage:.0f} % of the travel is covered",)
