"""The recorder as a process: ``python -m gsapp.telemetry.recorder_process LINK FOLDER``.

It holds a lock on the flight folder for as long as it lives, so that there is one at a time and
everyone can tell whether there is one; and another beside its note in the runtime folder, which
tells so where the flight folder cannot be seen any more. It ends cleanly on SIGINT, SIGTERM, or
when a file ``recorder.stop`` appears in the folder.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import shutil
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

from gsapp.flight.file_names import STATUS_FILE
from gsapp.flight.raw_files import RawWriter
from gsapp.foundation import GroundStationError, LinkError
from gsapp.foundation.file_lock import lock_holder
from gsapp.foundation.process_control import inhibit_sleep, on_termination_signal
from gsapp.telemetry.clock import HostClock
from gsapp.telemetry.link_kinds import LinkAddress
from gsapp.telemetry.link_registry import kind_of, parse_link
from gsapp.telemetry.recorder import Recorder
from gsapp.telemetry.recorder_folder import (
    FolderFileCache,
    RecordingClaim,
    claim_replacement_folder,
    runtime_status_path,
)
from gsapp.telemetry.recorder_status import RecorderStatus, runtime_folder_note, write_status
from gsapp.telemetry.settings import TELEMETRY
from gsapp.telemetry.signing import read_signing_key
from gsapp.telemetry.sources import LinkUnavailableError, open_source
from gsapp.telemetry.stream_server import NO_SHARES, ShareRequest, StreamServer


def record_link(
    link: str | LinkAddress,
    folder: Path | str,
    *,
    heartbeat: bool | None = None,
    listen_only: bool = False,
    signing_key: Path | str = "",
    shares: ShareRequest = NO_SHARES,
    stop: threading.Event | None = None,
    give_up: threading.Event | None = None,
    on_status: Callable[[RecorderStatus], None] = lambda _: None,
    **options: Any,
) -> RecorderStatus:
    """Record a link into a flight folder until stopped; return the state at the end.

    Raise LinkError if the link cannot be opened and will not come by itself, FlightError if the
    folder cannot be written to, or is being recorded into already.

    Parameters
    ----------
    folder : Path or str
        Made if missing, continued if it holds a record already.
    heartbeat : bool, optional
        Whether to send the ground station's sign of life; by default only where nothing would
        come without it (``udpout``).
    listen_only : bool
        Whether to send nothing at all. Raise LinkError where nothing would come then (``udpout``).
    signing_key : Path or str
        File of the key of MAVLink signatures; empty for none. Of a flight that is copied, the key
        with which it is shared.
    shares : ShareRequest
        To whom what arrives is passed on. Raise LinkError where that cannot be.
    stop, give_up : threading.Event, optional
        See `Recorder.run`.
    on_status : callable
        Called about twice a second with the state.
    **options
        Handed to the source, for example ``speed`` of a recorded flight.
    """
    address = parse_link(link) if isinstance(link, str) else link
    if listen_only and kind_of(address).needs_heartbeat:
        raise LinkError(
            f"{address}: nothing comes until something was sent, and listen-only sends nothing; "
            "let the other side send, and listen with udpin"
        )
    is_copy = kind_of(address).is_copy
    key_file, key = _read_key((is_copy and shares.key_file) or signing_key)
    claims = [RecordingClaim(Path(folder).absolute())]
    files = FolderFileCache()
    try:
        writer = RawWriter(claims[0].folder)
        if note := runtime_folder_note():
            writer.state.notes.append(note)
        clock = HostClock(after_us=writer.last_stamp)
        source = open_source(address, clock=clock, **options)
        source.prepare(writer.last_stamp, key or b"")

        def tell(status: RecorderStatus) -> None:
            if writer.is_folder_writable():
                files.read(writer.folder)
            for claim in claims:
                claim.write_status(status)
            on_status(status)

        def relocate() -> bool:
            claim = claim_replacement_folder(claims[0].folder, files)
            try:
                whole = writer.move_to(claim.folder)
            except OSError:
                claim.release()
                shutil.rmtree(claim.folder, ignore_errors=True)
                raise
            claims[-1].release_folder()
            claims.append(claim)
            return whole

        server = StreamServer(address, key)
        server.open(shares)
        speaks = kind_of(address).needs_heartbeat if heartbeat is None else heartbeat
        recorder = Recorder(
            source, writer, clock=clock, heartbeat=speaks, listen_only=listen_only or is_copy,
            signing_key=key, signing_key_file=key_file, on_status=tell, server=server,
            relocate=relocate,
        )  # fmt: skip
        try:
            with contextlib.suppress(LinkUnavailableError):
                source.open()
            with inhibit_sleep(f"recording {claims[0].folder.name}"):
                recorder.run(stop or threading.Event(), give_up)
        except BaseException:
            server.close()
            source.close()
            writer.close()
            raise
        finally:
            for claim in claims:
                claim.remove_runtime_status()
        status = recorder.status("stopped")
        if not write_status(writer.folder / STATUS_FILE, status):
            # The disk is full or gone: that it was stopped is told all the same.
            write_status(runtime_status_path(claims[0].folder), status)
        on_status(status)
        return status
    finally:
        for claim in claims:
            claim.release()


def _read_key(path: Path | str) -> tuple[str, bytes | None]:
    """Return the absolute path of a key file and the key in it; empty and None for no path."""
    return (str(Path(path).absolute()), read_signing_key(path)) if path else ("", None)


def create_stop_handler(stop: threading.Event, give_up: threading.Event) -> Callable[[int], None]:
    """Return what to do when asked to end: end; and asked again, give up what the disk refuses."""

    def ask(_signal: int) -> None:
        (give_up if stop.is_set() else stop).set()

    return ask


def stop_when_released(lock: Path, stop: threading.Event) -> None:
    """End a record that is made for another process, once that no longer holds a lock.

    It is held, as by `gsapp.foundation.file_lock.FileLock`, for as long as that process lives;
    `stop` is set when nobody has held it twice in a row.
    """

    def watch() -> None:
        missed = 0
        while missed < 2 and not stop.wait(TELEMETRY.owner_check_interval):
            missed = missed + 1 if lock_holder(lock) is None else 0
        stop.set()

    threading.Thread(target=watch, name="watching", daemon=True).start()


def main(arguments: list[str] | None = None) -> int:
    """Run a recorder; return 0 when it was stopped, 1 when it could not record."""
    parser = argparse.ArgumentParser(description="Record a link into a flight folder.")
    parser.add_argument("link")
    parser.add_argument("folder", type=Path)
    parser.add_argument("--heartbeat", action=argparse.BooleanOptionalAction)
    parser.add_argument("--listen-only", action="store_true", help="send nothing at all")
    parser.add_argument("--signing-key", default="", help="file of the key of signatures")
    parser.add_argument("--speed", type=float, help="of a recorded flight")
    parser.add_argument("--while-held", type=Path, help="end when this lock is released")
    given = parser.parse_args(arguments)
    stop, give_up = threading.Event(), threading.Event()
    if given.while_held is not None:
        stop_when_released(given.while_held, stop)
        give_up = stop  # nobody is there any more to make room
    options = {} if given.speed is None else {"speed": given.speed}
    try:
        with on_termination_signal(create_stop_handler(stop, give_up)):
            record_link(
                given.link, given.folder, heartbeat=given.heartbeat,
                listen_only=given.listen_only, signing_key=given.signing_key, stop=stop,
                give_up=give_up, **options,
            )  # fmt: skip
    except GroundStationError as error:
        sys.stderr.write(f"{error}\n")
        return 1
    return 0


if __name__ == "__main__":
    code = main()
    sys.stderr.flush()
    # A source may hang in a driver; all is written by now.
    os._exit(code)
