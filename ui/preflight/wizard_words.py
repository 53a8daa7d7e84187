"""What the wizard's page says of a view: numbers with units, words for states."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from gsapp.quantities import channel, from_si
from ui.glyphs import State
from ui.preflight.action_bar import Offer
from ui.preflight.airplane import SurfaceFigure
from ui.preflight.point_list import PointRow
from ui.preflight.wizard_summary import Outcome, Together
from ui.words import DASH, MINUS, number_text, symbol_text, unit_text

if TYPE_CHECKING:
    from calibration.plan import CalibrationPlan, InstrumentPlan
    from calibration.watching import WatchReading
    from calibration.wizard import WizardView
    from gsapp.session import History

_STALE = 2.0
"""Seconds after which a value is not one of now."""
_WATCH: dict[str, tuple[State, str]] = {
    "absent": ("warning", "No signal"),
    "moving": ("caution", "Moving"),
    "steady": ("good", "Steady"),
    "noisy": ("warning", "Noisy"),
    "clipped": ("warning", "Off the scale"),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Cue:
    """The large part of the page: one number, one action.

    Attributes
    ----------
    title, place : str
        The instrument, and the how-manieth it is.
    lead : str
        Above the number: what it is.
    big : str
        The number, or a word.
    beside : str
        What the number means on the aircraft.
    wanted : bool
        Whether it is a target, in the color of targets.
    state : str
        Of the volts: sign and color.
    state_words : str
        The same in words.
    now, volts : str
        As measured at this moment.
    prompt : str
        What to do now.
    message : str
        What just happened.
    progress : float
        0 to 1.
    """

    title: str = ""
    place: str = ""
    lead: str = ""
    big: str = ""
    beside: str = ""
    wanted: bool = False
    state: State = "unknown"
    state_words: str = ""
    now: str = ""
    volts: str = ""
    prompt: str = ""
    message: str = ""
    progress: float = 0.0

    @property
    def words(self) -> str:
        """Return all of it for those who hear it."""
        parts = (self.title, self.lead, self.big, self.beside, self.state_words, self.prompt)
        return ", ".join(part for part in parts if part)


def quantity_text(value: float | None, unit: str, decimals: int | None = None) -> str:
    """Return a value with its unit: ``−20°``, ``0.12 g``.

    Without `decimals` it gets as many digits as it has.
    """
    if value is None or not math.isfinite(value):
        return DASH
    if decimals is None:
        decimals = len(f"{value:g}".partition(".")[2])
    shown = unit_text(unit)
    gap = "" if shown == "°" else " "
    return f"{number_text(value, decimals)}{gap}{shown}".rstrip()


def decimals_of(instrument: InstrumentPlan) -> int:
    """Return the digits after the point that an instrument earns in the unit of its plan."""
    return channel(instrument.channel).decimals(instrument.unit)


def volts_text(volts: float | None) -> str:
    """Return volts to the millivolt, which is what a 12-bit converter tells apart."""
    if volts is None or not math.isfinite(volts):
        return f"{DASH} V"
    return f"{number_text(volts, 3)} V"


def watch_words(reading: WatchReading | None) -> tuple[State, str]:
    """Return sign and words of what is known of the volts."""
    if reading is None:
        return "warning", "No signal"
    return _WATCH[reading.state]


def cue_of(view: WizardView) -> Cue:
    """Return the large part of the page for a view."""
    instrument = view.instrument
    if instrument is None:
        return _closing_cue(view)
    state, words = watch_words(view.reading)
    volts = None if view.reading is None or state == "unknown" else view.reading.volts
    lead, big, beside, wanted = _big(view, instrument)
    return Cue(
        title=instrument.title,
        place=f"{view.index + 1} of {view.count}",
        lead=lead,
        big=big,
        beside=beside,
        wanted=wanted,
        state=state,
        state_words=words,
        now=quantity_text(view.value_now, instrument.unit, decimals_of(instrument)),
        volts=volts_text(volts),
        prompt=view.prompt,
        message=view.message,
        progress=view.progress,
    )


def _closing_cue(view: WizardView) -> Cue:
    done = view.phase == "done"
    return Cue(
        title="Calibration",
        big="Done" if done else "Broken off" if view.phase == "aborted" else "Ready",
        prompt=view.prompt,
        message=view.message,
        progress=view.progress,
    )


def _big(view: WizardView, instrument: InstrumentPlan) -> tuple[str, str, str, bool]:
    """Return what stands above the number, the number, beside it; and whether it is wanted."""
    if view.phase == "sign":
        return "Move it", instrument.positive, "", True
    if view.phase == "fit":
        calibration = view.calibration
        if calibration is None:
            return "Points", str(len(view.points)), "", False
        width = calibration.quality.uncertainty
        text = "known to no bound" if width is None else f"±{_size(width, instrument)}"
        return "Any angle within (95 %)", text, curve_words(calibration.degree), False
    if view.target is None:
        return "", DASH, "", False
    side = instrument.positive if view.target > 0.0 else instrument.negative
    return (
        "Set it to",
        quantity_text(view.target, instrument.unit),
        side if view.target else "neutral",
        True,
    )


def _size(value: float | None, instrument: InstrumentPlan) -> str:
    """Return the size of an error with two digits after the point more than nothing."""
    return quantity_text(value, instrument.unit, decimals_of(instrument) + 1)


def curve_words(degree: int) -> str:
    """Return the name of a curve of a degree."""
    return {1: "straight line", 2: "quadratic", 3: "cubic"}[degree]


# Points


def point_rows(view: WizardView) -> tuple[PointRow, ...]:
    """Return the points taken, then the settings still to come."""
    instrument = view.instrument
    if instrument is None:
        return ()
    calibration = view.calibration
    residuals = calibration.fit.residuals if calibration is not None else ()
    if len(residuals) != len(view.points):
        residuals = ()
    largest = max((abs(residual) for residual in residuals), default=0.0) or 1.0
    odd = calibration.quality.outliers if calibration is not None else ()
    rows = [
        PointRow(
            value=quantity_text(point.value, instrument.unit),
            way=way_of(instrument, point.direction),
            volts=volts_text(point.volts),
            residual=_signed(residuals[at], instrument) if residuals else "",
            share=residuals[at] / largest if residuals else 0.0,
            remark="outlier" if at in odd else "",
            index=at,
        )
        for at, point in enumerate(view.points)
    ]
    rows += [
        PointRow(
            value=quantity_text(slot.value, instrument.unit),
            way=way_of(instrument, slot.direction),
            current=at == 0 and view.phase == "points",
        )
        for at, slot in enumerate(view.remaining)
    ]
    return tuple(rows)


def way_of(instrument: InstrumentPlan, direction: str) -> str:
    """Return how the trailing edge moves on the way to larger or to smaller values, one word."""
    towards = {"up": instrument.positive, "down": instrument.negative}.get(direction, "")
    return towards.rpartition(" ")[2]


def _signed(value: float, instrument: InstrumentPlan) -> str:
    text = _size(value, instrument)
    return text if text.startswith(MINUS) else f"+{text}"


def quality_lines(view: WizardView) -> tuple[tuple[str, str], ...]:
    """Return what the curve is worth: names and values."""
    instrument, calibration = view.instrument, view.calibration
    if instrument is None or calibration is None:
        return ()
    quality = calibration.quality
    lines = [
        ("Curve", curve_words(calibration.degree) + (", chosen" if view.degree else "")),
        ("Any angle within (95 %)", f"±{_size(quality.uncertainty, instrument)}"),
        ("Hysteresis", _size(quality.hysteresis, instrument)),
        ("Return to zero", _size(quality.return_to_zero, instrument)),
        ("Off a straight line", _size(quality.linearity, instrument)),
        ("One count of the converter", _size(quality.resolution, instrument)),
    ]
    if quality.coverage is not None:
        lines.append(("Of the travel", f"{100 * quality.coverage:.0f} %"))
    return tuple((name, value) for name, value in lines if DASH not in value)


# The aircraft


def figure_of(view: WizardView) -> SurfaceFigure | None:
    """Return the aircraft with the surface as it stands now."""
    instrument = view.instrument
    if instrument is None or not instrument.by_hand:
        return None
    where = instrument.positive.rpartition(" ")[2]
    settings = [slot.value for slot in view.remaining] + [point.value for point in view.points]
    return SurfaceFigure(
        channel=instrument.channel,
        title=instrument.title,
        view="above" if where in ("left", "right") else "side",
        kind="vane" if instrument.kind == "vane" else "surface",
        sense=1 if where in ("down", "left") else -1,
        ticks=tuple(sorted({*instrument.settings, *settings})),
        angle=view.value_now,
        target=_pictured_target(view, instrument),
    )


def _pictured_target(view: WizardView, instrument: InstrumentPlan) -> float | None:
    """Return where the surface is wanted; while its sign is proven, well to the positive side."""
    if view.phase == "sign":
        return max(instrument.settings)
    return view.target if view.phase == "points" else None


# Actions

_OFFERS: tuple[tuple[str, str, str], ...] = (
    ("confirm_sign", "It did move so", "Space"),
    ("take", "Take it now", "Space"),
    ("accept", "Accept", "Space"),
    ("undo", "Undo", "Backspace"),
    ("repeat", "Repeat the point", "R"),
    ("delete", "Delete the point", "Delete"),
    ("add", "Add a setting", "A"),
    ("choose_degree", "Curve 1, 2, 3; 0 finds out", ""),
    ("next", "Leave this for later", "PgDown"),
    ("back", "Instrument before", "PgUp"),
    ("skip", "Skip: uncalibrated", "X"),
    ("abort", "Break off", "Esc"),
)


def offers_of(view: WizardView) -> tuple[Offer, ...]:
    """Return what can be done now, the wanted one first."""
    found = []
    free = {"Space"}
    for name, text, key in _OFFERS:
        if name not in view.can or (key == "Space" and key not in free):
            continue
        if key == "Space":
            free.clear()
        words = "Leave this setting out" if name == "next" and view.phase == "points" else text
        found.append(Offer(id=name, text=words, key=key, first=key == "Space"))
    return tuple(found)


def remarks_of(view: WizardView) -> tuple[str, ...]:
    """Return what the crew should not pass over: faults, outliers, a drift beyond chance."""
    said = list(view.sentences)
    drift = view.drift
    if drift is not None and drift.significant and view.phase == "fit":
        said.append(drift.sentence)
    return tuple(f"{sentence[:1].upper()}{sentence[1:].rstrip('.')}." for sentence in said)


# The end


def outcomes_of(view: WizardView, plan: CalibrationPlan) -> tuple[Outcome, ...]:
    """Return what each instrument of the calibration came to."""
    found = []
    for instrument in plan.instruments:
        name = instrument.channel
        certificate = view.certificates.get(name)
        if name in view.skipped:
            found.append(
                Outcome(
                    title=instrument.title, words=f"uncalibrated: {view.skipped[name]}", good=False
                )
            )
        elif certificate is not None:
            width = certificate.quality.uncertainty if certificate.quality is not None else None
            within = "" if width is None else f", any angle within ±{_size(width, instrument)}"
            words = (
                f"{curve_words(certificate.degree)}{within}, "
                f"hysteresis {_size(certificate.hysteresis, instrument)}"
            )
            found.append(Outcome(title=instrument.title, words=words, good=True))
    return tuple(found)


_TOGETHER = (
    ("Elevator", ("elevator_left", "elevator_right"), "de", "mean of left and right (6.1.1)"),
    ("Aileron", ("aileron_left", "aileron_right"), "da", "mean, both rolling right (6.1.2)"),
    ("Rudder", ("rudder",), "dr", "as measured (6.1.3)"),
)


def together_of(history: History | None) -> tuple[Together, ...]:
    """Return the deflections as the open flight has them now."""
    if history is None:
        return ()
    found = []
    for title, parts, whole, rule in _TOGETHER:
        if all(history.has(name) for name in (*parts, whole)):
            shown = [f"{_side_of(name)}{_latest(history, name)}" for name in parts]
            symbol = symbol_text(channel(whole).symbol)
            found.append(
                Together(
                    title=title,
                    parts="   ".join(shown),
                    whole=f"{symbol} = {_latest(history, whole)}",
                    rule=rule,
                )
            )
    return tuple(found)


def _side_of(name: str) -> str:
    side = name.rpartition("_")[2]
    return f"{side} " if side in ("left", "right") else ""


def _latest(history: History, name: str) -> str:
    last = history.last(name)
    spec = channel(name)
    if last is None or history.end is None or last[0] < history.end - _STALE:
        return DASH
    unit = spec.display_unit("US")
    return quantity_text(from_si(last[1], unit, spec.quantity), unit, spec.decimals(unit))
