"""No display: a sentence instead of an aborted process."""

import os
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from gsapp.cli._usage_errors import CommandUsageError
from gsapp.cli.replay import replay
from gsapp.foundation import FlightError
from ui.app import run_window
from ui.display_check import NoDisplayError, offscreen_font_folder, require_display


def _loads(_name: str) -> bool:
    return True


def _lacks(_name: str) -> bool:
    return False


_WORKS = {"library_loads": _loads}


def test_without_any_display_the_remedy_is_named() -> None:
    with pytest.raises(NoDisplayError, match="QT_QPA_PLATFORM=offscreen"):
        require_display({}, "linux", **_WORKS)


@pytest.mark.skipif(not hasattr(socket, "AF_UNIX"), reason="no sockets by path here")
def test_a_display_that_does_not_answer_is_named() -> None:
    with pytest.raises(NoDisplayError, match="':987' does not answer"):
        require_display({"DISPLAY": ":987"}, "linux", **_WORKS)
    environment = {"WAYLAND_DISPLAY": "wayland-9", "XDG_RUNTIME_DIR": "/nowhere"}
    with pytest.raises(NoDisplayError, match="Wayland display /nowhere/wayland-9"):
        require_display(environment, "linux", **_WORKS)


# macOS takes no more than 104 bytes for the path of a socket; its folders for tests have more.
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="only there Qt has Wayland")
def test_a_display_that_answers_is_taken(tmp_path: Path) -> None:
    with socket.socket(socket.AF_UNIX) as server:
        server.bind(str(tmp_path / "wayland-1"))
        server.listen()
        environment = {"WAYLAND_DISPLAY": "wayland-1", "XDG_RUNTIME_DIR": str(tmp_path)}
        require_display(environment, "linux", **_WORKS)


def test_a_missing_library_names_the_packages() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        number = server.getsockname()[1] - 6000
        environment = {"DISPLAY": f"127.0.0.1:{number}"}
        require_display(environment, "linux", library_loads=_loads)
        with pytest.raises(NoDisplayError, match="libxcb-cursor0"):
            require_display(environment, "linux", library_loads=_lacks)


def test_a_platform_that_draws_nowhere_and_other_systems_need_no_display() -> None:
    require_display({"QT_QPA_PLATFORM": "offscreen"}, "linux")
    require_display({"QT_QPA_PLATFORM": "Offscreen:enable_fonts"}, "linux")
    require_display({}, "darwin")
    require_display({}, "win32")


def test_without_a_screen_qt_is_told_of_the_fonts_of_windows() -> None:
    hidden = {"QT_QPA_PLATFORM": "offscreen:size=1", "WINDIR": "D:\\Windows"}
    assert offscreen_font_folder(hidden, "win32") == "D:\\Windows\\Fonts"
    assert offscreen_font_folder({"WINDIR": "D:\\Windows"}, "win32") is None
    assert offscreen_font_folder(hidden, "darwin") is None
    assert offscreen_font_folder(hidden, "linux") is None


def test_a_platform_that_qt_lacks_is_named_with_those_it_has() -> None:
    for system in ("linux", "darwin", "win32"):
        with pytest.raises(NoDisplayError, match=r"'nosuch'.*offscreen"):
            require_display({"QT_QPA_PLATFORM": "nosuch"}, system)
    require_display({"QT_QPA_PLATFORM": "nosuch;offscreen"}, "linux")


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="only there Qt has xcb")
def test_a_platform_chosen_by_the_user_needs_its_display_too() -> None:
    with pytest.raises(NoDisplayError, match="DISPLAY"):
        require_display({"QT_QPA_PLATFORM": "xcb"}, "linux", **_WORKS)
    environment = {"QT_QPA_PLATFORM": "wayland;xcb", "XDG_RUNTIME_DIR": "/nowhere"}
    with pytest.raises(NoDisplayError, match="/nowhere/wayland-0"):
        require_display(environment, "linux", **_WORKS)
    environment = {"QT_QPA_PLATFORM": "eglfs"}
    require_display(environment, "linux", starts=_loads)
    with pytest.raises(NoDisplayError, match="Qt cannot start"):
        require_display(environment, "linux", starts=_lacks)


def test_the_command_with_a_platform_that_qt_lacks_says_so_and_does_not_abort() -> None:
    done = subprocess.run(
        [sys.executable, "-c", "from gsapp.cli.main import main; main()"],
        env={**os.environ, "QT_QPA_PLATFORM": "nosuch"},
        capture_output=True,
        text=True,
        timeout=240,
    )
    assert done.returncode == 1, done.stderr
    assert done.stderr.startswith("gsapp: QT_QPA_PLATFORM")
    assert done.stderr.count("\n") == 1


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="only there Qt needs a display")
def test_the_window_without_a_display_raises_and_does_not_abort() -> None:
    """In a process of its own: an abort of Qt would show as a signal."""
    program = (
        "from ui.app import run_window\n"
        "from gsapp.foundation import GroundStationError\n"
        "try: run_window()\n"
        "except GroundStationError as error: print(error)\n"
    )
    hidden = ("DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM")
    environment = {name: value for name, value in os.environ.items() if name not in hidden}
    done = subprocess.run(
        [sys.executable, "-c", program],
        env=environment,
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("No display")


@pytest.mark.parametrize("speed", ["80", "0", "-1", "0.05", "fast", "nan"])
def test_window_and_command_refuse_the_same_speeds_of_a_replay(speed: str, tmp_path: Path) -> None:
    with pytest.raises(FlightError, match=r"0\.1 to 50"):
        run_window(tmp_path / "absent", speed=speed)
    with pytest.raises(CommandUsageError, match=r"0\.1 to 50"):
        replay(headless=True, flight=tmp_path / "absent", speed=speed)
