"""The panel of the estimate: every choice with a name, a sentence, and what is wrong with it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from PySide6.QtCore import QEvent, QObject, QTimer, Signal
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QGridLayout,
    QLineEdit,
    QVBoxLayout,
    QWidget,
)

from gsapp.aircraft.aircraft_loader import shipped_aircraft
from gsapp.identification.methods import short_method_title
from ui.dialogs.file_fields import ShippedFileField
from ui.dialogs.form_dialog import FieldMessage, repolish
from ui.display_style import DisplayStyle
from ui.estimate_form import EstimateForm
from ui.review.estimate_request import (
    FIELD_HELP,
    SETTING_CHOICES,
    field_help_text,
    is_effect_parameter,
    method_uses,
)
from ui.review.estimate_tables import DerivativeTable, FitChannelTable
from ui.translation import tr
from ui.widgets.labels import create_label, plain_tooltip
from ui.widgets.layout_widgets import FormSection

_SHIPPED_SETS = ("b777",)
_TYPING_MS = 300
"""Pause in typing after which what stands there is judged."""


class EstimatePanel(QWidget):
    """The settings of an estimate."""

    changed = Signal()
    field_focused = Signal(str)
    run_requested = Signal()

    def __init__(self, style: DisplayStyle, form: EstimateForm) -> None:
        super().__init__()
        self._style = style
        self.form = form
        self._is_updating = False
        self._sentences: dict[str, FieldMessage] = {}
        self._edits: dict[str, QWidget] = {}
        self._setters: dict[str, Callable[[Any], object]] = {}
        self._files: dict[str, ShippedFileField] = {}
        self._fields: dict[QObject, str] = {}
        self._typing = QTimer(self)
        self._typing.setSingleShot(True)
        self._typing.timeout.connect(self.changed)
        self._column = QVBoxLayout(self)
        self._column.setContentsMargins(0, 0, 0, 0)
        self.sections: dict[str, FormSection] = {}
        self._add_question_section()
        self._derivatives()
        self._noise()
        self._channels()
        self._sources()
        style.changed.connect(self._fit)
        self._fit()
        self.show_form(form)

    def _fit(self) -> None:
        self._column.setSpacing(self._style.px(12))

    # Making

    def _section(self, name: str, title: str) -> tuple[FormSection, QGridLayout]:
        section = FormSection(self._style, title)
        holder = QWidget()
        grid = QGridLayout(holder)
        grid.setContentsMargins(0, 0, 0, 0)
        grid.setHorizontalSpacing(self._style.px(12))
        grid.setVerticalSpacing(self._style.px(6))
        grid.setColumnStretch(1, 1)
        section.add(holder)
        self._column.addWidget(section)
        self.sections[name] = section
        return section, grid

    def _row(self, grid: QGridLayout, field: str, edit: QWidget, *, wide: bool = False) -> None:
        row = grid.rowCount()
        if not wide and not isinstance(edit, QCheckBox):
            grid.addWidget(create_label(tr(FIELD_HELP[field].title)), row, 0)
        grid.addWidget(edit, row, 0 if wide else 1, 1, 2 if wide else 1)
        sentence = FieldMessage()
        sentence.hide()
        grid.addWidget(sentence, row + 1, 0 if wide else 1, 1, -1)
        self._sentences[field] = sentence
        self._edits[field] = edit
        self._register_field(field, edit)

    def _register_field(self, field: str, edit: QWidget) -> None:
        help_text = field_help_text(field)
        edit.setAccessibleName(tr(FIELD_HELP[field].title))
        edit.setAccessibleDescription(help_text)
        edit.setToolTip(plain_tooltip(help_text))
        edit.installEventFilter(self)
        self._fields[edit] = field

    def _choice(self, grid: QGridLayout, field: str) -> QComboBox:
        box = QComboBox()
        for key, text in SETTING_CHOICES[field]:
            box.addItem(tr(text), key)
        box.activated.connect(lambda _index: self._set_field(field, box.currentData()))
        self._setters[field] = lambda value: box.setCurrentIndex(max(box.findData(value), 0))
        self._row(grid, field, box)
        return box

    def _check(self, grid: QGridLayout, field: str) -> QCheckBox:
        box = QCheckBox(tr(FIELD_HELP[field].title))
        box.toggled.connect(lambda on: self._set_field(field, on))
        self._setters[field] = box.setChecked
        self._row(grid, field, box)
        return box

    def _line(self, grid: QGridLayout, field: str, hint: str) -> QLineEdit:
        line = QLineEdit()
        line.setPlaceholderText(hint)
        line.textEdited.connect(lambda text: self._set_field(field, text.strip(), typed=True))
        line.returnPressed.connect(self._enter)
        self._setters[field] = line.setText
        self._row(grid, field, line)
        return line

    def _file(
        self, grid: QGridLayout, field: str, shipped: tuple[str, ...], none: str,
        *, folder: bool = False,
    ) -> ShippedFileField:  # fmt: skip
        box = ShippedFileField(
            tr(FIELD_HELP[field].title), shipped, str(getattr(self.form, field)), none=none,
            folder=folder,
        )  # fmt: skip
        box.currentIndexChanged.connect(lambda _index: self._set_field(field, box.value))
        self._files[field] = box
        self._setters[field] = box.show_value
        self._row(grid, field, box)
        return box

    def _add_question_section(self) -> None:
        _, grid = self._section("question", tr("What"))
        self.maneuvers = self._choice(grid, "maneuvers")
        self.method = self._choice(grid, "method")
        self.axis = self._choice(grid, "axis")
        self.six_degrees = self._check(grid, "six_degrees")
        self.joint = self._check(grid, "joint")
        self.label = QLineEdit()
        self.label.setPlaceholderText(tr("optional"))
        self.label.returnPressed.connect(self._enter)
        self._row(grid, "label", self.label)

    def _derivatives(self) -> None:
        _, grid = self._section("derivatives", tr("Derivatives"))
        self.derivatives = DerivativeTable(self._style)
        self.derivatives.edited.connect(self._apply_form)
        self._row(grid, "derivatives", self.derivatives, wide=True)

    def _noise(self) -> None:
        _, grid = self._section("noise", tr("Noise and bounds"))
        self.weights = self._file(grid, "weights", (), tr("From the residuals"))
        self.noise = self._choice(grid, "noise")
        self.bound_factor = self._line(grid, "bound_factor", tr("corrected for colored residuals"))
        self.integration = self._choice(grid, "integration")

    def _channels(self) -> None:
        _, grid = self._section("channels", tr("Responses, states, instrument errors"))
        self.channels = FitChannelTable(self._style)
        self.channels.edited.connect(self._apply_form)
        self._row(grid, "channels", self.channels, wide=True)
        self.stand_ins = self._line(grid, "stand_ins", tr("for channels not measured: V=30"))

    def _sources(self) -> None:
        _, grid = self._section("files", tr("Model, aircraft, certificates"))
        self.model = self._file(grid, "model", (), tr("None: campaign means"))
        self.aircraft = self._file(
            grid, "aircraft", tuple(shipped_aircraft()), tr("From each flight")
        )
        self.calibration = self._file(
            grid, "calibration", _SHIPPED_SETS, tr("Certificates of each flight"), folder=True
        )

    # What is wished

    def _set_field(self, field: str, value: object, *, typed: bool = False) -> None:
        if self._is_updating or getattr(self.form, field) == value:
            return
        self.form = self.form.with_changes(**{field: value})
        if field in ("axis", "six_degrees"):
            # Channels were chosen for the other axis.
            self.form = self.form.with_changes(responses=None, states=None, biases=None)
        self._update_tables()
        if typed:
            self._typing.start(_TYPING_MS)
        else:
            self.changed.emit()

    def _apply_form(self, form: EstimateForm) -> None:
        self.form = form
        self._update_tables()
        self.changed.emit()

    def _enter(self) -> None:
        self._typing.stop()
        self.changed.emit()
        self.run_requested.emit()

    def show_form(self, form: EstimateForm) -> None:
        """Show another form; emits nothing."""
        self.form = form
        self._is_updating = True
        try:
            for field, show in self._setters.items():
                show(getattr(form, field))
        finally:
            self._is_updating = False
        self._update_tables()

    def set_file_choices(self, field: str, names: Sequence[str]) -> None:
        self._files[field].add_names(names)

    def _update_tables(self) -> None:
        """Show the form in the tables, and gray what the method does not heed."""
        form = self.form
        self.derivatives.set_form(form)
        self.channels.set_form(form)
        fields = {"derivatives": "held", "channels": "responses"}
        for field, edit in self._edits.items():
            edit.setEnabled(method_uses(form, fields.get(field, field)))
        self.axis.setEnabled(not form.six_degrees)
        self.show_problem("", "")

    # What is said

    def show_problem(self, field: str, text: str) -> None:
        """Say what is wrong with a field, and of the others what is to be known."""
        for name, sentence in self._sentences.items():
            wrong = name == field
            note = "" if wrong else self._note(name)
            sentence.set_message(text if wrong else note, "warning" if wrong else "")
            sentence.setVisible(bool(text if wrong else note))
            edit = self._edits[name]
            state = "warning" if wrong else ""
            if isinstance(edit, QLineEdit) and edit.property("state") != state:
                edit.setProperty("state", state)
                repolish(edit)

    def _note(self, field: str) -> str:
        form = self.form
        if field == "derivatives":
            if not method_uses(form, "held"):
                return tr("{method} takes the derivatives of the tables.").format(
                    method=tr(short_method_title(form.method))
                )
            free = [name for name, one in form.derivatives.items() if one.treated == "free"]
            here = [n for n in free if n in self.derivatives.names and not is_effect_parameter(n)]
            if here:
                only = (
                    tr("Only {here}").format(here=", ".join(here))
                    if len(here) < 7
                    else tr("Only these {count}").format(count=len(here))
                )
                text = (
                    tr("{only} is estimated; the rest is held.")
                    if len(here) == 1
                    else tr("{only} are estimated; the rest is held.")
                )
                return text.format(only=only)
        if field == "channels":
            if not method_uses(form, "responses"):
                return tr("{method} compares no responses.").format(
                    method=tr(short_method_title(form.method))
                )
            if form.axis == "both" and not form.six_degrees:
                return tr(
                    "Each maneuver uses the responses and states of its axis; choose one axis "
                    "above to change them."
                )
        return ""

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Explain the field that the keyboard comes to; let the wheel scroll past lists."""
        if event.type() == QEvent.Type.Wheel and isinstance(watched, QComboBox):
            # Who scrolls the page does not mean to choose what passes below the mouse.
            event.ignore()
            return True
        if event.type() == QEvent.Type.FocusIn and watched in self._fields:
            self.field_focused.emit(self._fields[watched])
        return super().eventFilter(watched, event)

    def focus_field(self, field: str) -> None:
        edit = self._edits.get(field)
        if edit is not None:
            edit.setFocus()
