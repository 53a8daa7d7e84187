"""Whom a flight that is being recorded is shared with: switches in the menu of the REC tile."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from PySide6.QtWidgets import QCheckBox, QLineEdit, QMenu, QWidget

from gsapp.foundation import LinkError
from gsapp.telemetry.link_registry import kind_of, parse_link
from gsapp.telemetry.recorder_status import ShareStatus
from gsapp.telemetry.recording_settings import RecordingSettings
from gsapp.telemetry.stream_server import ShareRequest, share_address
from ui.dialogs.form_dialog import FieldMessage, FormDialog
from ui.dialogs.signing_key_field import SigningKeyField, sharing_purpose
from ui.display_style import DisplayStyle
from ui.flight_controller import FlightController
from ui.number_format import count_text
from ui.settings import Settings, SettingsStore
from ui.translation import tr


class ShareDialog(FormDialog):
    """Asks for an address to share the flight with."""

    def __init__(
        self, settings: Settings, folder: Path, style: DisplayStyle, parent: QWidget | None
    ) -> None:
        super().__init__(
            tr("Share the flight"),
            tr("Passes on what is received, one way: what the other program sends is dropped."),
            tr("Share"),
            style,
            parent,
        )
        self.edit = QLineEdit()
        self.edit.setPlaceholderText("udpout:192.168.1.20:14550")
        self._message = FieldMessage()
        self.add_row(tr("Address"), self.edit, self._message)
        self.key = SigningKeyField(settings.share_key, folder, style, sharing_purpose())
        self.add_row(tr(RecordingSettings.title_of("share_key")), self.key)
        self.without_key = QCheckBox(tr("Anyone on that network may receive the flight"))
        self.without_key.setChecked(settings.share_open)
        self.add_row(tr("Without a key"), self.without_key)
        self.edit.textChanged.connect(self._validate)
        self.key.changed.connect(self._validate)
        self._validate()
        self.fit_to_content(560)

    @property
    def link(self) -> str:
        return self.edit.text().strip()

    def _validate(self) -> None:
        text, state = tr("Write udpout:HOST:PORT or tcpin:HOST:PORT."), ""
        if self.link:
            try:
                text, state = _title(str(share_address(self.link))), "good"
            except LinkError as error:
                text, state = str(error), "warning"
        self._message.set_message(text, state)
        self.button.setEnabled(state == "good" and self.key.input_check.is_valid)


class SharingMenu:
    """The switches, one for each address used last."""

    def __init__(
        self,
        window: QWidget,
        controller: FlightController,
        style: DisplayStyle,
        store: SettingsStore,
    ) -> None:
        self._window = window
        self._controller = controller
        self._style = style
        self._store = store

    @property
    def _shares(self) -> tuple[ShareStatus, ...]:
        session = self._controller.session
        equipment = None if session is None else session.equipment
        return () if equipment is None else equipment.recorder.shares

    def add_actions(self, menu: QMenu) -> None:
        """Add a switch for each address, and one line for others."""
        menu.addSeparator()
        shared = {share.link: share for share in self._shares}
        for link in dict.fromkeys((*shared, *self._store.current.shares)):
            share = shared.get(link)
            title = _title(link)
            if share is not None and share.link.partition(":")[0] == "tcpin":
                title = f"{title} ({count_text(len(share.clients), 'client')})"
            action = menu.addAction(title)
            action.setCheckable(True)
            action.setChecked(share is not None and not share.error)
            action.toggled.connect(partial(self._switch, link))
        menu.addAction(tr("Share with another address…"), self.ask_address)

    def ask_address(self) -> None:
        """Ask for an address, and share the flight with it, too."""
        settings = self._store.current
        dialog = ShareDialog(settings, self._store.path.parent, self._style, self._window)
        if dialog.exec():
            self._store.replace(
                settings.with_share(dialog.link).with_values(
                    share_open=dialog.without_key.isChecked(), share_key=dialog.key.value
                )
            )
            self._switch(dialog.link, True)

    def _switch(self, link: str, shares: bool) -> None:
        links = [share.link for share in self._shares if share.link != link and not share.error]
        settings = self._store.current
        request = ShareRequest(
            links=(*links, *([link] if shares else [])), is_open=settings.share_open,
            key_file=settings.share_key,
        )  # fmt: skip
        self._controller.recorders.share(request)


def _title(link: str) -> str:
    """Return what sharing with an address does."""
    address = parse_link(link)
    location = kind_of(address).location(address)
    if address.kind == "tcpin":
        return tr("Share: other programs connect to {location}").format(location=location)
    return tr("Share: send to {location}").format(location=location)
