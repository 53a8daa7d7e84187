"""What the wizard's page says of a view: one number, one action, and what can be done."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from calibration.settings import FIT_ORDER_TITLES
from gsapp.quantities import channel
from ui.icons import IndicatorState
from ui.number_format import DASH, MINUS, number_text, unit_text
from ui.translation import QT_TR_NOOP, tr
from ui.widgets.action_button import ActionItem

if TYPE_CHECKING:
    from calibration.drift import CheckResult
    from calibration.plan import CalibrationPlan, InstrumentPlan
    from calibration.voltage_monitor import VoltageReading
    from calibration.wizard import WizardView

_READING_STATES: dict[str, tuple[IndicatorState, str]] = {
    "absent": ("warning", QT_TR_NOOP("No signal")),
    "moving": ("caution", QT_TR_NOOP("Moving")),
    "steady": ("good", QT_TR_NOOP("Steady")),
    "noisy": ("warning", QT_TR_NOOP("Noisy")),
    "clipped": ("warning", QT_TR_NOOP("Signal clipped")),
}
_STATIONARY_PHASES = frozenset({"gyro_still", "accel_position", "pressure_zero"})
"""Phases in which something is to be left alone for a while."""


@dataclass(frozen=True, slots=True, kw_only=True)
class WizardPrompt:
    """The large part of the page: one number, one action."""

    title: str = ""
    position_text: str = ""
    """The instrument, and the how-manieth it is."""
    caption: str = ""
    """Above the number: what it is."""
    main_text: str = ""
    """The number, or a word."""
    side_text: str = ""
    """What the number means on the aircraft."""
    is_target: bool = False
    """Whether it is a target, in the color of targets."""
    state: IndicatorState = "unknown"
    """Of the volts: sign and color."""
    state_text: str = ""
    """The same in words."""
    value_text: str = ""
    volts_text: str = ""
    """As measured at this moment."""
    prompt: str = ""
    """What to do now."""
    message: str = ""
    """What just happened."""
    progress: float = 0.0
    """0 to 1."""

    @property
    def accessible_text(self) -> str:
        parts = (
            self.title,
            self.caption,
            self.main_text,
            self.side_text,
            self.state_text,
            self.prompt,
        )
        return ", ".join(part for part in parts if part)


# Numbers


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


def instrument_decimals(instrument: InstrumentPlan) -> int:
    """Return the digits after the point that an instrument earns in the unit of its plan."""
    return channel(instrument.channel).decimals(instrument.unit)


def error_text(value: float | None, instrument: InstrumentPlan) -> str:
    """Return the size of an error, with one digit more than the instrument itself earns."""
    return quantity_text(value, instrument.unit, instrument_decimals(instrument) + 1)


def signed_error_text(value: float, instrument: InstrumentPlan) -> str:
    """Return a difference, with its sign."""
    return _add_sign(error_text(value, instrument))


def _add_sign(text: str) -> str:
    return text if text.startswith((MINUS, DASH)) else f"+{text}"


def describe_shift(check: CheckResult, instrument: InstrumentPlan) -> tuple[str, str]:
    """Return what a check tells of, ``zero`` or ``slope``, and by how much it moved.

    Of a certificate that does not hold, what is farther beyond its own bound.
    """
    beyond = abs(check.slope) * check.zero_uncertainty > abs(check.zero) * check.slope_uncertainty
    if beyond and not check.passed:
        return tr("slope"), _add_sign(f"{number_text(100.0 * check.slope, 1)} %")
    return tr("zero"), signed_error_text(check.zero, instrument)


def volts_text(volts: float | None) -> str:
    """Return volts to the millivolt, which is what a 12-bit converter tells apart."""
    if volts is None or not math.isfinite(volts):
        return f"{DASH} V"
    return f"{number_text(volts, 3)} V"


# The large part


def describe_reading(reading: VoltageReading | None) -> tuple[IndicatorState, str]:
    """Return sign and words of what is known of the volts."""
    if reading is None:
        return "warning", tr("No signal")
    if math.isnan(reading.time):
        # Of an instrument that was just turned to nothing is known yet.
        return "unknown", tr("Waiting")
    state, text = _READING_STATES[reading.state]
    return state, tr(text)


def build_prompt(view: WizardView, *, catching_up: bool = False) -> WizardPrompt:
    """Return the large part of the page for a view.

    Parameters
    ----------
    catching_up : bool
        Whether the flight is still being read: no volts are no fault then.
    """
    instrument = view.instrument
    if instrument is None:
        return WizardPrompt(title=tr("Calibration"), prompt=view.prompt, message=view.message)
    state, text = _prompt_state(view)
    if view.reading is None and instrument.is_angle_sensor and catching_up:
        state, text = "unknown", tr("Catching up")
    lead, big, beside, wanted = _main_texts(view, instrument)
    now = volts = ""
    if view.reading is not None:
        now = quantity_text(view.current_value, instrument.unit, instrument_decimals(instrument))
        volts = volts_text(view.reading.volts)
    return WizardPrompt(
        title=_prompt_title(view, instrument),
        position_text=tr("{index} of {count}").format(index=view.index + 1, count=view.count),
        caption=lead,
        main_text=big,
        side_text=beside,
        is_target=wanted,
        state=state,
        state_text=text,
        value_text=now,
        volts_text=volts,
        prompt=view.prompt,
        message=view.message,
        progress=view.progress,
    )


def _prompt_title(view: WizardView, instrument: InstrumentPlan) -> str:
    """Return what is calibrated; gyros, accelerometers and pressures are so together."""
    together = {
        "gyro": tr("Gyros"),
        "accelerometer": tr("Accelerometers"),
        "pressure": tr("Pressures"),
    }
    if view.phase in _STATIONARY_PHASES or view.phase == "fit":
        return together.get(instrument.kind, instrument.title)
    return instrument.title


def _prompt_state(view: WizardView) -> tuple[IndicatorState, str]:
    instrument = view.instrument
    if instrument is not None and instrument.is_angle_sensor:
        return describe_reading(view.reading)
    if view.phase in _STATIONARY_PHASES:
        return ("good", tr("Still")) if view.amount else ("caution", tr("Not steady"))
    if view.phase == "gyro_turn":
        return ("caution", tr("Turning")) if view.amount else ("good", tr("Ready"))
    if view.phase == "fit":
        return ("caution", tr("Check direction")) if view.problems else ("good", tr("Good"))
    return "unknown", tr("Waiting")


def _main_texts(view: WizardView, instrument: InstrumentPlan) -> tuple[str, str, str, bool]:
    """Return what stands above the number, the number, beside it; and whether it is wanted."""
    goal = quantity_text(view.amount_goal, view.amount_unit)
    if view.phase == "sign":
        return tr("Move it"), instrument.positive, "", True
    if view.phase == "fit":
        return _result_texts(view, instrument)
    if view.phase == "gyro_turn":
        way = instrument.positive if (view.target or 0.0) > 0.0 else instrument.negative
        return (
            tr("Turned so far"),
            quantity_text(view.amount, "deg", 0),
            tr("of {goal} {way}").format(goal=goal, way=way),
            False,
        )
    if view.phase == "pressure_blow":
        return tr("Breath"), quantity_text(view.amount, view.amount_unit, 0), "", False
    if view.phase in _STATIONARY_PHASES:
        return (
            tr("Still for"),
            quantity_text(view.amount, view.amount_unit, 1),
            tr("of {goal}").format(goal=goal),
            False,
        )
    if view.target is None:
        return "", DASH, "", False
    side = instrument.positive if view.target > 0.0 else instrument.negative
    shown = quantity_text(view.target, instrument.unit)
    return tr("Set to"), shown, side if view.target else tr("neutral"), True


def _result_texts(view: WizardView, instrument: InstrumentPlan) -> tuple[str, str, str, bool]:
    check, calibration = view.check_result, view.calibration
    if check is not None:
        holds = tr("certificate valid") if check.passed else tr("calibrate again")
        what, size = describe_shift(check, instrument)
        return tr("The {what} has moved by").format(what=what), size, holds, False
    if calibration is None:
        return "", tr("Look") if view.problems else tr("Good"), "", False
    width = calibration.quality.uncertainty
    text = tr("no bound") if width is None else f"±{error_text(width, instrument)}"
    return tr("Uncertainty (95 %)"), text, tr(FIT_ORDER_TITLES[calibration.degree]), False


# Actions

_WIZARD_ACTIONS: tuple[tuple[str, str, str], ...] = (
    ("confirm_sign", QT_TR_NOOP("Direction correct"), "Space"),
    ("take", QT_TR_NOOP("Record now"), "Space"),
    ("accept", QT_TR_NOOP("Accept"), "Space"),
    ("undo", QT_TR_NOOP("Undo"), "Backspace"),
    ("repeat", QT_TR_NOOP("Repeat {what}"), "R"),
    ("delete", QT_TR_NOOP("Delete {what}"), "Delete"),
    ("add", QT_TR_NOOP("Add a setting"), "A"),
    ("choose_degree", QT_TR_NOOP("Fit order: auto, 1, 2, 3"), "D"),
    ("enter", QT_TR_NOOP("Field air"), "E"),
    ("next", QT_TR_NOOP("Later"), "PgDown"),
    ("back", QT_TR_NOOP("Previous instrument"), "PgUp"),
    ("skip", QT_TR_NOOP("Skip: uncalibrated"), "X"),
    ("abort", QT_TR_NOOP("Stop"), "Esc"),
)
_ACTION_OBJECTS: Mapping[str, str] = {
    "gyro": QT_TR_NOOP("the turn"),
    "accelerometer": QT_TR_NOOP("the position"),
    "pressure": QT_TR_NOOP("from zero"),
}
_PHASE_ACTION_TEXTS: Mapping[tuple[str, str], str] = {
    ("begin", "next"): QT_TR_NOOP("Start now"),
    ("points", "next"): QT_TR_NOOP("Skip this setting"),
    ("gyro_turn", "next"): QT_TR_NOOP("Skip this turn"),
    ("pressure_blow", "next"): QT_TR_NOOP("Without a breath"),
    ("pressure_zero", "take"): QT_TR_NOOP("Covered"),
    ("accel_position", "take"): QT_TR_NOOP("In position"),
}
"""Words of an action in a phase where they are others."""

PRACTICE_ACTION = ActionItem(
    id="practice", text=QT_TR_NOOP("Practice without an aircraft"), key="P"
)
PRINT_ACTION = ActionItem(id="paper", text=QT_TR_NOOP("Print certificates"), key="W")
_KIND_NAMES = {"accelerometer": QT_TR_NOOP("accelerometers"), "pressure": QT_TR_NOOP("pressures")}
"""Several instruments of a kind that are calibrated in the same steps."""


def build_start_actions(
    plan: CalibrationPlan | None, chosen: str, *, left: bool, made: bool
) -> tuple[ActionItem, ...]:
    """Return what can be begun; the wanted one first, by Space.

    Parameters
    ----------
    plan : CalibrationPlan or None
        Of the instrument selected and those that go with it; None where none is.
    left : bool
        Whether a calibration was not finished.
    made : bool
        Whether there are certificates to print.
    """
    offers = [
        ActionItem(id="calibrate", text=tr("Surfaces and vanes"), key="N"),
        ActionItem(id="others", text=tr("Gyros, accelerometers, pressures"), key="G"),
        ActionItem(id="check", text=tr("Check in a minute"), key="C"),
        PRACTICE_ACTION,
    ]
    if made:
        offers.append(PRINT_ACTION)
    if left:
        offers.insert(0, ActionItem(id="resume", text=tr("Resume"), key="R"))
    if plan is not None:
        one = plan[chosen]
        several = len(plan.instruments) > 1
        text = tr(_KIND_NAMES[one.kind]) if several else one.title.lower()
        offers.insert(0, ActionItem(id="again", text=tr("Calibrate {text}").format(text=text)))
    first, *others = offers
    return (ActionItem(id=first.id, text=first.text, key="Space", is_default=True), *others)


_CHECK_ACTION_TEXTS: Mapping[str, str] = {"skip": QT_TR_NOOP("Skip: not checked")}
"""Words of an action where certificates are only checked."""


def build_wizard_actions(view: WizardView) -> tuple[ActionItem, ...]:
    """Return what can be done now, the wanted one first."""
    found: list[ActionItem] = []
    what = (
        tr(_ACTION_OBJECTS.get(view.instrument.kind, QT_TR_NOOP("the point")))
        if view.instrument is not None
        else ""
    )
    wanted = False
    for name, usual, key in _WIZARD_ACTIONS:
        if name not in view.available_actions or (key == "Space" and wanted):
            continue
        wanted = wanted or key == "Space"
        words = _CHECK_ACTION_TEXTS.get(name, usual) if view.mode == "check" else usual
        text = tr(_PHASE_ACTION_TEXTS.get((view.phase, name), words)).format(what=what)
        found.append(ActionItem(id=name, text=text, key=key, is_default=key == "Space"))
        if name == "confirm_sign":
            found.append(ActionItem(id="deny_sign", text=tr("Direction reversed"), key="N"))
    return tuple(found)
