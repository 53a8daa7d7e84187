"""The serial ports of this computer."""

from __future__ import annotations

from collections.abc import Iterable
from os.path import normcase
from typing import Protocol


class PortInfo(Protocol):
    """What is known of a serial port that is plugged in."""

    device: str
    serial_number: str | None
    vid: int | None
    pid: int | None


def is_same_port(one: str, other: str) -> bool:
    """Return whether two names are those of one serial port.

    Windows calls it COM5 however the user wrote it; macOS has two devices for each, of which it
    lists ``/dev/cu.*`` only.
    """
    first, second = (normcase(name.replace("/dev/tty.", "/dev/cu.")) for name in (one, other))
    return first == second


def list_serial_ports() -> Iterable[PortInfo]:
    """Return the serial ports of this computer."""
    from serial.tools import list_ports

    ports: Iterable[PortInfo] = list_ports.comports()
    return ports


def describe_port(port: object) -> str:
    """Return a port's name and what its USB device says of itself: product, maker, serial number.

    Parameters
    ----------
    port : serial.tools.list_ports_common.ListPortInfo
        Or anything with some of its attributes.
    """
    name = str(getattr(port, "device", ""))
    known = [str(getattr(port, key, None) or "") for key in ("description", "manufacturer")]
    words = [each for each in known if each not in ("", "n/a", name)]
    if number := getattr(port, "serial_number", None):
        words.append(f"serial number {number}")
    return f"{name} ({', '.join(dict.fromkeys(words))})" if words else name
