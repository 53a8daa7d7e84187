#!/usr/bin/env python3
"""Build what is handed out: the standalone program for this system, and the Python packages.

    python3 packaging/build.py folder     build/standalone/gsapp, the program with its own Python
    python3 packaging/build.py archive    the folder, and an archive of it in build/packages
    python3 packaging/build.py deb        the folder, and a Debian package of it in build/packages
    python3 packaging/build.py wheel      wheel and sdist in build/packages
    python3 packaging/build.py check TAG  whether a tag v1.2.3 names the version of pyproject.toml

On Windows type py in place of python3. PyInstaller and the locked packages are installed into
build/venv; Python 3.11 to 3.14 is needed to build, and none where the program runs.
"""

from __future__ import annotations

import os
import platform
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import bootstrap

PROJECT = bootstrap.PROJECT
BUILD = PROJECT / "build"
STANDALONE = BUILD / "standalone" / "gsapp"
PACKAGES = BUILD / "packages"
LINUX = bootstrap.HERE / "linux"
VERSION = tomllib.loads((PROJECT / "pyproject.toml").read_text("utf-8"))["project"]["version"]
SYSTEM = {"win32": "windows", "darwin": "macos"}.get(sys.platform, sys.platform)

# Neither these nor glibc are in the folder: they belong to the graphics driver, and
# fontconfig-config says where fonts are, of which it needs one package.
SYSTEM_LIBRARIES = (
    "fontconfig-config, libdrm2, libegl1, libgl1, libwayland-client0, libwayland-cursor0, "
    "libwayland-egl1, libxcb1"
)
CONTROL = """\
Package: gsapp
Version: {version}
Architecture: {architecture}
Maintainer: The maintainers <maintainers@localhost>
Installed-Size: {kilobytes}
Depends: libc6 (>= {glibc}), {libraries}
Suggests: speech-dispatcher, xdg-utils
Section: science
Priority: optional
Description: ground station for flight-testing remotely piloted research aircraft
 Records, shows and replays flights, calibrates sensors, estimates derivatives and
 finds effects that a model lacks.
"""


def set_up() -> None:
    """Make the virtual environment to build in: what runs, and what builds."""
    bootstrap.VENV = BUILD / "venv"
    bootstrap.set_up("parquet", "build")


def run_module(*arguments: str) -> None:
    """Run a module in the virtual environment; end this program if it fails."""
    if code := bootstrap.run(["-P", "-m", *arguments], PROJECT):
        raise bootstrap.SetupError(f"{arguments[0]} failed with exit code {code}; see above.")


def build_folder() -> None:
    """Build the program, and start it once."""
    set_up()
    run_module(
        "PyInstaller", "--noconfirm", "--log-level=WARN", f"--distpath={STANDALONE.parent}",
        f"--workpath={BUILD / 'pyinstaller'}", str(bootstrap.HERE / "gsapp.spec"),
    )  # fmt: skip
    if sys.platform == "linux":
        strip_libraries()
    done = subprocess.run([STANDALONE / "gsapp", "--version"], stdout=subprocess.PIPE, check=True)
    if done.stdout.decode().strip() != VERSION:
        raise bootstrap.SetupError(f"The build is of version {done.stdout!r}, not {VERSION}.")
    bootstrap.say(f"{STANDALONE}: {size(STANDALONE) / 1e6:.0f} MB")


def strip_libraries() -> None:
    """Remove the debugging symbols of Python and Arrow: 35 MB.

    Libraries whose paths a wheel's maker edited, in folders ``*.libs``, may be damaged by it.
    """
    folder = STANDALONE / "_internal"
    libraries = [*folder.glob("libpython*"), *folder.glob("pyarrow/lib*.so*")]
    output("strip", "--strip-unneeded", *(str(path) for path in libraries))


def build_archive() -> None:
    """Pack the folder as users of this system expect it."""
    build_folder()
    PACKAGES.mkdir(parents=True, exist_ok=True)
    name = PACKAGES / f"gsapp-{VERSION}-{SYSTEM}-{platform.machine().lower()}"
    # A zip would hold a library for each link to it.
    kind = "zip" if sys.platform == "win32" else "xztar"
    show(Path(shutil.make_archive(str(name), kind, STANDALONE.parent, STANDALONE.name)))


def build_deb() -> None:
    """Pack the folder with menu entry, icon and the rule for telemetry radios."""
    if shutil.which("dpkg-deb") is None:
        raise bootstrap.SetupError("A Debian package is made by dpkg-deb, which is missing here.")
    build_folder()
    root = BUILD / "deb"
    shutil.rmtree(root, ignore_errors=True)
    shutil.copytree(STANDALONE, root / "usr/lib/gsapp", symlinks=True)
    link = root / "usr/bin/gsapp"
    link.parent.mkdir()
    link.symlink_to("../lib/gsapp/gsapp")
    for source, target in {
        LINUX / "gsapp.desktop": "usr/share/applications/gsapp.desktop",
        LINUX / "gsapp.svg": "usr/share/icons/hicolor/scalable/apps/gsapp.svg",
        LINUX / "60-gsapp.rules": "usr/lib/udev/rules.d/60-gsapp.rules",
        PROJECT / "LICENSE": "usr/share/doc/gsapp/copyright",
    }.items():
        (root / target).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(source, root / target)
    make_readable(root)
    architecture = output("dpkg", "--print-architecture")
    (root / "DEBIAN").mkdir()
    (root / "DEBIAN" / "control").write_text(
        CONTROL.format(
            version=VERSION, architecture=architecture, kilobytes=size(root) // 1000,
            glibc=platform.libc_ver()[1], libraries=SYSTEM_LIBRARIES,
        )
    )  # fmt: skip
    PACKAGES.mkdir(parents=True, exist_ok=True)
    package = PACKAGES / f"gsapp_{VERSION}_{architecture}.deb"
    output("dpkg-deb", "--root-owner-group", "-Zzstd", "-z9", "--build", str(root), str(package))
    show(package)


def build_wheel() -> None:
    """Make wheel and sdist with the locked build backend."""
    set_up()
    run_module("build", "--no-isolation", f"--outdir={PACKAGES}", str(PROJECT))
    for path in sorted(PACKAGES.glob(f"gsapp_ground_station-{VERSION}*")):
        show(path)


def make_readable(root: Path) -> None:
    """Let everybody read and enter, whatever the umask of who builds."""
    for path in (root, *root.rglob("*")):
        if not path.is_symlink():
            runs = path.is_dir() or os.access(path, os.X_OK)
            path.chmod(0o755 if runs else 0o644)


def output(*command: str) -> str:
    """Return what a command prints."""
    return subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True).stdout.strip()


def size(folder: Path) -> int:
    """Return how many bytes a folder holds; many of its libraries are links to others in it."""
    return sum(path.lstat().st_size for path in folder.rglob("*"))


def show(path: Path) -> None:
    """Print a file that was made, and its size."""
    bootstrap.say(f"{path}: {path.stat().st_size / 1e6:.1f} MB")


def main() -> int:
    """Build what the argument says; return the exit code."""
    actions = {
        "folder": build_folder,
        "archive": build_archive,
        "deb": build_deb,
        "wheel": build_wheel,
    }
    match sys.argv[1:]:
        case ["check", tag]:
            bootstrap.say(f"version {VERSION}, tag {tag}")
            return int(tag != f"v{VERSION}")
        case [name] if name in actions:
            pass
        case _:
            bootstrap.say(__doc__ or "")
            return 2
    try:
        bootstrap.check_python()
        actions[name]()
    except (bootstrap.SetupError, subprocess.CalledProcessError, OSError) as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
