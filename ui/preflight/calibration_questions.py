"""What a calibration asks before it does something: reasons, numbers, and whether it is meant."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from calibration.wizard import WizardAction
from gsapp.quantities import channel, to_si
from ui.number_format import parse_number, unit_text
from ui.preflight.question_bar import QuestionBar
from ui.preflight.wizard_controller import WizardController
from ui.translation import tr

_PRESSURE = channel("static_pressure").quantity
_TEMPERATURE = channel("temperature").quantity
_FIT_ORDERS: Mapping[str, int | None] = {"0": None, "1": 1, "2": 2, "3": 3}


class CalibrationQuestions:
    """Asks for the crew's action what must be known for it.

    Parameters
    ----------
    bar : QuestionBar
        Where it is asked.
    units : callable
        Returns the units of the screen, ``US`` or ``SI``.
    """

    def __init__(self, bar: QuestionBar, units: Callable[[], str]) -> None:
        self._bar = bar
        self._units = units
        self._asking: Mapping[str, Callable[[WizardController], None]] = {
            "skip": self._skip,
            "add": self._add,
            "abort": self._abort,
            "choose_degree": self._degree,
            "enter": self._air,
        }

    def needs_question(self, name: str) -> bool:
        """Return whether an action needs a question."""
        return name in self._asking

    def ask(self, name: str, run: WizardController) -> None:
        """Ask, then act."""
        self._asking[name](run)

    def _skip(self, run: WizardController) -> None:
        full = run.view.mode == "full"
        self._bar.ask(
            tr("Leave this instrument {state}? Give the reason.").format(
                state=tr("uncalibrated") if full else tr("unchecked")
            ),
            lambda reason: run.perform(WizardAction(kind="skip", reason=reason)),
            typed=True,
            yes=tr("Skip"),
            text=tr("not calibrated today") if full else tr("not today"),
        )

    def _add(self, run: WizardController) -> None:
        instrument = run.view.instrument
        if instrument is None:
            return

        def add(text: str) -> None:
            value = parse_number(text)
            if value is not None:
                run.perform(WizardAction(kind="add", value=value))

        question = tr("Which further setting, in {unit}?").format(unit=instrument.unit)
        self._bar.ask(question, add, typed=True, yes=tr("Add"), wrong=_no_number)

    def _abort(self, run: WizardController) -> None:
        full = run.view.mode == "full"
        self._bar.ask(
            tr("Stop the calibration? Accepted certificates stay in force.")
            if full
            else tr("Stop the check? The certificates stay in force."),
            lambda _: run.perform(WizardAction(kind="abort")),
            typed=False,
            yes=tr("Stop"),
        )

    def _air(self, run: WizardController) -> None:
        metric = self._units() == "SI"
        unit, degrees = ("hPa", "degC") if metric else ("inHg", "degF")

        def pressure_entered(text: str) -> None:
            value = parse_number(text)
            if value is None:
                return
            pressure = to_si(value, unit, _PRESSURE)
            self._bar.ask(
                tr("Temperature of the air in the shade, in {degrees}?").format(
                    degrees=unit_text(degrees)
                ),
                lambda typed: self._air_entered(run, pressure, typed, degrees),
                typed=True,
                yes=tr("Enter"),
                wrong=_no_number,
            )

        question = tr("Pressure at the field, not reduced to sea level, in {unit}?").format(
            unit=unit
        )
        self._bar.ask(question, pressure_entered, typed=True, yes=tr("Go on"), wrong=_no_number)

    @staticmethod
    def _air_entered(run: WizardController, pressure: float, typed: str, degrees: str) -> None:
        value = parse_number(typed)
        if value is not None:
            temperature = to_si(value, degrees, _TEMPERATURE)
            run.perform(WizardAction(kind="enter", pressure=pressure, temperature=temperature))

    def _degree(self, run: WizardController) -> None:
        def choose(text: str) -> None:
            if text in _FIT_ORDERS:
                run.perform(WizardAction(kind="choose_degree", degree=_FIT_ORDERS[text]))

        question = tr("Fit order: 1, 2, 3, or 0 for automatic")
        self._bar.ask(
            question,
            choose,
            typed=True,
            yes=tr("Apply"),
            text="0",
            wrong=lambda text: (
                "" if text in _FIT_ORDERS else tr("'{text}' is not a choice.").format(text=text)
            ),
        )


def _no_number(text: str) -> str:
    """Return that something typed is no number; nothing if it is one."""
    return (
        "" if parse_number(text) is not None else tr("'{text}' is not a number.").format(text=text)
    )
