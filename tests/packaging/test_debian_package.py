"""The Debian package holds the program, and what makes it known to desktop and serial ports."""

import importlib.util
import shutil
import subprocess
from pathlib import Path
from types import ModuleType

import pytest

PACKAGING = Path(__file__).parents[2] / "packaging"
DPKG_DEB = shutil.which("dpkg-deb") or ""
pytestmark = pytest.mark.skipif(not DPKG_DEB, reason="no dpkg-deb")


@pytest.fixture
def build(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """Return build.py with a program that only prints a line."""
    monkeypatch.syspath_prepend(PACKAGING)
    spec = importlib.util.spec_from_file_location("build_under_test", PACKAGING / "build.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    for name in ("BUILD", "PACKAGES", "STANDALONE"):
        monkeypatch.setattr(module, name, tmp_path / name.lower())
    program = module.STANDALONE / "gsapp"
    (program.parent / "_internal").mkdir(parents=True)
    (program.parent / "_internal" / "library.so").write_bytes(bytes(300_000))
    (program.parent / "library.so").symlink_to("_internal/library.so")
    program.write_text("#!/bin/sh\necho started\n")
    program.chmod(0o700)
    monkeypatch.setattr(module, "build_folder", lambda: None)
    return module


@pytest.fixture
def package(build: ModuleType) -> Path:
    build.build_deb()
    (package,) = build.PACKAGES.iterdir()
    return package


def field(package: Path, name: str) -> str:
    return subprocess.check_output([DPKG_DEB, "-f", package, name], text=True).strip()


def test_the_installed_program_starts(package: Path, tmp_path: Path) -> None:
    root = tmp_path / "root"
    subprocess.run([DPKG_DEB, "-x", package, root], check=True)
    assert subprocess.check_output([root / "usr/bin/gsapp"], text=True) == "started\n"
    assert (root / "usr/lib/gsapp/library.so").is_symlink()
    for name in (
        "share/applications/gsapp.desktop", "share/icons/hicolor/scalable/apps/gsapp.svg",
        "share/doc/gsapp/copyright", "lib/udev/rules.d/60-gsapp.rules",
    ):  # fmt: skip
        assert (root / "usr" / name).stat().st_mode & 0o777 == 0o644


def test_the_fields_of_the_package(build: ModuleType, package: Path) -> None:
    assert field(package, "Version") == build.VERSION
    assert 300 <= int(field(package, "Installed-Size")) < 400
    depends = field(package, "Depends")
    # The library of fonts is in the build, its configuration and a font are not.
    assert {"fontconfig-config", "libegl1", "libgl1"} <= set(depends.split(", "))
    assert depends.startswith("libc6 (>= ")
