"""Beside the large number: figure, points, what the curve is worth, remarks, the end."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from calibration.settings import FIT_ORDER_TITLES
from calibration.validity import SHIPPED_EXAMPLE, CalibrationInForce, day_text
from gsapp.quantities import channel, convert_text_units, from_si
from ui.display_limits import DISPLAY
from ui.icons import IndicatorState
from ui.number_format import DASH, symbol_text
from ui.preflight.aircraft_figures import AircraftPoseFigure, PoseKind
from ui.preflight.calibration_charts import CalibrationPointRow
from ui.preflight.calibration_controller import CalibrationFolder, current_local_time
from ui.preflight.surface_motion_view import SurfaceFigure
from ui.preflight.wizard_panels import CombinedDeflection, InstrumentOutcome, InstrumentStatus
from ui.preflight.wizard_text import (
    describe_shift,
    error_text,
    quantity_text,
    signed_error_text,
    volts_text,
)
from ui.translation import QT_TR_NOOP, tr

if TYPE_CHECKING:
    from calibration import Certificate
    from calibration.drift import CheckResult
    from calibration.plan import CalibrationPlan, InstrumentPlan
    from calibration.wizard import WizardView
    from gsapp.session import SampleHistory


def select_figure(view: WizardView) -> SurfaceFigure | AircraftPoseFigure | None:
    """Return the aircraft as it stands, or as it is to be laid or turned."""
    instrument = view.instrument
    if instrument is None:
        return None
    if instrument.is_angle_sensor:
        return _surface_figure(view, instrument)
    if view.phase == "gyro_turn":
        return AircraftPoseFigure(
            kind="turn",
            accessible_text=view.prompt,
            axis=instrument.channel,
            angle=view.target or 0.0,
            turned=view.amount or 0.0,
        )
    if view.phase == "accel_position" and view.position is not None:
        return AircraftPoseFigure(kind="lie", accessible_text=view.prompt, position=view.position)
    kinds: dict[str, PoseKind] = {"pressure_zero": "cover", "pressure_blow": "blow"}
    return AircraftPoseFigure(kind=kinds.get(view.phase, "still"), accessible_text=view.prompt)


def _surface_figure(view: WizardView, instrument: InstrumentPlan) -> SurfaceFigure:
    where = instrument.positive.rpartition(" ")[2]
    settings = [slot.value for slot in view.remaining] + [point.value for point in view.points]
    return SurfaceFigure(
        channel=instrument.channel,
        title=instrument.title,
        view="above" if where in ("left", "right") else "side",
        kind="vane" if instrument.kind == "vane" else "surface",
        sense=1 if where in ("down", "left") else -1,
        ticks=tuple(sorted({*instrument.settings, *settings})),
        angle=view.current_value,
        target=_target_angle(view, instrument),
    )


def _target_angle(view: WizardView, instrument: InstrumentPlan) -> float | None:
    """Return where the surface is wanted; while its sign is proven, well to the positive side."""
    if view.phase == "sign":
        return max(instrument.settings)
    return view.target if view.phase == "points" else None


def list_instrument_statuses(
    plan: CalibrationPlan, folder: CalibrationFolder
) -> tuple[InstrumentStatus, ...]:
    """Return of each instrument whether and since when it is calibrated, and its last check."""
    known, held, left = (
        folder.certificates_in_force(),
        folder.store.in_force(),
        folder.store.skipped_channels(),
    )
    checks = folder.last_checks()
    in_force = CalibrationInForce(
        certificates=known,
        flight_date=current_local_time(),
        missing=[name for name in plan.channels if name not in known],
        failed_checks=folder.store.failed_checks(),
    )
    found = []
    for instrument in plan.instruments:
        name = instrument.channel
        good = name in held and in_force.evaluate((name,)).state == "good"
        text, check = _calibrated_text(known.get(name)), checks.get(name)
        if name in left:
            text = tr("uncalibrated: {reason}").format(reason=left[name].reason)
        elif name in known and name not in held and known[name].who != SHIPPED_EXAMPLE:
            text = tr("not calibrated: the certificate of {words} applies").format(words=text)
        if check is not None:
            day = day_text(check.stamp.astimezone(), current_local_time())
            text += tr("; check {day} {stamp:%H:%M}: {check}").format(
                day=day, stamp=check.stamp, check=_check_text(check.result, instrument)
            )
        found.append(
            InstrumentStatus(channel=name, title=instrument.title, text=text, is_calibrated=good)
        )
    return tuple(found)


def _calibrated_text(certificate: Certificate | None) -> str:
    if certificate is None:
        return tr("uncalibrated")
    if certificate.who == SHIPPED_EXAMPLE:
        return tr("example values, not of this aircraft")
    by = tr(" by {who}").format(who=certificate.who) if certificate.who else ""
    stamp = certificate.stamp.astimezone()
    return f"{day_text(stamp, current_local_time())} {stamp:%H:%M}{by}"


def _check_text(check: CheckResult, instrument: InstrumentPlan) -> str:
    verdict = tr("holds") if check.passed else tr("has moved")
    what, size = describe_shift(check, instrument)
    return f"{verdict}: {what} {size}"


class WizardRemark(NamedTuple):
    """A sentence with its state: ``warning`` for a fault, ``caution``, or ``plain``."""

    state: IndicatorState
    sentence: str


def build_point_rows(view: WizardView) -> tuple[CalibrationPointRow, ...]:
    """Return the points taken, then the settings still to come."""
    instrument = view.instrument
    if instrument is None:
        return ()
    calibration = view.calibration
    residuals = view.residuals
    # What is less than the error of a setting is drawn as little, however little the others are.
    largest = max(*map(abs, residuals), instrument.setting_error or 0.0, DISPLAY.residual_rounding)
    odd = calibration.quality.outliers if calibration is not None else ()
    rows = [
        CalibrationPointRow(
            value=quantity_text(point.value, instrument.unit, _digits(point.value)),
            direction=point.direction if instrument.is_angle_sensor else "single",
            volts=volts_text(point.volts),
            residual=signed_error_text(residuals[index], instrument) if residuals else "",
            share=residuals[index] / largest if residuals else 0.0,
            remark="outlier" if index in odd else "",
            index=index,
        )
        for index, point in enumerate(view.points)
    ]
    rows += [
        CalibrationPointRow(
            value=quantity_text(slot.value, instrument.unit),
            direction=slot.direction,
            current=index == 0 and view.phase == "points",
        )
        for index, slot in enumerate(view.remaining)
    ]
    return tuple(rows)


def _digits(value: float) -> int:
    """Return the digits of a setting: as it was given, a measured rate to a tenth."""
    return min(len(f"{value:g}".partition(".")[2]), 1)


def build_quality_rows(view: WizardView) -> tuple[tuple[str, str], ...]:
    """Return what the curve is worth: names and values."""
    instrument, calibration = view.instrument, view.calibration
    if instrument is None or calibration is None or view.phase != "fit":
        return ()
    quality = calibration.quality
    chosen = tr(", set manually") if view.degree else ""
    lines = [
        (tr("Curve"), f"{tr(FIT_ORDER_TITLES[calibration.degree])}{chosen}"),
        (tr("Hysteresis"), error_text(quality.hysteresis, instrument)),
        (tr("Return to zero"), error_text(quality.return_to_zero, instrument)),
        (tr("Linearity"), error_text(quality.linearity, instrument)),
        (tr("ADC resolution"), error_text(quality.resolution, instrument)),
    ]
    if quality.coverage is not None:
        lines.append((tr("Calibrated range"), f"{100 * quality.coverage:.0f} %"))
    return tuple((name, value) for name, value in lines if DASH not in value)


def list_remarks(view: WizardView, units: str) -> tuple[WizardRemark, ...]:
    """Return what the crew should not pass over, faults first, then what is worth knowing."""
    faults = {fault.sentence for fault in view.faults}
    said = [
        WizardRemark(
            "warning" if sentence in faults else "caution", _format_sentence(sentence, units)
        )
        for sentence in view.problems
    ]
    drift = view.drift
    moved = drift is not None and drift.significant
    for sentence in view.remarks:
        beyond = moved and drift is not None and drift.sentence in sentence
        said.append(
            WizardRemark("caution" if beyond else "plain", _format_sentence(sentence, units))
        )
    return tuple(said)


def _format_sentence(words: str, units: str) -> str:
    words = convert_text_units(words, units)
    return f"{words[:1].upper()}{words[1:].rstrip('.')}."


# The end


def list_outcomes(view: WizardView, plan: CalibrationPlan) -> tuple[InstrumentOutcome, ...]:
    """Return what each instrument of the calibration came to."""
    found = []
    for instrument in plan.instruments:
        name = instrument.channel
        certificate = view.certificates.get(name)
        check = view.accepted_checks.get(name)
        if check is not None:
            text, good = _check_text(check, instrument), check.passed
        elif name in view.skipped:
            left = tr("uncalibrated") if view.mode == "full" else tr("not checked")
            text, good = f"{left}: {view.skipped[name]}", False
        elif certificate is not None:
            text, good = _certificate_text(certificate, instrument), True
        else:
            continue
        found.append(InstrumentOutcome(title=instrument.title, text=text, is_calibrated=good))
    return tuple(found)


def _certificate_text(certificate: Certificate, instrument: InstrumentPlan) -> str:
    parts = [tr(FIT_ORDER_TITLES[certificate.degree])]
    width = certificate.quality.uncertainty if certificate.quality is not None else None
    if width is not None:
        parts.append(tr("within ±{error}").format(error=error_text(width, instrument)))
    if certificate.hysteresis:
        error = error_text(certificate.hysteresis, instrument)
        parts.append(tr("hysteresis {error}").format(error=error))
    return ", ".join(parts)


_COMBINED_DEFLECTIONS = (
    (
        QT_TR_NOOP("Elevator"),
        ("elevator_left", "elevator_right"),
        "de",
        QT_TR_NOOP("mean of left and right (6.1.1)"),
    ),
    (
        QT_TR_NOOP("Aileron"),
        ("aileron_left", "aileron_right"),
        "da",
        QT_TR_NOOP("mean, both rolling right (6.1.2)"),
    ),
    (QT_TR_NOOP("Rudder"), ("rudder",), "dr", QT_TR_NOOP("as measured (6.1.3)")),
)


def list_combined_deflections(
    history: SampleHistory | None, units: str
) -> tuple[CombinedDeflection, ...]:
    """Return the deflections as the open flight has them now."""
    if history is None:
        return ()
    found = []
    for title, parts, whole, rule in _COMBINED_DEFLECTIONS:
        if all(history.has(name) for name in (*parts, whole)):
            shown = [
                f"{_side_text(name)}{_latest_value_text(history, name, units)}" for name in parts
            ]
            symbol = symbol_text(channel(whole).symbol)
            found.append(
                CombinedDeflection(
                    title=tr(title),
                    parts="   ".join(shown),
                    combined=f"{symbol} = {_latest_value_text(history, whole, units)}",
                    rule=tr(rule),
                )
            )
    return tuple(found)


def _side_text(name: str) -> str:
    side = name.rpartition("_")[2]
    return f"{side} " if side in ("left", "right") else ""


def _latest_value_text(history: SampleHistory, name: str, units: str) -> str:
    last = history.last(name)
    spec = channel(name)
    if last is None or history.end is None or last[0] < history.end - DISPLAY.stale_reading_age:
        return DASH
    unit = spec.display_unit(units)
    return quantity_text(from_si(last[1], unit, spec.quantity), unit, spec.decimals(unit))
