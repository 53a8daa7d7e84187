"""Whom a flight is shared with: switches in the menu of the REC tile."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path

from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import QCheckBox, QLineEdit, QMenu, QWidget

from gsapp.foundation import LinkError
from gsapp.session.equipment_monitor import RecorderSummary
from gsapp.telemetry.link_registry import kind_of
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
from ui.web_page.page_controller import WebPageController
from ui.web_page.page_link import is_page_link, parse_page_link
from ui.window_frame.banners import BannerStack

_ALL_NETWORKS = ("0.0.0.0", "::")  # noqa: S104


class ShareDialog(FormDialog):
    """Asks for an address to share the flight with."""

    def __init__(
        self, settings: Settings, folder: Path, style: DisplayStyle, parent: QWidget | None
    ) -> None:
        super().__init__(
            tr("Share the flight"),
            tr("One way: what other programs and browsers send is dropped."),
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
        text = tr("Write udpout:HOST:PORT or tcpin:HOST:PORT; http:HOST:PORT for browsers.")
        state = ""
        if self.link:
            try:
                text, state = _title(self.link), "good"
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
        banners: BannerStack,
        page: WebPageController,
    ) -> None:
        self._banners = banners
        self.page = page  # For phones and tablets.
        self._window = window
        self._controller = controller
        self._style = style
        self._store = store

    @property
    def _recorder(self) -> RecorderSummary:
        session = self._controller.session
        equipment = None if session is None else session.equipment
        return RecorderSummary(state="none") if equipment is None else equipment.recorder

    @property
    def _shares(self) -> tuple[ShareStatus, ...]:
        return self._recorder.shares

    def add_actions(self, menu: QMenu) -> None:
        """Add a switch for each address, and one line for others."""
        menu.addSeparator()
        links = dict.fromkeys((*self._store.current.shares, self.page.link))
        for link in filter(is_page_link, links):
            self._add_page(menu, link)
        shared = {share.link: share for share in self._shares}
        for link in dict.fromkeys((*shared, *self._store.current.shares)):
            if is_page_link(link) or not self._controller.is_recording:
                continue
            share = shared.get(link)
            title = _title(link)
            if share is not None and share.link.partition(":")[0] == "tcpin":
                title = f"{title} ({count_text(len(share.clients), 'client')})"
            action = menu.addAction(title)
            action.setCheckable(True)
            action.setChecked(share is not None and not share.error)
            action.toggled.connect(partial(self._switch, link))
        menu.addAction(tr("Share with another address…"), self.ask_address)
        if self._controller.is_recording:
            notes = menu.addAction(tr("Take notes from other laptops"))
            notes.setCheckable(True)
            notes.setChecked(self._recorder.share_notes)
            notes.toggled.connect(
                lambda takes: self._share([share.link for share in self._shares], takes)
            )

    def _add_page(self, menu: QMenu, link: str) -> None:
        is_shown = link == self.page.link
        title = _title(link)
        if is_shown:
            title = f"{title} ({count_text(self.page.client_count, 'client')})"
        action = menu.addAction(title)
        action.setCheckable(True)
        action.setChecked(is_shown)
        action.toggled.connect(partial(self._switch, link))
        if is_shown:
            menu.addAction(tr("Copy {url}").format(url=self.page.url), self._copy_page_url)

    def _copy_page_url(self) -> None:
        QGuiApplication.clipboard().setText(self.page.url)

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
        if is_page_link(link):
            self._switch_page(link, shares)
            return
        links = [share.link for share in self._shares if share.link != link and not share.error]
        self._share([*links, *([link] if shares else [])], self._recorder.share_notes)

    def _share(self, links: Sequence[str], takes_notes: bool) -> None:
        settings = self._store.current
        request = ShareRequest(
            links=tuple(links), is_open=settings.share_open, key_file=settings.share_key,
            takes_notes=takes_notes,
        )  # fmt: skip
        self._controller.recorders.share(request)

    def _switch_page(self, link: str, shows: bool) -> None:
        self.page.stop()
        if not shows:
            return
        try:
            self.page.start(link, is_open=self._store.current.share_open)
        except LinkError as error:
            self._banners.show_banner("caution", tr("Not shared: {why}").format(why=error))
            return
        text = tr("In a browser, on a phone or tablet, type {url}").format(url=self.page.url)
        self._banners.show_banner("note", text, (tr("Copy"), self._copy_page_url))


def _title(link: str) -> str:
    """Return what sharing with an address does; raise LinkError if it is none."""
    if is_page_link(link):
        page = parse_page_link(link)
        if page.host in _ALL_NETWORKS:
            return tr("Show in browsers on the network: port {port}").format(port=page.port)
        return tr("Show in browsers: port {port} of {host}").format(port=page.port, host=page.host)
    address = share_address(link)
    location = kind_of(address).location(address)
    if address.kind == "tcpin":
        return tr("Share: other programs connect to {location}").format(location=location)
    return tr("Share: send to {location}").format(location=location)
