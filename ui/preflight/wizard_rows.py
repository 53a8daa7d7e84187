"""Beside the large number: points, what the curve is worth, what not to pass over, the end."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from calibration.validity import EXAMPLE, CalibrationInForce, day_words
from gsapp.quantities import channel, from_si, in_units
from ui.glyphs import State
from ui.preflight.point_list import PointRow
from ui.preflight.shelf import Shelf, local_now
from ui.preflight.wizard_start import Standing
from ui.preflight.wizard_summary import Outcome, Together
from ui.preflight.wizard_words import (
    curve_words,
    quantity_text,
    shift_words,
    signed_text,
    size_text,
    volts_text,
)
from ui.words import DASH, symbol_text

if TYPE_CHECKING:
    from calibration import Certificate
    from calibration.comparing import CheckResult
    from calibration.plan import CalibrationPlan, InstrumentPlan
    from calibration.wizard import WizardView
    from gsapp.session import History

_STALE = 2.0
"""Seconds after which a value is not one of now."""
_ROUNDING = 1e-6
"""In the unit of an instrument: a residual below that is the computer's, of a line through two."""


def standings_of(plan: CalibrationPlan, shelf: Shelf) -> tuple[Standing, ...]:
    """Return of each instrument whether and since when it is calibrated, and its last check."""
    known, held, left = shelf.certificates(), shelf.store.in_force(), shelf.store.skipped()
    checks = shelf.checks()
    in_force = CalibrationInForce(
        certificates=known,
        on=local_now(),
        lacking=[name for name in plan.channels if name not in known],
        failed=shelf.store.failed_checks(),
    )
    found = []
    for instrument in plan.instruments:
        name = instrument.channel
        good = name in held and in_force.judge((name,)).state == "good"
        words, check = _since(known.get(name)), checks.get(name)
        if name in left:
            words = f"uncalibrated: {left[name].reason}"
        elif name in known and name not in held and known[name].who != EXAMPLE:
            words = f"not calibrated here: that of {words} applies"
        if check is not None:
            day = day_words(check.stamp.astimezone(), local_now())
            words += f"; check {day} {check.stamp:%H:%M}: {_verdict(check.result, instrument)}"
        found.append(Standing(channel=name, title=instrument.title, words=words, good=good))
    return tuple(found)


def _since(certificate: Certificate | None) -> str:
    """Return when an instrument was calibrated and by whom."""
    if certificate is None:
        return "uncalibrated"
    if certificate.who == EXAMPLE:
        return "example values, not of this aircraft"
    by = f" by {certificate.who}" if certificate.who else ""
    stamp = certificate.stamp.astimezone()
    return f"{day_words(stamp, local_now())} {stamp:%H:%M}{by}"


def _verdict(check: CheckResult, instrument: InstrumentPlan) -> str:
    """Return what a check has found, in few words."""
    verdict = "holds" if check.passed else "has moved"
    what, size = shift_words(check, instrument)
    return f"{verdict}: {what} {size}"


class Remark(NamedTuple):
    """A sentence with its state: ``warning`` for a fault, ``caution``, or ``plain``."""

    state: State
    sentence: str


def point_rows(view: WizardView) -> tuple[PointRow, ...]:
    """Return the points taken, then the settings still to come."""
    instrument = view.instrument
    if instrument is None:
        return ()
    calibration = view.calibration
    residuals = view.off_curve
    # What is less than the error of a setting is drawn as little, however little the others are.
    largest = max(*map(abs, residuals), instrument.setting_error or 0.0, _ROUNDING)
    odd = calibration.quality.outliers if calibration is not None else ()
    rows = [
        PointRow(
            value=quantity_text(point.value, instrument.unit, _digits(point.value)),
            direction=point.direction if instrument.by_hand else "single",
            volts=volts_text(point.volts),
            residual=signed_text(residuals[at], instrument) if residuals else "",
            share=residuals[at] / largest if residuals else 0.0,
            remark="outlier" if at in odd else "",
            index=at,
        )
        for at, point in enumerate(view.points)
    ]
    rows += [
        PointRow(
            value=quantity_text(slot.value, instrument.unit),
            direction=slot.direction,
            current=at == 0 and view.phase == "points",
        )
        for at, slot in enumerate(view.remaining)
    ]
    return tuple(rows)


def _digits(value: float) -> int:
    """Return the digits of a setting: as it was given, a measured rate to a tenth."""
    return min(len(f"{value:g}".partition(".")[2]), 1)


def quality_lines(view: WizardView) -> tuple[tuple[str, str], ...]:
    """Return what the curve is worth: names and values."""
    instrument, calibration = view.instrument, view.calibration
    if instrument is None or calibration is None or view.phase != "fit":
        return ()
    quality = calibration.quality
    chosen = ", chosen by hand" if view.degree else ""
    lines = [
        ("Curve", f"{curve_words(calibration.degree)}{chosen}"),
        ("Hysteresis", size_text(quality.hysteresis, instrument)),
        ("Return to zero", size_text(quality.return_to_zero, instrument)),
        ("Off a straight line", size_text(quality.linearity, instrument)),
        ("One count of the converter", size_text(quality.resolution, instrument)),
    ]
    if quality.coverage is not None:
        lines.append(("Range of the travel covered", f"{100 * quality.coverage:.0f} %"))
    return tuple((name, value) for name, value in lines if DASH not in value)


def remarks_of(view: WizardView, units: str) -> tuple[Remark, ...]:
    """Return what the crew should not pass over, faults first, then what is worth knowing."""
    faults = {fault.sentence for fault in view.faults}
    said = [
        Remark("warning" if sentence in faults else "caution", _sentence(sentence, units))
        for sentence in view.sentences
    ]
    drift = view.drift
    moved = drift is not None and drift.significant
    for sentence in view.remarks:
        beyond = moved and drift is not None and drift.sentence in sentence
        said.append(Remark("caution" if beyond else "plain", _sentence(sentence, units)))
    return tuple(said)


def _sentence(words: str, units: str) -> str:
    words = in_units(words, units)
    return f"{words[:1].upper()}{words[1:].rstrip('.')}."


# The end


def outcomes_of(view: WizardView, plan: CalibrationPlan) -> tuple[Outcome, ...]:
    """Return what each instrument of the calibration came to."""
    found = []
    for instrument in plan.instruments:
        name = instrument.channel
        certificate = view.certificates.get(name)
        check = view.checks.get(name)
        if check is not None:
            words = _verdict(check, instrument)
            found.append(Outcome(title=instrument.title, words=words, good=check.passed))
        elif name in view.skipped:
            left = "uncalibrated" if view.mode == "full" else "not checked"
            words = f"{left}: {view.skipped[name]}"
            found.append(Outcome(title=instrument.title, words=words, good=False))
        elif certificate is not None:
            quality = certificate.quality
            width = quality.uncertainty if quality is not None else None
            parts = [
                curve_words(certificate.degree),
                f"within ±{size_text(width, instrument)}" if width is not None else "",
                f"hysteresis {size_text(certificate.hysteresis, instrument)}"
                if certificate.hysteresis
                else "",
            ]
            words = ", ".join(part for part in parts if part)
            found.append(Outcome(title=instrument.title, words=words, good=True))
    return tuple(found)


_TOGETHER = (
    ("Elevator", ("elevator_left", "elevator_right"), "de", "mean of left and right (6.1.1)"),
    ("Aileron", ("aileron_left", "aileron_right"), "da", "mean, both rolling right (6.1.2)"),
    ("Rudder", ("rudder",), "dr", "as measured (6.1.3)"),
)


def together_of(history: History | None, units: str) -> tuple[Together, ...]:
    """Return the deflections as the open flight has them now."""
    if history is None:
        return ()
    found = []
    for title, parts, whole, rule in _TOGETHER:
        if all(history.has(name) for name in (*parts, whole)):
            shown = [f"{_side_of(name)}{_latest(history, name, units)}" for name in parts]
            symbol = symbol_text(channel(whole).symbol)
            found.append(
                Together(
                    title=title,
                    parts="   ".join(shown),
                    whole=f"{symbol} = {_latest(history, whole, units)}",
                    rule=rule,
                )
            )
    return tuple(found)


def _side_of(name: str) -> str:
    side = name.rpartition("_")[2]
    return f"{side} " if side in ("left", "right") else ""


def _latest(history: History, name: str, units: str) -> str:
    last = history.last(name)
    spec = channel(name)
    if last is None or history.end is None or last[0] < history.end - _STALE:
        return DASH
    unit = spec.display_unit(units)
    return quantity_text(from_si(last[1], unit, spec.quantity), unit, spec.decimals(unit))
