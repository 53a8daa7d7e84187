"""Whether a window can be shown at all, found out before Qt aborts the process over it."""

from __future__ import annotations

import ctypes
import os
import re
import socket
import sys
from collections.abc import Callable, Mapping
from pathlib import Path

from gsapp.foundation import GroundStationError

_REMEDY = (
    "Start from a desktop session, use --headless where the command has it, or set "
    "QT_QPA_PLATFORM=offscreen to run without a screen"
)
# What Qt's own X11 plug-in loads when it starts; without it Qt aborts.
_X11_LIBRARY = "libxcb-cursor.so.0"
_X11_PACKAGES = (
    "libxcb-cursor0 libxcb-icccm4 libxcb-keysyms1 libxcb-shape0 libxcb-xkb1 libxkbcommon-x11-0"
)
_DISPLAY = re.compile(r"(?P<host>[^:/]*)(/unix)?:(?P<number>\d+)(\.\d+)?")


class NoDisplayError(GroundStationError, RuntimeError):
    """There is no screen to open a window on."""


def _answers(family: int, address: object) -> bool:
    with socket.socket(family, socket.SOCK_STREAM) as probe:
        probe.settimeout(3.0)
        try:
            probe.connect(address)
        except OSError:
            return False
    return True


def _x11_answers(display: str) -> bool:
    match = _DISPLAY.fullmatch(display)
    if match is None:
        # A socket given as a path, as on macOS: let Qt find out.
        return True
    number = int(match["number"])
    if match["host"] not in ("", "unix"):
        return _answers(socket.AF_INET, (match["host"], 6000 + number))
    path = f"/tmp/.X11-unix/X{number}"  # noqa: S108  (the fixed place of X11's sockets)
    return _answers(socket.AF_UNIX, path) or _answers(socket.AF_UNIX, "\0" + path)


def _library_loads(name: str) -> bool:
    try:
        ctypes.CDLL(name)
    except OSError:
        return False
    return True


def require_display(
    environment: Mapping[str, str] = os.environ,
    platform: str = sys.platform,
    library_loads: Callable[[str], bool] = _library_loads,
) -> None:
    """Raise if no window can be shown; call before `QApplication` is made.

    Parameters
    ----------
    environment : mapping of str to str
        Environment variables.
    platform : str
        As `sys.platform`; only Linux and its kin are checked, the others always have a display.
    library_loads : callable
        Whether a shared library can be loaded.

    Raises
    ------
    NoDisplayError
        With what is missing and what to do.
    """
    if platform in ("win32", "darwin") or environment.get("QT_QPA_PLATFORM"):
        # Named by the user: Qt itself says what is wrong with it.
        return
    wayland, display = environment.get("WAYLAND_DISPLAY", ""), environment.get("DISPLAY", "")
    if not wayland and not display:
        raise NoDisplayError(
            f"There is no display: neither DISPLAY nor WAYLAND_DISPLAY is set. {_REMEDY}"
        )
    if wayland:
        path = Path(environment.get("XDG_RUNTIME_DIR", "/")) / wayland
        if _answers(socket.AF_UNIX, str(path)):
            return
        if not display:
            raise NoDisplayError(f"The Wayland display {path} does not answer. {_REMEDY}")
    if not _x11_answers(display):
        raise NoDisplayError(f"The X display '{display}' does not answer. {_REMEDY}")
    if not library_loads(_X11_LIBRARY):
        raise NoDisplayError(
            f"Qt needs {_X11_LIBRARY} to open a window on X11 and it is not installed. "
            f"On Debian or Ubuntu type: sudo apt install {_X11_PACKAGES}"
        )
