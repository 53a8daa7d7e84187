"""Settings of a recording: options of ``gsapp record``, and the window's form of a connection."""

from __future__ import annotations

import logging
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from gsapp.foundation.settings import SettingsModel, setting
from gsapp.foundation.translation import QT_TR_NOOP

if TYPE_CHECKING:
    from gsapp.flight.folder import FlightFolder

log = logging.getLogger(__name__)


class RecordingSettings(SettingsModel):
    """What a link is recorded with, and how."""

    # fmt: off
    aircraft: str = setting(
        "", QT_TR_NOOP("Aircraft"),
        QT_TR_NOOP("Aircraft: a file, or the name of a shipped one."),
        option="--aircraft", metavar="FILE")
    channel_map: str = setting(
        "", QT_TR_NOOP("Channel map"),
        QT_TR_NOOP("Channel map: a file, or the name of a shipped one."),
        option="--map", metavar="MAP")
    calibration: str = setting(
        "", QT_TR_NOOP("Certificates"),
        QT_TR_NOOP("Certificates: a folder, or the name of a shipped set."),
        option="--calibration", metavar="FOLDER|NAME",
        default_text=QT_TR_NOOP("from the channel map"))
    heartbeat: bool | None = setting(
        None, QT_TR_NOOP("Heartbeat"),
        QT_TR_NOOP("Send a heartbeat every second; default: over udpout only."),
        option="--heartbeat/--no-heartbeat")
    listen_only: bool = setting(
        False, QT_TR_NOOP("Listen only"),
        QT_TR_NOOP("Send nothing at all: no heartbeat, no log request."),
        option="--listen-only")
    signing_key: str = setting(
        "", QT_TR_NOOP("Signing key"),
        QT_TR_NOOP(
            "MAVLink signing key, a file with 32 bytes, 64 hexadecimal digits or a passphrase: "
            "check what arrives, sign what is sent."
        ),
        option="--signing-key", metavar="FILE")
    share: tuple[str, ...] = setting(
        (), QT_TR_NOOP("Share"),
        QT_TR_NOOP(
            "Pass on what is received, one way: tcpin:HOST:PORT serves all who connect, "
            "udpout:HOST:PORT sends to one."
        ),
        option="--share", metavar="LINK", is_repeatable=True)
    share_key: str = setting(
        "", QT_TR_NOOP("Sharing key"),
        QT_TR_NOOP(
            "Key that another computer needs to copy the flight, a file as the signing key; the "
            "same on both."
        ),
        option="--share-key", metavar="FILE", default_text=QT_TR_NOOP("the signing key"))
    share_open: bool = setting(
        False, QT_TR_NOOP("Share without a key"),
        QT_TR_NOOP("Share with a network without a key: anyone on it can receive the flight."),
        option="--share-open")
    share_notes: bool = setting(
        False, QT_TR_NOOP("Take notes"),
        QT_TR_NOOP(
            "Write marks and notes of the laptops that copy the flight into its events, with the "
            "name of the laptop."
        ),
        option="--share-notes")
    speed: float | None = setting(
        None, QT_TR_NOOP("Speed"),
        QT_TR_NOOP("Times real time, where LINK is a FLIGHT."),
        option="--speed", metavar="X")
    append: bool = setting(
        False, QT_TR_NOOP("Append"),
        QT_TR_NOOP("Append to a flight that is already finished."),
        option="--continue")
    # fmt: on

    def prepare_folder(
        self,
        path: Path,
        link: str,
        *,
        name: str = "",
        tell: Callable[[str], object] = log.warning,
        prefers_shared: bool = False,
    ) -> FlightFolder:
        """Make the flight folder with copies of all in force; see `prepare_flight_folder`.

        Of a flight that is copied, what is not named here comes from its recorder; with
        `prefers_shared` all that this one has.
        """
        from gsapp.flight.folder_setup import prepare_flight_folder
        from gsapp.telemetry.flight_files import shared_files

        with shared_files(link, self.share_key or self.signing_key, path, tell) as shared:

            def choose(own: str, other: Path | None) -> str | Path | None:
                return (other or own or None) if prefers_shared else (own or other or None)

            folder = prepare_flight_folder(
                path,
                name=name,
                aircraft=choose(self.aircraft, shared.aircraft),
                channel_map=choose(self.channel_map, shared.channel_map),
                calibration=choose(self.calibration, shared.calibration),
                source=link,
                tell=tell,
            )
            shared.store_others(folder)
        return folder
