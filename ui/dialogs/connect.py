"""Connecting an aircraft: which link, which maps, where to record."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from PySide6.QtCore import Qt, QTimer, Signal
from PySide6.QtWidgets import (
    QComboBox,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QPushButton,
    QSizePolicy,
    QStackedWidget,
    QVBoxLayout,
    QWidget,
)

from gsapp.foundation import LinkError
from gsapp.telemetry.link_test import LinkTest
from gsapp.telemetry.sources.serial_port import is_same_port
from ui.dialogs.file_fields import RecordingDialog, ShippedFileField
from ui.dialogs.flight_requests import (
    BAUD_RATES,
    LINK_KINDS,
    ConnectRequest,
    InputCheck,
    LinkFieldKind,
    check_link,
    format_link,
)
from ui.dialogs.form_dialog import FieldMessage, IntegerField, repolish
from ui.dialogs.link_rows import describe_vehicle
from ui.display_style import DisplayStyle
from ui.settings import Settings

_PORT_CHECK_MS = 1500
_TEST_POLL_MS = 300
_TEST_TIMEOUT = 2.0
"""Seconds of a test before it is said what is wrong."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ConnectionOptions:
    """What can be chosen when connecting.

    Attributes
    ----------
    aircraft, channel_maps, calibrations : tuple of str
        Names that come with the program.
    parse : callable
        Reads a LINK.
    list_ports : callable
        Returns (path, words) of the serial ports that are there now.
    """

    aircraft: tuple[str, ...]
    channel_maps: tuple[str, ...]
    calibrations: tuple[str, ...]
    parse: Callable[[str], object]
    list_ports: Callable[[], Sequence[tuple[str, str]]]


class LinkField(QWidget):
    """A LINK, put together from fields or typed; a sentence says whether it will do.

    Parameters
    ----------
    links : sequence of str
        Used before, newest first.
    parse : callable
        Reads a LINK, see `check_link`.
    list_ports : callable
        Returns (path, words) of the serial ports that are there now.

    Attributes
    ----------
    changed : Signal
        Something else is typed now.
    input_check : InputCheck
        Whether it will do.
    """

    changed = Signal()

    def __init__(
        self,
        links: Sequence[str],
        parse: Callable[[str], object],
        list_ports: Callable[[], Sequence[tuple[str, str]]],
        look: DisplayStyle,
    ) -> None:
        super().__init__()
        self._parse = parse
        self._list_ports = list_ports
        self._busy = False
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(look.px(8))
        self.kind = QComboBox()
        self.kind.setAccessibleName("Kind of link")
        for kind, words in LINK_KINDS:
            self.kind.addItem(words, kind)
        self.kind.activated.connect(self._kind_chosen)
        column.addWidget(self.kind)
        self._pages = QStackedWidget()
        self._pages.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Fixed)
        self._pages.addWidget(self._network_fields(look))
        self._pages.addWidget(self._serial_fields(look))
        column.addWidget(self._pages)
        self.text = QComboBox()
        self.text.setEditable(True)
        self.text.setAccessibleName("LINK")
        self.text.setToolTip("The link as one text; those used before are in the list")
        self.text.setInsertPolicy(QComboBox.InsertPolicy.NoInsert)
        self.text.addItems(list(links))
        self.text.editTextChanged.connect(self._typed)
        column.addWidget(self.text)
        # Room for two lines, so that nothing moves while typing.
        self.sentence = FieldMessage()
        self.sentence.setMinimumHeight(look.px(32))
        self.sentence.setAlignment(Qt.AlignmentFlag.AlignTop)
        column.addWidget(self.sentence)
        self.input_check = InputCheck(message="", state="warning")
        self._ports: tuple[tuple[str, str], ...] = ()
        self.refresh_ports()
        self._timer = QTimer(self)
        self._timer.timeout.connect(self.refresh_ports)
        self._timer.start(_PORT_CHECK_MS)
        if links:
            self._typed(self.text.currentText())
        else:
            self._from_fields()

    def _network_fields(self, look: DisplayStyle) -> QWidget:
        page = QWidget()
        row = QHBoxLayout(page)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(look.px(8))
        self.host = QLineEdit("127.0.0.1")
        self.host.setAccessibleName("Address")
        self.port = IntegerField(1, 65535, 14550)
        self.port.setMaximumWidth(look.px(96))
        self.port.setAccessibleName("Port")
        row.addWidget(QLabel("Address"))
        row.addWidget(self.host, 1)
        row.addWidget(QLabel("Port"))
        row.addWidget(self.port)
        self.host.textEdited.connect(self._from_fields)
        self.port.value_changed.connect(self._from_fields)
        return page

    def _serial_fields(self, look: DisplayStyle) -> QWidget:
        page = QWidget()
        row = QHBoxLayout(page)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(look.px(8))
        self.device = QComboBox()
        self.device.setAccessibleName("Serial port")
        self.device.setPlaceholderText("No serial port is plugged in")
        self.baud = QComboBox()
        self.baud.setAccessibleName("Baud")
        for baud in BAUD_RATES:
            self.baud.addItem(f"{baud:,}", baud)
        row.addWidget(QLabel("Port"))
        row.addWidget(self.device, 1)
        row.addWidget(QLabel("Baud"))
        row.addWidget(self.baud)
        self.device.activated.connect(self._from_fields)
        self.baud.activated.connect(self._from_fields)
        return page

    def refresh_ports(self) -> None:
        """List the serial ports that are there now."""
        ports = tuple(self._list_ports())
        if ports == self._ports:
            return
        kept = self.device.currentData()
        self._ports = ports
        self.device.clear()
        for path, words in ports:
            self.device.addItem(words or path, path)
        if kept is not None:
            self._show_device(kept)
        else:
            self.device.setCurrentIndex(0 if ports else -1)
            if self._pages.currentIndex() == 1:
                self._from_fields()
        self._judge()

    def _show_device(self, path: str) -> None:
        """Show which port is meant; one that is not plugged in, or by another name, stands last."""
        listed = (at for at, (port, _words) in enumerate(self._ports) if is_same_port(port, path))
        self._show(self.device, next(listed, -1), len(self._ports), path, path)

    def _show_baud(self, baud: int) -> None:
        """Show how fast; what is not among the usual ones stands last."""
        place = BAUD_RATES.index(baud) if baud in BAUD_RATES else -1
        self._show(self.baud, place, len(BAUD_RATES), f"{baud:,}", baud)

    @staticmethod
    def _show(box: QComboBox, place: int, offered: int, words: str, value: object) -> None:
        """Choose in a box, where behind what it offers may stand one more that was typed."""
        while box.count() > offered:
            box.removeItem(box.count() - 1)
        if place < 0:
            box.addItem(words, value)
        box.setCurrentIndex(place if place >= 0 else offered)

    def _kind_chosen(self) -> None:
        self._pages.setCurrentIndex(1 if self.kind.currentData() in ("serial", "text") else 0)
        self._from_fields()

    def _from_fields(self, *_ignored: object) -> None:
        if self._busy:
            return
        kind: LinkFieldKind = self.kind.currentData()
        text = format_link(
            kind,
            host=self.host.text(),
            port=self.port.value,
            device=self.device.currentData() or "",
            baud=int(self.baud.currentData()),
        )
        self._busy = True
        self.text.setEditText(text)
        self._busy = False
        self._judge()

    def _typed(self, text: str) -> None:
        if self._busy:
            return
        # The fields above follow what is typed, as far as it can be told.
        kind, _, rest = text.strip().partition(":")
        place = self.kind.findData(kind)
        self._busy = True
        if place >= 0:
            self.kind.setCurrentIndex(place)
            self._pages.setCurrentIndex(1 if kind in ("serial", "text") else 0)
            head, _, number = rest.rpartition(":")
            if kind not in ("serial", "text"):
                self.host.setText(head)
                if number.isdigit() and 0 < int(number) < 65536:
                    self.port.set_value(int(number))
            elif head and number.isdigit() and int(number):
                self._show_device(head)
                self._show_baud(int(number))
        self._busy = False
        self._judge()

    def _judge(self) -> None:
        ports = [path for path, _words in self._ports]
        self.input_check = check_link(self.text.currentText(), self._parse, ports)
        self.sentence.set_message(self.input_check.message, self.input_check.state)
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


class LinkTestField(QWidget):
    """The flown system, among those that a test of the link hears.

    Attributes
    ----------
    button : QPushButton
        Begins and ends the test.
    systems : QComboBox
        The first autopilot heard, or one of those heard.
    sentence : FieldMessage
        What has come, or what to try.
    """

    def __init__(self, look: DisplayStyle) -> None:
        super().__init__()
        self._link = ""
        self._test: LinkTest | None = None
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(look.px(8))
        row = QHBoxLayout()
        row.setSpacing(look.px(8))
        self.systems = QComboBox()
        self.systems.setAccessibleName("Flown system")
        self.systems.addItem("Automatic", None)
        self.systems.setToolTip("Automatic: the system in the channel map, or the first autopilot")
        self.button = QPushButton("Test link")
        self.button.setToolTip("Listen on the link without recording: what comes, and who sends")
        self.button.clicked.connect(self._toggle)
        row.addWidget(self.systems, 1)
        row.addWidget(self.button)
        column.addLayout(row)
        self.sentence = FieldMessage()
        # Room for three lines, so that nothing moves while it listens.
        self.sentence.setMinimumHeight(look.px(48))
        self.sentence.setAlignment(Qt.AlignmentFlag.AlignTop)
        column.addWidget(self.sentence)
        self._timer = QTimer(self)
        self._timer.setInterval(_TEST_POLL_MS)
        self._timer.timeout.connect(self._look)
        self.setFocusProxy(self.systems)

    @property
    def system(self) -> int | None:
        """Return the system chosen; None for the first autopilot heard."""
        chosen = self.systems.currentData()
        return None if chosen is None else int(chosen)

    def set_link(self, link: str) -> None:
        """Offer to test a link; empty for none. What was heard on another is void."""
        if link != self._link:
            self.stop()
            self._link = link
            self.sentence.set_message("")
            while self.systems.count() > 1:
                self.systems.removeItem(1)
        self.button.setEnabled(link.partition(":")[0] in dict(LINK_KINDS))

    def stop(self) -> None:
        """End the test and give the port back."""
        self._timer.stop()
        self.button.setText("Test link")
        test, self._test = self._test, None
        if test is not None:
            test.close()

    def _toggle(self) -> None:
        if self._test is not None:
            self.stop()
            return
        self._test = LinkTest(self._link)
        self.button.setText("Stop test")
        self.sentence.set_message("Listening…")
        self._timer.start()

    def _look(self) -> None:
        test = self._test
        if test is None:
            return
        report, diagnosis = test.report(), test.diagnosis()
        for vehicle in report.vehicles:
            if self.systems.findData(vehicle.system) < 0:
                self.systems.addItem(f"System {vehicle.system}", vehicle.system)
            at = self.systems.findData(vehicle.system)
            self.systems.setItemText(at, describe_vehicle(vehicle, live=True))
        if diagnosis is None and report.vehicles:
            heard = ", ".join(f"system {vehicle.system}" for vehicle in report.vehicles)
            self.sentence.set_message(f"MAVLink received: {heard}.", "good")
        elif diagnosis is None:
            lines = f"{report.lines} lines of text received."
            self.sentence.set_message(
                lines if report.lines else "Listening…", "good" * bool(report.lines)
            )
        elif test.open_error or test.seconds >= _TEST_TIMEOUT:
            self.sentence.set_message(str(diagnosis), "warning" if test.open_error else "caution")
        if test.open_error:
            self.stop()


class ConnectDialog(RecordingDialog):
    """Asks for everything needed to record and show an aircraft."""

    def __init__(
        self,
        settings: Settings,
        look: DisplayStyle,
        choices: ConnectionOptions,
        flights: Path,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(
            "Connect an aircraft",
            "Recording begins at once, in a process of its own: it goes on if this window closes.",
            "Connect",
            look,
            parent,
        )
        self.link = LinkField(settings.links, choices.parse, choices.list_ports, look)
        self.add_row("Link", self.link)
        self.test = LinkTestField(look)
        self.add_row("Flown system", self.test)
        self.aircraft = ShippedFileField("Aircraft", choices.aircraft, settings.aircraft)
        self.add_row("Aircraft", self.aircraft)
        self.channel_map = ShippedFileField(
            "Channel map", choices.channel_maps, settings.channel_map
        )
        self.add_row("Channel map", self.channel_map)
        self.calibration = ShippedFileField(
            "Calibration",
            choices.calibrations,
            settings.calibration,
            none="as the channel map says",
            folder=True,
        )
        self.add_row("Calibration", self.calibration)
        self.add_folder_field(flights)
        self.finished.connect(self.test.stop)
        self.link.changed.connect(self._link_changed)
        self._link_changed()
        self.fit_to_content()

    def _link_changed(self) -> None:
        self.test.set_link(self.link.value if self.link.input_check.is_valid else "")
        self._judge()

    @property
    def is_valid(self) -> bool:
        """Return whether link and place will do."""
        return self.link.input_check.is_valid and super().is_valid

    def accept(self) -> None:
        """Give the port to the recorder."""
        self.test.stop()
        super().accept()

    def _sentence_of(self, error: Exception) -> FieldMessage:
        found = super()._sentence_of(error)
        at_link = isinstance(error, LinkError) and found is not self.folder_field.message
        return self.link.sentence if at_link else found

    @property
    def request(self) -> ConnectRequest:
        """Return what was asked for."""
        return ConnectRequest(
            link=self.link.value,
            folder=self.folder_field.folder,
            channel_map=self.channel_map.value,
            aircraft=self.aircraft.value,
            calibration=self.calibration.value,
            system=self.test.system,
            title=self.folder_field.title.text().strip(),
        )
