"""The package of the how-to page is built, installed, and recorded with."""

from __future__ import annotations

import json
import os
import re
import socket
import subprocess
import sys
import threading
import time
import zipfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from pytestqt.qtbot import QtBot

from gsapp.foundation import LinkError
from gsapp.telemetry import link_registry
from gsapp.telemetry.link_registry import find_link_kind, link_grammar, link_kinds, parse_link

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "how-to" / "add-a-link.md").read_text(encoding="utf-8")
FILES = dict(re.findall(r"^```\w+ ([\w./]+)\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL))
BUILD = "import sys; from setuptools.build_meta import build_wheel; build_wheel(sys.argv[1])"


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with the package in it, as an installer leaves it."""
    folder = tmp_path_factory.mktemp("package")
    source, target = folder / "source", folder / "installed"
    for name, text in FILES.items():
        path = source / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    subprocess.run(
        [sys.executable, "-c", BUILD, str(folder)], cwd=source, check=True, capture_output=True
    )
    (wheel,) = folder.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(target)
    return target


@pytest.fixture
def registered(installed: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Let this process find the package."""
    monkeypatch.syspath_prepend(installed)
    link_registry.forget_packages()
    yield
    link_registry.forget_packages()


class Probe:
    """The device: sends numbered lines once asked."""

    def __init__(self) -> None:
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.link = f"probe:127.0.0.1:{self._listener.getsockname()[1]}"
        self.asked = b""
        threading.Thread(target=self._serve, daemon=True).start()

    def _serve(self) -> None:
        caller, _ = self._listener.accept()
        with caller:
            self.asked = caller.recv(64)
            for count in range(100_000):
                line = f"{1000 + 20 * count},2.5,-0.5,{count % 10}\n"
                try:
                    caller.sendall(line.encode())
                except OSError:
                    return
                time.sleep(0.005)


def test_a_package_adds_a_kind_of_link_that_is_recorded_and_replayed(
    installed: Path, tmp_path: Path
) -> None:
    probe, flight = Probe(), tmp_path / "flight"
    path = os.pathsep.join([str(installed), str(ROOT)])
    run = {"env": {**os.environ, "PYTHONPATH": path}, "cwd": tmp_path, "text": True}
    gsapp = [sys.executable, "-m", "gsapp.cli"]
    recorder = subprocess.Popen([*gsapp, "record", probe.link, "--out", str(flight)], **run)
    deadline = time.monotonic() + 120.0
    lines = flight / "raw.txt"
    while not (lines.exists() and lines.stat().st_size > 6000):
        assert recorder.poll() is None
        assert time.monotonic() < deadline
        time.sleep(0.1)
    (flight / "recorder.stop").touch()
    assert recorder.wait(60) == 0
    assert probe.asked == b"stream 50\n"
    subprocess.run(
        [*gsapp, "replay", str(flight), "--headless", "--json", "out.json"],
        check=True, stdout=subprocess.DEVNULL, **run,
    )  # fmt: skip
    channels = json.loads((tmp_path / "out.json").read_text())["channels"]
    recorded = lines.read_bytes().count(b"\n")
    assert recorded - 1 <= channels["alpha"]["count"] <= recorded
    assert channels["alpha"]["mean"] == pytest.approx(0.0436332, rel=1e-5)
    assert channels["dynamic_pressure"]["max"] == pytest.approx(9.0)
    help_text = subprocess.run([*gsapp, "record", "--help"], check=True, capture_output=True, **run)
    assert "probe:HOST:PORT" in " ".join(help_text.stdout.split())


@pytest.mark.usefixtures("registered")
def test_the_connect_dialog_offers_it_with_its_fields_and_channel_map(
    qtbot: QtBot, tmp_path: Path
) -> None:
    from ui.dialogs.connect import ConnectDialog, connection_options
    from ui.display_style import DisplayStyle
    from ui.settings import Settings

    dialog = ConnectDialog(Settings(), DisplayStyle(), connection_options(), tmp_path)
    qtbot.addWidget(dialog)
    link, usual = dialog.link, dialog.fields["channel_map"].value
    link.kind.setCurrentIndex(link.kind.findData("probe"))
    link.kind.activated.emit(link.kind.currentIndex())
    link.host.setText("10.0.0.9")
    link.port.set_value(5005)
    assert link.value == "probe:10.0.0.9:5005"
    assert link.input_check.is_valid
    assert dialog.test.button.isEnabled()
    assert Path(dialog.request.channel_map).name == "probe.toml"
    link.text.setEditText("serial:COM7:57600")
    assert (link.kind.currentData(), dialog.request.channel_map) == ("serial", usual)


@pytest.mark.usefixtures("registered")
def test_it_stands_in_the_grammar_and_mistakes_are_told() -> None:
    assert link_kinds()[-1].name == "probe"
    assert "probe:HOST:PORT" in link_grammar()
    assert str(parse_link("probe:5005")) == "probe:127.0.0.1:5005"
    with pytest.raises(LinkError, match=r"write for example probe:127\.0\.0\.1:5005"):
        parse_link("probe")
    with pytest.raises(LinkError, match="did you mean 'probe:h:1'"):
        parse_link("prob:h:1")


def test_a_package_that_cannot_be_loaded_harms_no_other_link(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "broken-1.dist-info"
    folder.mkdir()
    (folder / "METADATA").write_text("Metadata-Version: 2.1\nName: broken\nVersion: 1\n")
    (folder / "entry_points.txt").write_text(
        "[gsapp.links]\nbroken = no_such_module:KIND\nudpin = no_such_module:KIND\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    link_registry.forget_packages()
    assert parse_link("udpin:14550").kind == "udpin"
    assert "broken" not in link_grammar()
    with pytest.raises(LinkError, match=r"'broken'.*no_such_module"):
        find_link_kind("broken")
    link_registry.forget_packages()


def test_the_program_starts_without_looking_for_packages() -> None:
    code = (
        "import sys\nfrom gsapp.cli.main import app\n"
        "print('gsapp.telemetry.link_registry' in sys.modules)"
    )
    run = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, check=True, capture_output=True, text=True
    )
    assert run.stdout.strip() == "False"
