"""Whether a window can be shown at all, found out before Qt aborts the process over it."""

from __future__ import annotations

import ctypes
import os
import re
import socket
import subprocess
import sys
from collections.abc import Callable, Collection, Mapping
from pathlib import Path

from gsapp.foundation import GroundStationError
from gsapp.foundation.process_control import module_command

_REMEDY = (
    "Start from a desktop session, use --headless where the command has it, or set "
    "QT_QPA_PLATFORM=offscreen to run without a screen"
)
# What Qt's own X11 plug-in loads when it starts; without it Qt aborts.
_X11_LIBRARY = "libxcb-cursor.so.0"
_X11_PACKAGES = (
    "libxcb-cursor0 libxcb-icccm4 libxcb-keysyms1 libxcb-shape0 libxcb-xkb1 libxkbcommon-x11-0"
)
_ALWAYS_START = frozenset(("offscreen", "minimal", "windows", "cocoa"))
_DISPLAY = re.compile(r"(?P<host>[^:/]*)(/unix)?:(?P<number>\d+)(\.\d+)?")


class NoDisplayError(GroundStationError, RuntimeError):
    """There is no screen to open a window on."""


def _socket_responds(family: int, address: str | tuple[str, int]) -> bool:
    with socket.socket(family, socket.SOCK_STREAM) as probe:
        probe.settimeout(3.0)
        try:
            probe.connect(address)
        except OSError:
            return False
    return True


def _x11_responds(display: str) -> bool:
    match = _DISPLAY.fullmatch(display)
    if match is None:
        # A socket given as a path, as on macOS: let Qt find out.
        return True
    number = int(match["number"])
    if match["host"] not in ("", "unix"):
        return _socket_responds(socket.AF_INET, (match["host"], 6000 + number))
    path = f"/tmp/.X11-unix/X{number}"  # noqa: S108  (the fixed place of X11's sockets)
    return _socket_responds(socket.AF_UNIX, path) or _socket_responds(socket.AF_UNIX, "\0" + path)


def _library_loads(name: str) -> bool:
    try:
        ctypes.CDLL(name)
    except OSError:
        return False
    return True


def _platforms(environment: Mapping[str, str]) -> frozenset[str]:
    """Return the names that Qt's platform plug-ins answer to; none without Qt."""
    try:
        from PySide6.QtCore import QLibraryInfo, QPluginLoader
    except ImportError:
        return frozenset()
    folders = [Path(QLibraryInfo.path(QLibraryInfo.LibraryPath.PluginsPath), "platforms")]
    folders += [
        Path(folder, "platforms")
        for folder in environment.get("QT_PLUGIN_PATH", "").split(os.pathsep)
        if folder
    ]
    if place := environment.get("QT_QPA_PLATFORM_PLUGIN_PATH"):
        folders.append(Path(place))
    found: set[str] = set()
    for folder in folders:
        for file in folder.glob("*"):
            data = QPluginLoader(str(file)).metaData().get("MetaData")
            keys: list[object] = data.get("Keys", []) if isinstance(data, dict) else []
            found.update(str(key).casefold() for key in keys)
    return frozenset(found)


def _platform_starts(name: str) -> bool:
    command = module_command(__name__, "-platform", name)
    try:
        done = subprocess.run(command, capture_output=True, timeout=30.0, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return False
    return done.returncode == 0


def require_display(
    environment: Mapping[str, str] = os.environ,
    platform: str = sys.platform,
    library_loads: Callable[[str], bool] = _library_loads,
    starts: Callable[[str], bool] = _platform_starts,
) -> None:
    """Raise if no window can be shown; call before `QApplication` is made.

    `platform`: as `sys.platform`; only Linux and its kin need a display, the others always have
    one. `starts`: whether Qt starts on a platform that draws straight on the hardware.
    """
    chosen = [name for name in environment.get("QT_QPA_PLATFORM", "").split(";") if name.strip()]
    if chosen:
        _require_one_of(chosen, environment, library_loads, starts)
    elif platform not in ("win32", "darwin"):
        _require_desktop(environment, library_loads)


def offscreen_font_folder(
    environment: Mapping[str, str] = os.environ, platform: str = sys.platform
) -> str | None:
    """Return the folder of the fonts that Qt must be told of; None where it finds them.

    Without a screen it looks in no folder of Windows, and draws words as empty boxes.
    """
    chosen = environment.get("QT_QPA_PLATFORM", "").casefold().partition(":")[0]
    if platform != "win32" or chosen not in ("offscreen", "minimal"):
        return None
    return environment.get("WINDIR", "C:\\Windows") + "\\Fonts"


def _require_one_of(
    chosen: Collection[str],
    environment: Mapping[str, str],
    library_loads: Callable[[str], bool],
    starts: Callable[[str], bool],
) -> None:
    """Raise unless Qt can start on one of the platforms that the user chose; it takes the first."""
    known = _platforms(environment)
    if not known:
        # Without Qt there is another sentence, and no abort.
        return
    problem = ""
    for full_name in chosen:
        name = full_name.partition(":")[0].strip().casefold()
        try:
            if name not in known:
                raise NoDisplayError(
                    f"QT_QPA_PLATFORM is set to '{full_name}', which Qt does not provide here; "
                    f"unset it, or choose one of {', '.join(sorted(known))}"
                )
            if name == "xcb":
                _require_x11(environment.get("DISPLAY", ""), library_loads)
            elif name.startswith("wayland"):
                _require_wayland(environment)
            elif name not in _ALWAYS_START and not starts(full_name):
                raise NoDisplayError(
                    f"QT_QPA_PLATFORM is set to '{full_name}', and Qt cannot start on it here; "
                    "unset it, or set it to offscreen to run without a screen"
                )
        except NoDisplayError as why:
            problem = problem or str(why)
        else:
            return
    raise NoDisplayError(problem)


def _require_desktop(environment: Mapping[str, str], library_loads: Callable[[str], bool]) -> None:
    """Raise unless a Wayland or an X display answers."""
    wayland, display = environment.get("WAYLAND_DISPLAY", ""), environment.get("DISPLAY", "")
    if not wayland and not display:
        raise NoDisplayError(f"No display: neither DISPLAY nor WAYLAND_DISPLAY is set. {_REMEDY}")
    if wayland:
        try:
            _require_wayland(environment)
        except NoDisplayError:
            if not display:
                raise
        else:
            return
    _require_x11(display, library_loads)


def _require_wayland(environment: Mapping[str, str]) -> None:
    name = environment.get("WAYLAND_DISPLAY") or "wayland-0"
    path = Path(environment.get("XDG_RUNTIME_DIR", "/")) / name
    if not _socket_responds(socket.AF_UNIX, str(path)):
        raise NoDisplayError(f"The Wayland display {path} does not answer. {_REMEDY}")


def _require_x11(display: str, library_loads: Callable[[str], bool]) -> None:
    if not display:
        raise NoDisplayError(f"DISPLAY is not set: no X display. {_REMEDY}")
    if not _x11_responds(display):
        raise NoDisplayError(f"The X display '{display}' does not answer. {_REMEDY}")
    if not library_loads(_X11_LIBRARY):
        raise NoDisplayError(
            f"Qt needs {_X11_LIBRARY} to open a window on X11 and it is not installed. "
            f"On Debian or Ubuntu type: sudo apt install {_X11_PACKAGES}"
        )


def main() -> int:
    """Start Qt with the arguments of this process; return 0 if it has a screen."""
    from PySide6.QtGui import QGuiApplication

    return 0 if QGuiApplication(sys.argv).screens() else 1


if __name__ == "__main__":
    sys.exit(main())
