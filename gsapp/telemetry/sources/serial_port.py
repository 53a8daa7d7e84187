"""A serial port that may be unplugged and come back under another name."""

from __future__ import annotations

import contextlib
import errno
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from gsapp.foundation import LinkError
from gsapp.telemetry.clock import Clock
from gsapp.telemetry.link_kinds import (
    LinkAddress,
    PortInfo,
    describe_port,
    is_same_port,
    list_serial_ports,
)
from gsapp.telemetry.sources.link_source import Chunk, LinkUnavailableError, ReconnectingSource


@dataclass(frozen=True, slots=True, kw_only=True)
class UsbIdentity:
    """By what a USB serial port is known, whatever its name."""

    vid: int
    pid: int
    serial_number: str | None

    def matches(self, port: PortInfo) -> bool:
        return (port.vid, port.pid, port.serial_number) == (
            self.vid,
            self.pid,
            self.serial_number,
        )


def open_port(path: str, baud: int) -> Any:
    """Open a serial port for this program alone."""
    import serial

    try:
        return serial.Serial(path, baud, timeout=0, write_timeout=0.1, exclusive=True)
    except ValueError as error:
        raise OSError(errno.EINVAL, f"invalid baud rate: {error}") from error


@contextlib.contextmanager
def _as_os_errors() -> Iterator[None]:
    """Turn what the driver raises into OSError: `termios.error` and TypeError are none."""
    try:
        yield
    except OSError:
        raise
    except Exception as error:
        raise OSError(errno.EIO, str(error)) from error


class SerialSource(ReconnectingSource):
    """Read a serial port.

    Once opened, its USB vendor, product and serial number are kept: when it is unplugged, it is
    looked for by these, since it often comes back as another device. `ports` gives the ports that
    are plugged in, `opener` opens path and baud rate.
    """

    longest_wait = 1.0  # somebody stands there with the plug in the hand

    def __init__(
        self,
        address: LinkAddress,
        *,
        clock: Clock,
        ports: Callable[[], Iterable[PortInfo]] = list_serial_ports,
        opener: Callable[[str, int], Any] = open_port,
    ) -> None:
        super().__init__(address, clock=clock)
        self._ports = ports
        self._opener = opener
        self._identity: UsbIdentity | None = None
        self._path = address.path
        self._port: Any = None

    def _connect(self) -> None:
        self._path = self._find()
        with _as_os_errors():
            self._port = self._opener(self._path, self.address.baud)
        # Where they cannot be listed it is found again by its name only.
        with contextlib.suppress(OSError):
            for port in self._listed():
                same = is_same_port(port.device, self._path)
                if same and port.vid is not None and port.pid is not None:
                    self._identity = UsbIdentity(
                        vid=port.vid, pid=port.pid, serial_number=port.serial_number
                    )
        renamed = "" if self._path == self.address.path else f", now called {self._path}"
        self.state = f"{self.address}: open{renamed}"

    def _listed(self) -> list[PortInfo]:
        with _as_os_errors():
            return list(self._ports())

    def _find(self) -> str:
        """Return the path under which the device is plugged in now."""
        if self._identity is None:
            return self.address.path
        found = [port.device for port in self._listed() if self._identity.matches(port)]
        if not found:
            raise LinkUnavailableError(
                f"{self.address}: device unplugged; plug it in again to resume"
            )
        # Several alike without serial number: rather the one that has the old name.
        old = any(is_same_port(device, self._path) for device in found)
        return self._path if old else sorted(found)[0]

    def _receive(self, timeout: float) -> list[Chunk]:
        if self._port is None:
            return []
        with _as_os_errors():
            if self._port.timeout != timeout:
                # Windows sets up the whole port anew for this, the rate and all.
                self._port.timeout = timeout
            data = self._port.read(1)
            if not data:
                return []
            stamp = self.clock.now_us()
            waiting = self._port.in_waiting
            if waiting:
                data += self._port.read(waiting)
        return [Chunk(stamp, bytes(data))]

    def _send(self, data: bytes) -> None:
        port = self._port
        if port is not None:
            with _as_os_errors():
                port.write(data)

    def _disconnect(self) -> None:
        if self._port is not None:
            port, self._port = self._port, None
            with _as_os_errors():
                port.close()

    def _problem(self, error: OSError) -> LinkError:
        if isinstance(error, LinkError):
            return error
        path, text = self._path, str(error).lower()
        number = error.errno
        if number in (errno.EACCES, errno.EPERM) and "denied" in text and "windows" not in text:
            return LinkError(
                f"{self.address}: no permission to open {path}; add the user to the group of "
                "the port (on Linux: sudo usermod -aG dialout $USER, then log in again)"
            )
        if number in (errno.EBUSY, errno.EAGAIN, errno.EWOULDBLOCK) or "exclusively lock" in text:
            return LinkError(f"{self.address}: {path} is in use by another program; close that")
        # Windows says this of a port that is open elsewhere, and of one that is pulled out while
        # it is read.
        if "could not open" in text and "permissionerror" in text:
            return LinkError(f"{self.address}: {path} is in use by another program; close that")
        # Windows, in the user's language, of a rate: ERROR_INVALID_PARAMETER.
        refused = "cannot configure port" in text and ", 87)" in text
        if number == errno.EINVAL or "invalid baud" in text or refused:
            return LinkError(
                f"{self.address}: {path} cannot run at {self.address.baud} baud; choose the rate "
                "that the radio is set to, usually 57600"
            )
        try:
            there = "; ".join(sorted(map(describe_port, self._listed()))) or "none"
        except OSError:
            there = "unknown"
        odd = "inappropriate ioctl" in text or "not supported by device" in text  # Linux, macOS
        if number in (errno.ENOTTY, errno.EISDIR) or odd:
            return LinkError(
                f"{self.address}: {path} is not a serial port; choose one (plugged in: {there})"
            )
        if number == errno.ENOENT or "filenotfounderror" in text or "could not open" in text:
            return LinkUnavailableError(
                f"{self.address}: there is no serial port {path}; plug it in or choose another "
                f"(plugged in: {there})"
            )
        return LinkUnavailableError(f"{self.address}: {path} is gone; plug it in again to resume")
