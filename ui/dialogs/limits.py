"""Typing the limits of a channel."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

from PySide6.QtWidgets import QDialogButtonBox, QLineEdit, QWidget

from gsapp.quantities import ChannelSpec, from_si, to_si
from gsapp.session import LimitBands
from ui.dialogs.flight_requests import InputCheck
from ui.dialogs.form_dialog import FieldMessage, FormDialog
from ui.display_style import DisplayStyle
from ui.number_format import parse_number, unit_text
from ui.translation import QT_TR_NOOP, tr

_FIELDS = (
    ("warning_high", QT_TR_NOOP("Warning above")),
    ("caution_high", QT_TR_NOOP("Caution above")),
    ("caution_low", QT_TR_NOOP("Caution below")),
    ("warning_low", QT_TR_NOOP("Warning below")),
)
"""From the highest to the lowest, as they stand on the chart."""


class LimitsDialog(FormDialog):
    """Asks for the limits of a channel; an empty field is no limit.

    `bands`: the limits in force, SI. `typed`: whether they were typed before, so that there is
    something to take back.
    """

    def __init__(
        self,
        style: DisplayStyle,
        spec: ChannelSpec,
        bands: LimitBands,
        *,
        typed: bool,
        parent: QWidget | None = None,
    ) -> None:
        self._spec = spec
        self._unit = spec.display_unit(style.units)
        shown = tr(" in {unit}").format(unit=unit_text(self._unit)) if self._unit else ""
        super().__init__(
            tr("Limits"),
            tr(
                "{title}{shown}. Leave a field empty for no limit. These limits apply to all "
                "flights on this computer until reset."
            ).format(title=spec.title, shown=shown),
            tr("Set"),
            style,
            parent,
        )
        self._before = {name: self._text(getattr(bands, name)) for name, _words in _FIELDS}
        self._bands = bands
        self.edits = {name: QLineEdit(self._before[name]) for name, _words in _FIELDS}
        self.message = FieldMessage()
        for name, text in _FIELDS:
            below = self.message if name == _FIELDS[-1][0] else None
            self.add_row(tr(text), self.edits[name], below)
            self.edits[name].textChanged.connect(self._validate)
        self.reset = self.buttons.addButton(
            tr("Reset to the aircraft file"), QDialogButtonBox.ButtonRole.ResetRole
        )
        self.reset.setEnabled(typed)
        self.reset.clicked.connect(self._use_defaults)
        self._defaults_requested = False
        next(iter(self.edits.values())).selectAll()
        self._validate()
        self.fit_to_content(480)

    def _text(self, value: float | None) -> str:
        if value is None:
            return ""
        return f"{from_si(value, self._unit, self._spec.quantity):.6g}"

    def _use_defaults(self) -> None:
        self._defaults_requested = True
        self.accept()

    def _validate(self) -> None:
        verdict = check_limits(
            [edit.text().strip() for edit in self.edits.values()],
            self._spec.limits,
            lambda value: to_si(value, self._unit, self._spec.quantity),
        )
        self.message.set_message(verdict.message, verdict.state)
        self.button.setEnabled(verdict.is_valid)

    def _value(self, name: str) -> float | None:
        text = self.edits[name].text().strip()
        if text == self._before[name]:
            # What was not touched keeps all its digits.
            value: float | None = getattr(self._bands, name)
            return value
        number = parse_number(text)
        return None if number is None else to_si(number, self._unit, self._spec.quantity)

    @property
    def limits(self) -> LimitBands | None:
        """Return the limits as typed, SI; None for those of the aircraft."""
        if self._defaults_requested:
            return None
        return LimitBands(**{name: self._value(name) for name, _words in _FIELDS})


def check_limits(
    texts: list[str], ends: tuple[float, float], to_inside: Callable[[float], float]
) -> InputCheck:
    """Return what is to be said of four limits as they are typed, the highest first.

    `texts`: as typed; empty is no limit. `ends`: what an instrument can show at all, SI.
    `to_inside`: from the unit of the screen to SI.
    """
    numbers = [parse_number(text) for text in texts if text]
    if not numbers:
        return InputCheck(message=tr("No limits: no bands, and no alarm."), state="caution")
    known = [number for number in numbers if number is not None]
    if len(known) < len(numbers):
        return InputCheck(message=tr("Write numbers, such as 10 and -2.5."), state="warning")
    if any(one <= other for one, other in pairwise(known)):
        return InputCheck(
            message=tr("From top to bottom the limits must become smaller."), state="warning"
        )
    low, high = ends
    if any(not low <= to_inside(number) <= high for number in known):
        return InputCheck(
            message=tr("One limit is outside the instrument range: it is never reached."),
            state="caution",
        )
    return InputCheck(message=tr("Chart bands and alarms change at once."), state="good")
