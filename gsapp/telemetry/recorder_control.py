"""Starting, finding and stopping recorders, which outlive whoever started them."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import time
from dataclasses import dataclass
from pathlib import Path

from gsapp.flight.file_names import LOCK_FILE, LOG_FILE, STATUS_FILE, STOP_FILE
from gsapp.foundation import FlightError, LinkError
from gsapp.foundation.file_lock import lock_holder
from gsapp.foundation.files import GROUP_FILE_MODE, make_group_folder
from gsapp.foundation.process_control import module_command, start_detached_process
from gsapp.telemetry.link_registry import kind_of, parse_link
from gsapp.telemetry.recorder_folder import runtime_lock_path, runtime_status_path
from gsapp.telemetry.recorder_status import RecorderStatus, read_status, runtime_folder
from gsapp.telemetry.settings import TELEMETRY
from gsapp.telemetry.stream_server import ShareRequest, request_shares

# Children of this process by the id of the recorder, kept so that they do not stay behind as
# zombies. On Windows the child may be a launcher, which has another id and ends a moment later.
_children: dict[int, subprocess.Popen[bytes]] = {}


@dataclass(frozen=True, slots=True, kw_only=True)
class RecorderHandle:
    """A recorder, running or not."""

    folder: Path  # The flight folder it records into.
    pid: int  # Its process.

    def is_alive(self) -> bool:
        """Return whether it runs: whether this process holds the lock of the folder."""
        _reap()
        return _recorder_pid(self.folder) == self.pid

    def is_folder_reachable(self) -> bool:
        """Return whether the flight folder is where it was: neither its disk nor its name gone."""
        try:
            (self.folder / LOCK_FILE).stat()
        except OSError:
            return False
        return True

    def status(self) -> RecorderStatus | None:
        return read_last_status(self.folder, self.pid)

    def stop(self, timeout: float = 10.0) -> bool:
        """Ask it to end, and wait; return whether it has ended.

        All that arrived before is written.
        """
        if not self.is_alive():
            return True
        moved = find_recorder(self.folder)
        try:
            ((self.folder if moved is None else moved.folder) / STOP_FILE).touch()
        except OSError:
            # No room even for that; on Windows this ends it less gently.
            with contextlib.suppress(OSError):
                os.kill(self.pid, signal.SIGTERM)
        deadline = time.monotonic() + timeout
        while self.is_alive():
            if time.monotonic() >= deadline:
                return False
            time.sleep(TELEMETRY.poll_interval)
        child = _children.get(self.pid)
        if child is not None:
            # The lock goes a moment before the process, and with that its hold on the log.
            with contextlib.suppress(subprocess.TimeoutExpired):
                child.wait(2.0)
        return True


def start_recorder(
    link: str,
    folder: Path | str,
    *,
    heartbeat: bool | None = None,
    listen_only: bool = False,
    signing_key: str = "",
    while_held: Path | None = None,
) -> RecorderHandle:
    """Start a recorder in a process of its own, which goes on when this one ends.

    The flight folder is made if missing, continued if it holds a record already. For `heartbeat`,
    `listen_only` and `signing_key`, a file, see
    `gsapp.telemetry.recorder_process.record_link`. `while_held` is a lock; the recorder ends
    soon after nobody holds it any more. Raise LinkError if it could not begin; says why.
    """
    parse_link(link)
    path = Path(folder).absolute()
    command = module_command("gsapp.telemetry.recorder_process", link, str(path))
    if heartbeat is not None:
        command.append("--heartbeat" if heartbeat else "--no-heartbeat")
    if listen_only:
        command.append("--listen-only")
    if signing_key:
        command.append(f"--signing-key={signing_key}")
    if while_held is not None:
        command.append(f"--while-held={while_held.absolute()}")
    try:
        make_group_folder(path)
        child, log_start = _spawn(command, path / LOG_FILE)
    except OSError as error:
        raise LinkError(
            f"the recorder cannot begin in {path} ({error.strerror or error}); choose another "
            "folder or correct its permissions"
        ) from error
    handle = RecorderHandle(folder=path, pid=child.pid)
    deadline = time.monotonic() + TELEMETRY.start_timeout
    while time.monotonic() < deadline:
        if child.poll() is not None:
            text = _startup_error_text(path / LOG_FILE, log_start, child.returncode)
            raise LinkError(_describe_port_conflict(link, path) or text)
        if (found := _wait_for_recorder(handle)) is not None:
            _children[found.pid] = child
            return found
        time.sleep(TELEMETRY.poll_interval)
    child.kill()
    child.wait()
    raise LinkError(
        f"the recorder of {link} did not start within {TELEMETRY.start_timeout:g} s: the "
        "computer or disk is too slow; close other programs and try again, or see "
        f"{path / LOG_FILE}"
    )


def restart_recorder(folder: Path | str) -> RecorderHandle:
    """Restart the recorder of a flight folder that stopped unexpectedly, with the same options.

    Return the running one if another window restarted it meanwhile. Raise LinkError if the folder
    holds no recorder status, or the recorder cannot begin.
    """
    status = read_last_status(folder)
    if status is None:
        raise LinkError(f"{folder} holds no recorder status; connect again")
    place = Path(status.folder)
    if (running := find_recorder(place)) is not None:
        return running
    try:
        started = start_recorder(
            status.link, place, heartbeat=status.sends_heartbeats,
            listen_only=status.listen_only, signing_key=status.signing_key,
        )  # fmt: skip
    except LinkError:
        running = find_recorder(place)
        if running is None:
            raise
        return running
    if links := tuple(share.link for share in status.shares):
        # A port that is in use by now ends no recording.
        with contextlib.suppress(FlightError):
            request = ShareRequest(
                links=links, is_open=status.share_open, key_file=status.share_key,
                takes_notes=status.share_notes,
            )  # fmt: skip
            request_shares(place, request)
    return started


def _spawn(command: list[str], log: Path) -> tuple[subprocess.Popen[bytes], int]:
    flags = os.O_WRONLY | os.O_CREAT | os.O_APPEND | getattr(os, "O_BINARY", 0)
    with open(os.open(log, flags, GROUP_FILE_MODE), "ab") as text:  # noqa: PTH123 - a descriptor
        start = text.tell()
        child = start_detached_process(command, text)
    return child, start


def _wait_for_recorder(handle: RecorderHandle) -> RecorderHandle | None:
    """Return the handle once the child records, and not another that does so already.

    Behind a launcher (a virtual environment on Windows has one) the recorder is its child.
    """
    pid = lock_holder(handle.folder / LOCK_FILE)
    if pid is None:
        return None
    found = RecorderHandle(folder=handle.folder, pid=pid)
    status = found.status()
    if status is None or status.state != "recording":
        return None
    in_folder = read_status(handle.folder / STATUS_FILE)
    settling = status.updated_us - status.started_us < TELEMETRY.settled_us
    if settling and (in_folder is None or in_folder.pid != pid):
        return None
    return found if handle.pid in (pid, status.parent) else None


def _describe_port_conflict(link: str, place: Path) -> str:
    """Return where the port of a link is recorded by another recorder of this user, in words.

    To a recorder that meets it, it is one of the programs that keep a port for themselves.
    """
    address = parse_link(link)
    for other in find_recorders():
        status = None if other.folder == place else other.status()
        # What others record may be a flight that has gone, or a link of a package that has.
        with contextlib.suppress(LinkError):
            taken = None if status is None else parse_link(status.link)
            if taken and kind_of(address).conflicts_with(address, kind_of(taken), taken):
                return (
                    f"{address}: already recorded into {other.folder}; stop that recording, or "
                    "name that flight to watch it"
                )
    return ""


def _startup_error_text(log: Path, start: int, code: int) -> str:
    with contextlib.suppress(OSError), log.open("rb") as text:
        text.seek(start)
        lines = text.read().decode("utf-8", "replace").strip().splitlines()
        if lines:
            return lines[-1]
    return f"the recorder ended at once (code {code}); see {log}"


def find_recorder(folder: Path | str) -> RecorderHandle | None:
    """Return the recorder that records into a flight folder now; None where there is none.

    It is found even where the folder cannot be seen any more, under the name that it had. The
    handle then names the folder in which the record continues.
    """
    place = Path(folder).absolute()
    pid = _recorder_pid(place)
    if pid is None:
        return None
    status = read_last_status(place, pid)
    moved = Path(status.folder) if status is not None else place
    if moved != place and lock_holder(moved / LOCK_FILE) == pid:
        place = moved
    return RecorderHandle(folder=place, pid=pid)


def read_last_status(folder: Path | str, pid: int | None = None) -> RecorderStatus | None:
    """Return what the last recorder of a folder, or a given one, told of itself at the latest.

    It tells so in the folder, and while it runs or where the folder takes nothing, in a note in
    the runtime folder.
    """
    place = Path(folder).absolute()
    found = [
        status
        for path in (place / STATUS_FILE, runtime_status_path(place))
        if (status := read_status(path)) is not None and pid in (None, status.pid)
    ]
    return max(found, key=lambda status: status.updated_us, default=None)


def _recorder_pid(place: Path) -> int | None:
    """Return which process records into a folder, be it one that has disappeared."""
    return lock_holder(place / LOCK_FILE) or lock_holder(runtime_lock_path(place))


def find_recorders() -> list[RecorderHandle]:
    """Return all recorders of this user that run now, the oldest first."""
    found: list[tuple[int, RecorderHandle]] = []
    for path in runtime_folder().glob("*.json"):
        status = read_status(path)
        handle = find_recorder(status.folder) if status is not None else None
        if status is None or handle is None:
            for left in (path, path.with_suffix(".lock")):
                with contextlib.suppress(OSError):
                    left.unlink()
        elif (status.started_us, handle) not in found:
            found.append((status.started_us, handle))
    return [handle for _, handle in sorted(found, key=lambda entry: entry[0])]


def _reap() -> None:
    for pid, child in list(_children.items()):
        if child.poll() is not None:
            _children.pop(pid, None)  # another thread may do the same
