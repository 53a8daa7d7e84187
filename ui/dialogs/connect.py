"""Connecting an aircraft: which link, which maps, where to record."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from PySide6.QtCore import Qt, QTimer
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QHBoxLayout,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from calibration import shipped_certificate_sets
from gsapp.aircraft.aircraft_loader import shipped_aircraft
from gsapp.decoding.channel_map import load_channel_map, shipped_channel_maps
from gsapp.decoding.health import LinkReport
from gsapp.decoding.sender_filter import host_of
from gsapp.foundation import LinkError
from gsapp.foundation.settings import setting_info
from gsapp.telemetry.link_diagnosis import LinkTest
from gsapp.telemetry.link_kinds import LinkAddress
from gsapp.telemetry.link_registry import link_kinds, parse_link
from gsapp.telemetry.recording_settings import RecordingSettings
from ui.dialogs.file_fields import RecordingDialog, ShippedFileField
from ui.dialogs.flight_requests import ConnectRequest
from ui.dialogs.form_dialog import FieldMessage, FormDialog
from ui.dialogs.link_field import LinkField, named_serial_ports
from ui.dialogs.mavlink_inspector import describe_rejected, describe_vehicle
from ui.dialogs.signing_key_field import SigningKeyField
from ui.display_style import DisplayStyle
from ui.settings import Settings, settings_path
from ui.translation import tr
from ui.widgets.flow_layout import arrange

_TEST_POLL_MS = 300
_TEST_TIMEOUT = 2.0  # Seconds of a test before it is said what is wrong.


@dataclass(frozen=True, slots=True, kw_only=True)
class ConnectionOptions:
    """What can be chosen when connecting."""

    # Names that come with the program.
    aircraft: tuple[str, ...]
    channel_maps: tuple[str, ...]
    calibrations: tuple[str, ...]
    parse: Callable[[str], LinkAddress]  # Reads a LINK.
    # Returns (path, words) of the serial ports that are there now.
    list_ports: Callable[[], Sequence[tuple[str, str]]]


def mavlink_channel_maps() -> tuple[str, ...]:
    """Return the shipped channel maps for what comes over a link."""
    return tuple(
        name for name in shipped_channel_maps() if load_channel_map(name).format == "mavlink"
    )


def connection_options() -> ConnectionOptions:
    """Return what can be chosen when connecting."""
    return ConnectionOptions(
        aircraft=shipped_aircraft(),
        channel_maps=mavlink_channel_maps(),
        calibrations=shipped_certificate_sets(),
        parse=parse_link,
        list_ports=named_serial_ports,
    )


def add_recording_fields(
    dialog: FormDialog, choices: ConnectionOptions, settings: Settings
) -> dict[str, ShippedFileField]:
    """Add the rows of what a link is recorded with; return their fields by setting."""
    from_map = tr(setting_info(RecordingSettings.model_fields["calibration"]).default_text)
    fields = {}
    for name, shipped, none in (
        ("aircraft", choices.aircraft, ""),
        ("channel_map", choices.channel_maps, ""),
        ("calibration", choices.calibrations, from_map),
    ):
        title = tr(RecordingSettings.title_of(name))
        fields[name] = ShippedFileField(
            title, shipped, getattr(settings, name), none=none, folder=bool(none)
        )
        dialog.add_row(title, fields[name])
    return fields


class LinkTestField(QWidget):
    """The flown system, among those that a test of the link hears."""

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__()
        self._link = ""
        self._test: LinkTest | None = None
        self._listen_only = False
        self.signing_key = ""  # File of the key, with which the flight of another is copied.
        column = arrange(QVBoxLayout(self), style.px(8))
        row = QHBoxLayout()
        row.setSpacing(style.px(8))
        self.systems = QComboBox()  # The first autopilot heard, or one of those heard.
        self.systems.setAccessibleName(tr("Flown system"))
        self.systems.addItem(tr("Automatic"), None)
        self.systems.setToolTip(
            tr("Automatic: the system in the channel map, or the first autopilot")
        )
        self.button = QPushButton(tr("Test link"))  # Begins and ends the test.
        self.button.setToolTip(tr("Listen without recording: shows what arrives and who sends it"))
        self.button.clicked.connect(self._toggle)
        row.addWidget(self.systems, 1)
        row.addWidget(self.button)
        column.addLayout(row)
        self.message = FieldMessage()  # What has come, or what to try.
        # Room for three lines, so that nothing moves while it listens.
        self.message.setMinimumHeight(style.px(48))
        self.message.setAlignment(Qt.AlignmentFlag.AlignTop)
        column.addWidget(self.message)
        self._timer = QTimer(self)
        self._timer.setInterval(_TEST_POLL_MS)
        self._timer.timeout.connect(self._show_test)
        self.setFocusProxy(self.systems)

    @property
    def system(self) -> tuple[int | None, str]:
        """Return the system chosen and its network address; None for the first autopilot heard."""
        chosen = self.systems.currentData()
        if chosen is None:
            return None, ""
        system, _, address = str(chosen).partition(" ")
        return int(system), address

    def set_listen_only(self, listen_only: bool) -> None:
        """Send nothing while testing; a test that runs ends, since it may have sent."""
        self.stop()
        self._listen_only = listen_only

    def set_link(self, link: str) -> None:
        """Offer to test a link; empty for none. What was heard on another is void."""
        if link != self._link:
            self.stop()
            self._link = link
            self.message.set_message("")
            while self.systems.count() > 1:
                self.systems.removeItem(1)
        listed = {kind.name for kind in link_kinds() if kind.title}
        self.button.setEnabled(link.partition(":")[0] in listed)

    def stop(self) -> None:
        """End the test and give the port back."""
        self._timer.stop()
        self.button.setText(tr("Test link"))
        test, self._test = self._test, None
        if test is not None:
            test.close()

    def _toggle(self) -> None:
        if self._test is not None:
            self.stop()
            return
        self._test = LinkTest(
            self._link, listen_only=self._listen_only, signing_key=self.signing_key
        )
        self.button.setText(tr("Stop test"))
        self.message.set_message(tr("Listening…"))
        self._timer.start()

    def _show_test(self) -> None:
        test = self._test
        if test is None:
            return
        report, diagnosis = test.report(), test.diagnosis()
        self._list_systems(report)
        if diagnosis is None and report.vehicles:
            heard = ", ".join(
                tr("system {system}").format(system=vehicle.system) for vehicle in report.vehicles
            )
            self.message.set_message(tr("MAVLink received: {heard}.").format(heard=heard), "good")
        elif diagnosis is None:
            lines = tr("{lines} lines of text received.").format(lines=report.lines)
            self.message.set_message(
                lines if report.lines else tr("Listening…"), "good" * bool(report.lines)
            )
        elif test.open_error or test.seconds >= _TEST_TIMEOUT:
            self.message.set_message(str(diagnosis), "warning" if test.open_error else "caution")
        if test.open_error:
            self.stop()

    def _list_systems(self, report: LinkReport) -> None:
        found = [
            (f"{one.system} {host_of(one.address)}", describe_vehicle(one, live=True))
            for one in report.vehicles
        ] + [
            (f"{one.system} {one.address}", describe_rejected(one))
            for one in report.rejected_vehicles
        ]
        for key, text in found:
            if self.systems.findData(key) < 0:
                self.systems.addItem(text, key)
            self.systems.setItemText(self.systems.findData(key), text)


class ConnectDialog(RecordingDialog):
    """Asks for everything needed to record and show an aircraft."""

    def __init__(
        self,
        settings: Settings,
        style: DisplayStyle,
        choices: ConnectionOptions,
        flights: Path,
        parent: QWidget | None = None,
        *,
        own_folder: Path | None = None,
    ) -> None:
        super().__init__(
            tr("Connect an aircraft"),
            tr(
                "Recording starts at once, in a separate process. It continues if this window "
                "closes."
            ),
            tr("Connect"),
            style,
            parent,
        )
        self.link = LinkField(settings.links, choices.parse, choices.list_ports, style)
        self.add_row(tr("Link"), self.link)
        self.test = LinkTestField(style)
        self.add_row(tr("Flown system"), self.test)
        self.listen_only = QCheckBox(tr("Send nothing: no heartbeat, no log request"))
        self.listen_only.setChecked(settings.listen_only)
        self.listen_only.toggled.connect(self.test.set_listen_only)
        self.test.set_listen_only(settings.listen_only)
        self.add_row(tr(RecordingSettings.title_of("listen_only")), self.listen_only)
        # A key is in no file that is shared: neither in the settings nor in a flight.
        folder = own_folder or settings_path().parent
        self.signing_key = SigningKeyField(settings.signing_key, folder, style)
        self.add_row(tr(RecordingSettings.title_of("signing_key")), self.signing_key)
        self.fields = add_recording_fields(self, choices, settings)
        self.add_folder_field(flights)
        self._own_map = ""
        self._usual_map = settings.channel_map
        self.finished.connect(self.test.stop)
        self.link.changed.connect(self._link_changed)
        self.signing_key.changed.connect(self._key_changed)
        self._key_changed()
        self._link_changed()
        self.fit_to_content()

    def _key_changed(self) -> None:
        is_valid = self.signing_key.input_check.is_valid
        self.test.signing_key = self.signing_key.value if is_valid else ""
        self._validate()

    def _link_changed(self) -> None:
        self.test.set_link(self.link.value if self.link.input_check.is_valid else "")
        if self.link.channel_map != self._own_map:
            self._own_map = self.link.channel_map
            self.fields["channel_map"].show_value(self._own_map or self._usual_map)
        self._validate()

    @property
    def is_valid(self) -> bool:
        fields = (self.link, self.signing_key)
        return all(one.input_check.is_valid for one in fields) and super().is_valid

    def accept(self) -> None:
        self.test.stop()
        super().accept()

    def _sentence_of(self, error: Exception) -> FieldMessage:
        found = super()._sentence_of(error)
        at_link = isinstance(error, LinkError) and found is not self.folder_field.message
        return self.link.message if at_link else found

    @property
    def request(self) -> ConnectRequest:
        system, address = self.test.system
        return ConnectRequest(
            link=self.link.value,
            folder=self.folder_field.folder,
            system=system,
            address=address,
            listen_only=self.listen_only.isChecked(),
            signing_key=self.signing_key.value,
            title=self.folder_field.title.text().strip(),
            **{name: field.value for name, field in self.fields.items()},
        )
