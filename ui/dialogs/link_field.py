"""Choosing a link: its kind, the fields of its address, and the address as one text."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from PySide6.QtCore import Qt, QTimer, Signal
from PySide6.QtWidgets import QComboBox, QHBoxLayout, QLineEdit, QVBoxLayout, QWidget

from gsapp.foundation import LinkError
from gsapp.telemetry.link_kinds import (
    LOOPBACK,
    AddressField,
    LinkAddress,
    LinkKind,
    SerialLink,
    describe_port,
    is_same_port,
    list_serial_ports,
    split_fields,
)
from gsapp.telemetry.link_registry import link_kinds
from ui.dialogs.flight_requests import InputCheck, check_link
from ui.dialogs.form_dialog import FieldMessage, IntegerField, repolish
from ui.display_style import DisplayStyle
from ui.translation import tr
from ui.widgets.flow_layout import arrange
from ui.widgets.labels import create_label

_PORT_CHECK_MS = 1500


def named_serial_ports() -> tuple[tuple[str, str], ...]:
    """Return path of each serial port, and its name with that of its USB device."""
    return tuple(sorted((port.device, describe_port(port)) for port in list_serial_ports()))


class LinkField(QWidget):
    """A LINK, put together from fields or typed; a sentence says whether it will do.

    `list_ports`: returns (path, words) of the serial ports that are there now.
    """

    changed = Signal()  # Something else is typed now.

    def __init__(
        self,
        links: Sequence[str],
        parse: Callable[[str], LinkAddress],
        list_ports: Callable[[], Sequence[tuple[str, str]]],
        style: DisplayStyle,
    ) -> None:
        super().__init__()
        self._parse = parse
        self._list_ports = list_ports
        self._busy = False
        self._ports: tuple[tuple[str, str], ...] = ()
        self._kinds = {kind.name: kind for kind in link_kinds() if kind.title}
        column = arrange(QVBoxLayout(self), style.px(8))
        self.kind = QComboBox()
        self.kind.setAccessibleName(tr("Kind of link"))
        for kind in self._kinds.values():
            self.kind.addItem(kind.title, kind.name)
        self.kind.activated.connect(self._kind_chosen)
        column.addWidget(self.kind)
        column.addWidget(self._address_fields(style))
        self.text = QComboBox()
        self.text.setEditable(True)
        self.text.setAccessibleName("LINK")
        self.text.setToolTip(tr("Link address; the list holds recent ones"))
        self.text.setInsertPolicy(QComboBox.InsertPolicy.NoInsert)
        self.text.addItems(list(links))
        self.text.editTextChanged.connect(self._typed)
        column.addWidget(self.text)
        # Room for two lines, so that nothing moves while typing.
        self.message = FieldMessage()
        self.message.setMinimumHeight(style.px(32))
        self.message.setAlignment(Qt.AlignmentFlag.AlignTop)
        column.addWidget(self.message)
        self.input_check = InputCheck(message="", state="warning")  # Whether it will do.
        self._show_kind()
        self.refresh_ports()
        self._timer = QTimer(self)
        self._timer.timeout.connect(self.refresh_ports)
        self._timer.start(_PORT_CHECK_MS)
        if links:
            self._typed(self.text.currentText())
        else:
            self._from_fields()

    def _address_fields(self, style: DisplayStyle) -> QWidget:
        """Return an editor for every field that a kind may have; `_show_kind` hides the others."""
        self.host = QLineEdit()
        self.path = QLineEdit()
        self.device = QComboBox()
        self.device.setPlaceholderText(tr("No serial port is plugged in"))
        self.port = IntegerField(1, 65535, 14550)
        self.port.setMaximumWidth(style.px(96))
        self.baud = QComboBox()
        for line in (self.host, self.path):
            line.textEdited.connect(self._from_fields)
        for box in (self.device, self.baud):
            box.activated.connect(self._from_fields)
        self.port.value_changed.connect(self._from_fields)
        page = QWidget()
        row = arrange(QHBoxLayout(page), style.px(8))
        self._labels = {}
        by_field: dict[str, list[QWidget]] = {
            "host": [self.host], "port": [self.port], "path": [self.path, self.device],
            "baud": [self.baud],
        }  # fmt: skip
        for name, editors in by_field.items():
            self._labels[name] = create_label("")
            row.addWidget(self._labels[name])
            for editor in editors:
                row.addWidget(editor, int(name in ("host", "path")))
        return page

    @property
    def _current_kind(self) -> LinkKind:
        return self._kinds[self.kind.currentData()]

    def _editor(self, name: str) -> QWidget:
        if name == "path" and isinstance(self._current_kind, SerialLink):
            return self.device
        return {"host": self.host, "port": self.port, "path": self.path, "baud": self.baud}[name]

    def _show_kind(self) -> None:
        fields = {field.name: field for field in self._current_kind.fields}
        for name, label in self._labels.items():
            label.setVisible(name in fields)
        editors = {self._editor(name): field for name, field in fields.items()}
        for known in (self.host, self.port, self.path, self.device, self.baud):
            known.setVisible(known in editors)
        for editor, field in editors.items():
            self._labels[field.name].setText(field.label)
            editor.setAccessibleName(field.label)
            if editor is self.baud and self.baud.property("choices") != field.choices:
                self.baud.clear()
                self.baud.setProperty("choices", field.choices)
                for baud in field.choices:
                    self.baud.addItem(f"{baud:,}", baud)
            elif isinstance(editor, QLineEdit) and not editor.text():
                editor.setText(field.example)

    def refresh_ports(self) -> None:
        ports = tuple(self._list_ports())
        if ports == self._ports:
            return
        kept = self.device.currentData()
        self._ports = ports
        self.device.clear()
        for path, text in ports:
            self.device.addItem(text or path, path)
        if kept is not None:
            self._show_device(kept)
        else:
            self.device.setCurrentIndex(0 if ports else -1)
            if isinstance(self._current_kind, SerialLink):
                self._from_fields()
        self._validate()

    def _show_device(self, path: str) -> None:
        """Show which port is meant; one that is not plugged in, or by another name, stands last."""
        listed = (
            index for index, (port, _words) in enumerate(self._ports) if is_same_port(port, path)
        )
        self._show(self.device, next(listed, -1), len(self._ports), path, path)

    @staticmethod
    def _show(box: QComboBox, place: int, offered: int, text: str, value: object) -> None:
        """Choose in a box, where behind what it offers may stand one more that was typed."""
        while box.count() > offered:
            box.removeItem(box.count() - 1)
        if place < 0:
            box.addItem(text, value)
        box.setCurrentIndex(place if place >= 0 else offered)

    def _value(self, field: AddressField) -> str | int:
        editor = self._editor(field.name)
        if isinstance(editor, QComboBox):
            return editor.currentData() or ""
        if isinstance(editor, IntegerField):
            return editor.value
        text = editor.text().strip() if isinstance(editor, QLineEdit) else ""
        return text or (LOOPBACK if field.name == "host" else "")

    def _show_value(self, field: AddressField, value: str | int) -> None:
        editor = self._editor(field.name)
        if editor is self.device:
            self._show_device(str(value))
        elif editor is self.baud:
            place = field.choices.index(int(value)) if value in field.choices else -1
            self._show(self.baud, place, len(field.choices), f"{value:,}", value)
        elif isinstance(editor, QLineEdit):
            editor.setText(str(value))

    def _kind_chosen(self) -> None:
        self._show_kind()
        self._from_fields()

    def _from_fields(self, *_ignored: object) -> None:
        if self._busy:
            return
        kind = self._current_kind
        values: dict[str, Any] = {field.name: self._value(field) for field in kind.fields}
        self._busy = True
        self.text.setEditText(str(LinkAddress(kind=kind.name, **values)))
        self._busy = False
        self._validate()

    def _typed(self, text: str) -> None:
        if self._busy:
            return
        # The fields above follow what is typed, as far as it can be told.
        name, _, rest = text.strip().partition(":")
        place = self.kind.findData(name)
        self._busy = True
        if place >= 0:
            self.kind.setCurrentIndex(place)
            self._show_kind()
            fields = self._current_kind.fields
            for field, part in zip(fields, split_fields(fields, rest), strict=True):
                try:
                    self._show_value(field, field.parse(part))
                except LinkError:
                    continue
        self._busy = False
        self._validate()

    def _validate(self) -> None:
        ports = [path for path, _words in self._ports]
        self.input_check = check_link(self.text.currentText(), self._parse, ports)
        self.message.set_message(self.input_check.message, self.input_check.state)
        line = self.text.lineEdit()
        state = "" if self.input_check.is_valid else "warning"
        if line is not None and line.property("state") != state:
            line.setProperty("state", state)
            repolish(line)
        self.changed.emit()

    @property
    def value(self) -> str:
        """Return the LINK."""
        return self.text.currentText().strip()

    @property
    def channel_map(self) -> str:
        """Return the channel map of the kind of link chosen; empty where it has none of its own."""
        return self._current_kind.channel_map
