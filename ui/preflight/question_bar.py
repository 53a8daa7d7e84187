"""What a calibration asks in a line above the actions: a reason, a number, or yes and no."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from PySide6.QtCore import Qt
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QFrame, QHBoxLayout, QLineEdit, QPushButton, QSizePolicy, QWidget

from calibration.wizard import WizardAction
from gsapp.quantities import channel, to_si
from ui.display_style import DisplayStyle
from ui.number_format import parse_number, unit_text
from ui.preflight.wizard_controller import WizardController
from ui.translation import QT_TR_NOOP, tr
from ui.widgets.labels import create_label


def _accept_any(_text: str) -> str:
    return ""


class QuestionBar(QFrame):
    """Asks, and gives the answer to whoever asked; Enter answers, Esc takes the question back.

    Parameters
    ----------
    leave : callable
        Called when the question is gone: the keyboard goes back to the page.
    behind : QWidget
        Hidden while something is asked: its keys do nothing then.
    """

    def __init__(self, style: DisplayStyle, leave: Callable[[], object], behind: QWidget) -> None:
        super().__init__()
        self._style = style
        self._leave = leave
        self._behind = behind
        self._answer: Callable[[str], object] | None = None
        self._asked = ""
        self._wrong: Callable[[str], str] = _accept_any
        self.setObjectName("banner")
        self._row = QHBoxLayout(self)
        self.question = create_label("", "strong", wrap=True)
        self._row.addWidget(self.question, 1)
        self.field = QLineEdit()
        self._row.addWidget(self.field, 1)
        high = QSizePolicy.Policy.Expanding
        self.field.setSizePolicy(high, high)
        self.yes = QPushButton()
        self.yes.setProperty("role", "primary")
        self.no = QPushButton(tr("No   Esc"))
        for button, act in ((self.yes, self.accept), (self.no, self.cancel)):
            button.clicked.connect(act)
            button.setSizePolicy(QSizePolicy.Policy.Preferred, high)
            self._row.addWidget(button)
        style.changed.connect(self._restyle)
        self._restyle()
        self.hide()

    def _restyle(self) -> None:
        px = self._style.px
        self._row.setContentsMargins(px(16), px(6), px(16), px(6))
        self._row.setSpacing(px(8))
        self.setMinimumHeight(self._style.sizes.control + px(12))

    @property
    def is_open(self) -> bool:
        return self._answer is not None

    def ask(
        self,
        question: str,
        answer: Callable[[str], object],
        *,
        typed: bool,
        yes: str = QT_TR_NOOP("Yes"),
        text: str = "",
        wrong: Callable[[str], str] = _accept_any,
    ) -> None:
        """Ask a question.

        Parameters
        ----------
        answer : callable
            Takes what was typed; not called if the question is taken back.
        wrong : callable
            Says in a sentence why what was typed is no answer, else nothing; the question stays.
            By default anything is one.
        """
        self._answer = answer
        self._asked = question
        self._wrong = wrong
        self.question.setText(question)
        self.field.setVisible(typed)
        self.field.setText(text)
        self.field.setAccessibleName(question)
        self.yes.setText(tr("{yes}   Enter").format(yes=yes))
        self._behind.hide()
        self.show()
        if typed:
            self.field.setFocus(Qt.FocusReason.OtherFocusReason)
            self.field.selectAll()
        else:
            self.yes.setFocus(Qt.FocusReason.OtherFocusReason)

    def accept(self) -> None:
        """Give the answer."""
        answer, text = self._answer, self.field.text().strip()
        if answer is not None and (problem := self._wrong(text)):
            self.question.setText(f"{problem} {self._asked}")
            self.field.setFocus(Qt.FocusReason.OtherFocusReason)
            self.field.selectAll()
            return
        self.cancel()
        if answer is not None:
            answer(text)

    def cancel(self) -> None:
        """Take the question back."""
        self._answer = None
        self.hide()
        self._behind.show()
        self._leave()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            self.accept()
        elif event.key() == Qt.Key.Key_Escape:
            self.cancel()
        event.accept()


_PRESSURE = channel("static_pressure").quantity
_TEMPERATURE = channel("temperature").quantity
_FIT_ORDERS: Mapping[str, int | None] = {"0": None, "1": 1, "2": 2, "3": 3}


class CalibrationQuestions:
    """Asks for the crew's action what must be known for it."""

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
        self._bar.ask(question, pressure_entered, typed=True, yes=tr("Continue"), wrong=_no_number)

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
    return (
        "" if parse_number(text) is not None else tr("'{text}' is not a number.").format(text=text)
    )
