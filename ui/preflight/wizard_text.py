"""What the wizard's page says of a view: one number, one action, and what can be done."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from calibration.polynomial_fit import FIT_ORDER_TITLES
from gsapp.quantities import channel
from ui.icons import IndicatorState
from ui.number_format import DASH, MINUS, number_text, unit_text
from ui.widgets.action_bar import ActionItem

if TYPE_CHECKING:
    from calibration.drift import CheckResult
    from calibration.plan import CalibrationPlan, InstrumentPlan
    from calibration.voltage_monitor import VoltageReading
    from calibration.wizard import WizardView

_READING_STATES: dict[str, tuple[IndicatorState, str]] = {
    "absent": ("warning", "No signal"),
    "moving": ("caution", "Moving"),
    "steady": ("good", "Steady"),
    "noisy": ("warning", "Noisy"),
    "clipped": ("warning", "Signal clipped"),
}
_STATIONARY_PHASES = frozenset({"gyro_still", "accel_position", "pressure_zero"})
"""Phases in which something is to be left alone for a while."""


@dataclass(frozen=True, slots=True, kw_only=True)
class WizardPrompt:
    """The large part of the page: one number, one action.

    Attributes
    ----------
    title, position_text : str
        The instrument, and the how-manieth it is.
    caption : str
        Above the number: what it is.
    main_text : str
        The number, or a word.
    side_text : str
        What the number means on the aircraft.
    is_target : bool
        Whether it is a target, in the color of targets.
    state : str
        Of the volts: sign and color.
    state_text : str
        The same in words.
    value_text, volts_text : str
        As measured at this moment.
    prompt : str
        What to do now.
    message : str
        What just happened.
    progress : float
        0 to 1.
    """

    title: str = ""
    position_text: str = ""
    caption: str = ""
    main_text: str = ""
    side_text: str = ""
    is_target: bool = False
    state: IndicatorState = "unknown"
    state_text: str = ""
    value_text: str = ""
    volts_text: str = ""
    prompt: str = ""
    message: str = ""
    progress: float = 0.0

    @property
    def accessible_text(self) -> str:
        """Return all of it for those who hear it."""
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
        return "slope", _add_sign(f"{number_text(100.0 * check.slope, 1)} %")
    return "zero", signed_error_text(check.zero, instrument)


def volts_text(volts: float | None) -> str:
    """Return volts to the millivolt, which is what a 12-bit converter tells apart."""
    if volts is None or not math.isfinite(volts):
        return f"{DASH} V"
    return f"{number_text(volts, 3)} V"


# The large part


def describe_reading(reading: VoltageReading | None) -> tuple[IndicatorState, str]:
    """Return sign and words of what is known of the volts."""
    if reading is None:
        return "warning", "No signal"
    if math.isnan(reading.time):
        # Of an instrument that was just turned to nothing is known yet.
        return "unknown", "Waiting"
    return _READING_STATES[reading.state]


def build_prompt(view: WizardView, *, catching_up: bool = False) -> WizardPrompt:
    """Return the large part of the page for a view.

    Parameters
    ----------
    view : WizardView
        Of the wizard.
    catching_up : bool
        Whether the flight is still being read: no volts are no fault then.
    """
    instrument = view.instrument
    if instrument is None:
        return WizardPrompt(title="Calibration", prompt=view.prompt, message=view.message)
    state, words = _prompt_state(view)
    if view.reading is None and instrument.is_angle_sensor and catching_up:
        state, words = "unknown", "Catching up"
    lead, big, beside, wanted = _main_texts(view, instrument)
    now = volts = ""
    if view.reading is not None:
        now = quantity_text(view.current_value, instrument.unit, instrument_decimals(instrument))
        volts = volts_text(view.reading.volts)
    return WizardPrompt(
        title=_prompt_title(view, instrument),
        position_text=f"{view.index + 1} of {view.count}",
        caption=lead,
        main_text=big,
        side_text=beside,
        is_target=wanted,
        state=state,
        state_text=words,
        value_text=now,
        volts_text=volts,
        prompt=view.prompt,
        message=view.message,
        progress=view.progress,
    )


def _prompt_title(view: WizardView, instrument: InstrumentPlan) -> str:
    """Return what is calibrated; gyros, accelerometers and pressures are so together."""
    together = {"gyro": "Gyros", "accelerometer": "Accelerometers", "pressure": "Pressures"}
    if view.phase in _STATIONARY_PHASES or view.phase == "fit":
        return together.get(instrument.kind, instrument.title)
    return instrument.title


def _prompt_state(view: WizardView) -> tuple[IndicatorState, str]:
    instrument = view.instrument
    if instrument is not None and instrument.is_angle_sensor:
        return describe_reading(view.reading)
    if view.phase in _STATIONARY_PHASES:
        return ("good", "Still") if view.amount else ("caution", "Not steady")
    if view.phase == "gyro_turn":
        return ("caution", "Turning") if view.amount else ("good", "Ready")
    if view.phase == "fit":
        return ("caution", "Check direction") if view.problems else ("good", "Good")
    return "unknown", "Waiting"


def _main_texts(view: WizardView, instrument: InstrumentPlan) -> tuple[str, str, str, bool]:
    """Return what stands above the number, the number, beside it; and whether it is wanted."""
    goal = quantity_text(view.amount_goal, view.amount_unit)
    if view.phase == "sign":
        return "Move it", instrument.positive, "", True
    if view.phase == "fit":
        return _result_texts(view, instrument)
    if view.phase == "gyro_turn":
        way = instrument.positive if (view.target or 0.0) > 0.0 else instrument.negative
        return "Turned so far", quantity_text(view.amount, "deg", 0), f"of {goal} {way}", False
    if view.phase == "pressure_blow":
        return "Breath", quantity_text(view.amount, view.amount_unit, 0), "", False
    if view.phase in _STATIONARY_PHASES:
        return "Still for", quantity_text(view.amount, view.amount_unit, 1), f"of {goal}", False
    if view.target is None:
        return "", DASH, "", False
    side = instrument.positive if view.target > 0.0 else instrument.negative
    shown = quantity_text(view.target, instrument.unit)
    return "Set to", shown, side if view.target else "neutral", True


def _result_texts(view: WizardView, instrument: InstrumentPlan) -> tuple[str, str, str, bool]:
    check, calibration = view.check_result, view.calibration
    if check is not None:
        holds = "certificate valid" if check.passed else "calibrate again"
        what, size = describe_shift(check, instrument)
        return f"The {what} has moved by", size, holds, False
    if calibration is None:
        return "", "Look" if view.problems else "Good", "", False
    width = calibration.quality.uncertainty
    text = "no bound" if width is None else f"±{error_text(width, instrument)}"
    return "Uncertainty (95 %)", text, FIT_ORDER_TITLES[calibration.degree], False


# Actions

_WIZARD_ACTIONS: tuple[tuple[str, str, str], ...] = (
    ("confirm_sign", "Direction correct", "Space"),
    ("take", "Record now", "Space"),
    ("accept", "Accept", "Space"),
    ("undo", "Undo", "Backspace"),
    ("repeat", "Repeat {what}", "R"),
    ("delete", "Delete {what}", "Delete"),
    ("add", "Add a setting", "A"),
    ("choose_degree", "Fit order: auto, 1, 2, 3", "D"),
    ("enter", "Field air", "E"),
    ("next", "Later", "PgDown"),
    ("back", "Previous instrument", "PgUp"),
    ("skip", "Skip: uncalibrated", "X"),
    ("abort", "Stop", "Esc"),
)
_ACTION_OBJECTS: Mapping[str, str] = {
    "gyro": "the turn",
    "accelerometer": "the position",
    "pressure": "from zero",
}
_PHASE_ACTION_TEXTS: Mapping[tuple[str, str], str] = {
    ("begin", "next"): "Start now",
    ("points", "next"): "Skip this setting",
    ("gyro_turn", "next"): "Skip this turn",
    ("pressure_blow", "next"): "Without a breath",
    ("pressure_zero", "take"): "Covered",
    ("accel_position", "take"): "In position",
}
"""Words of an action in a phase where they are others."""

PRACTICE_ACTION = ActionItem(id="practice", text="Practice without an aircraft", key="P")
PRINT_ACTION = ActionItem(id="paper", text="Print certificates", key="W")
_KIND_NAMES = {"accelerometer": "accelerometers", "pressure": "pressures"}
"""Several instruments of a kind that are calibrated in the same steps."""


def build_start_actions(
    plan: CalibrationPlan | None, chosen: str, *, left: bool, made: bool
) -> tuple[ActionItem, ...]:
    """Return what can be begun; the wanted one first, by Space.

    Parameters
    ----------
    plan : CalibrationPlan or None
        Of the instrument selected and those that go with it; None where none is.
    chosen : str
        Its channel.
    left : bool
        Whether a calibration was not finished.
    made : bool
        Whether there are certificates to print.
    """
    offers = [
        ActionItem(id="calibrate", text="Surfaces and vanes", key="N"),
        ActionItem(id="others", text="Gyros, accelerometers, pressures", key="G"),
        ActionItem(id="check", text="Check in a minute", key="C"),
        PRACTICE_ACTION,
    ]
    if made:
        offers.append(PRINT_ACTION)
    if left:
        offers.insert(0, ActionItem(id="resume", text="Resume", key="R"))
    if plan is not None:
        one = plan[chosen]
        several = len(plan.instruments) > 1
        text = _KIND_NAMES[one.kind] if several else one.title.lower()
        offers.insert(0, ActionItem(id="again", text=f"Calibrate {text}"))
    first, *others = offers
    return (ActionItem(id=first.id, text=first.text, key="Space", is_default=True), *others)


_CHECK_ACTION_TEXTS: Mapping[str, str] = {"skip": "Skip: not checked"}
"""Words of an action where certificates are only checked."""


def build_wizard_actions(view: WizardView) -> tuple[ActionItem, ...]:
    """Return what can be done now, the wanted one first."""
    found: list[ActionItem] = []
    what = (
        _ACTION_OBJECTS.get(view.instrument.kind, "the point")
        if view.instrument is not None
        else ""
    )
    wanted = False
    for name, usual, key in _WIZARD_ACTIONS:
        if name not in view.available_actions or (key == "Space" and wanted):
            continue
        wanted = wanted or key == "Space"
        words = _CHECK_ACTION_TEXTS.get(name, usual) if view.mode == "check" else usual
        text = _PHASE_ACTION_TEXTS.get((view.phase, name), words).format(what=what)
        found.append(ActionItem(id=name, text=text, key=key, is_default=key == "Space"))
        if name == "confirm_sign":
            found.append(ActionItem(id="deny_sign", text="Direction reversed", key="N"))
    return tuple(found)
