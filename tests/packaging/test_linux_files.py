"""Menu entry, icon and rules of the Debian package are valid."""

import configparser
import shutil
import subprocess
import tomllib
from pathlib import Path

import pytest
from PySide6.QtSvg import QSvgRenderer

ROOT = Path(__file__).parents[2]
LINUX = ROOT / "packaging" / "linux"


def has_verify() -> bool:
    """Return whether udev is new enough to check a file of rules (systemd 254)."""
    call = ["udevadm", "verify", "--help"]
    return shutil.which("udevadm") is not None and subprocess.run(call).returncode == 0


def test_the_menu_entry_starts_the_program_with_its_icon() -> None:
    entry = configparser.ConfigParser(interpolation=None, delimiters="=")
    entry.read(LINUX / "gsapp.desktop", encoding="utf-8")
    keys = entry["Desktop Entry"]
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert keys["Exec"] in project["scripts"]
    assert QSvgRenderer(str(LINUX / f"{keys['Icon']}.svg")).isValid()


@pytest.mark.skipif(shutil.which("desktop-file-validate") is None, reason="no desktop-file-utils")
def test_the_menu_entry_is_valid() -> None:
    call = ["desktop-file-validate", LINUX / "gsapp.desktop"]
    done = subprocess.run(call, capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (0, "")


@pytest.mark.skipif(not has_verify(), reason="udevadm is missing or cannot verify")
def test_the_rules_for_serial_ports_are_valid() -> None:
    call = ["udevadm", "verify", LINUX / "60-gsapp.rules"]
    assert subprocess.run(call).returncode == 0


def test_the_rules_stand_before_the_one_that_gives_access() -> None:
    (rules,) = LINUX.glob("*.rules")
    assert int(rules.name.partition("-")[0]) < 73
    lines = rules.read_text(encoding="utf-8").splitlines()
    given = [line for line in lines if line.endswith('TAG+="uaccess"')]
    assert len(given) >= 9
    assert all(line.startswith('ATTRS{idVendor}=="') for line in given)
