#!/usr/bin/env python3
"""Set up the ground station on a fresh machine and run it.

    python3 packaging/bootstrap.py demo [--headless]   the whole job on a virtual flight
    python3 packaging/bootstrap.py test                all checks, and the tests that are not long
    python3 packaging/bootstrap.py test --all          all checks and tests
    python3 packaging/bootstrap.py bench [NAME ...]    the benchmarks
    python3 packaging/bootstrap.py run [ARGUMENTS]     the program itself: the window, or a command
    python3 packaging/bootstrap.py setup [parquet] [notebook] [dask]   only the setting up; with
                                                       Parquet files, with pandas and xarray for
                                                       notebooks, with Dask for clusters

On Windows type py in place of python3.

Everything is installed into `.venv` beside this folder, at the versions of the lock files here,
without the files that unused_files.txt names; the environment variable GSAPP_VENV names another
folder, as for a clone that cannot be written to. Nothing but Python's standard library is used
here; Python 3.11 to 3.14 is needed.
"""

from __future__ import annotations

import contextlib
import ctypes
import hashlib
import os
import re
import shutil
import signal
import subprocess
import sys
import sysconfig
import tempfile
import time
from collections.abc import Iterator
from fnmatch import translate
from importlib.metadata import PackagePath, distributions
from pathlib import Path

HERE = Path(__file__).resolve().parent
PROJECT = HERE.parent
VENV = Path(os.environ.get("GSAPP_VENV") or PROJECT / ".venv").expanduser().absolute()
OLDEST, NEWEST = (3, 11), (3, 14)
# A third while two wait for what they watch; no restart after a crash: the rest of the file would
# be waited for without end.
ON_TWO_CORES = ["-n3", "--dist=loadfile", "--no-loadscope-reorder", "--max-worker-restart=0"]
# mypy's newest way: not tried on Windows, and it writes into the clone.
AS_TWO = ["--num-workers=2"] if os.name != "nt" and os.access(PROJECT, os.W_OK) else []
IMPORTS = """
import importlib, pkgutil
for root in ("gsapp", "ui", "calibration"):
    package = importlib.import_module(root)
    for module in pkgutil.walk_packages(package.__path__, root + "."):
        if not module.name.endswith("__main__"):
            importlib.import_module(module.name)
"""
CONTRACT = "from importlinter.cli import lint_imports_command as check; check()"
USUAL_TIME = {False: "11 minutes on two cores", True: "25 minutes on two cores"}
CACHES = {
    "PYTHONPYCACHEPREFIX": "python",
    "RUFF_CACHE_DIR": "ruff",
    "MYPY_CACHE_DIR": "mypy",
    "HYPOTHESIS_STORAGE_DIRECTORY": "hypothesis",
}
# MB, all wheels for Linux on Intel, and what is installed of them
DOWNLOAD = {
    "run.lock": 190,
    "parquet.lock": 50,
    "notebook.lock": 14,
    "dask.lock": 5,
    "test.lock": 35,
}
ON_DISK = {
    "run.lock": 470,
    "parquet.lock": 110,
    "notebook.lock": 50,
    "dask.lock": 21,
    "test.lock": 120,
}
UNUSED_FILES = HERE / "unused_files.txt"
REPORT_INTERVAL = 10.0  # s, between two lines on a download

# Shared library -> Debian package. PySide6's wheels bring Qt but not what Qt stands on.
QT_LIBRARIES = {
    "libGL.so.1": "libgl1",
    "libEGL.so.1": "libegl1",
    "libxkbcommon.so.0": "libxkbcommon0",
    "libdbus-1.so.3": "libdbus-1-3",
    "libfontconfig.so.1": "libfontconfig1",
    "libglib-2.0.so.0": "libglib2.0-0",
    # for a window on X11
    "libxcb-cursor.so.0": "libxcb-cursor0",
    "libxcb-icccm.so.4": "libxcb-icccm4",
    "libxcb-keysyms.so.1": "libxcb-keysyms1",
    "libxcb-shape.so.0": "libxcb-shape0",
    "libxcb-xkb.so.1": "libxcb-xkb1",
    "libxkbcommon-x11.so.0": "libxkbcommon-x11-0",
}
CERTIFICATES = (
    "/etc/ssl/certs/ca-certificates.crt",  # Debian, Arch
    "/etc/pki/tls/certs/ca-bundle.crt",  # Fedora
    "/etc/ssl/ca-bundle.pem",  # openSUSE
    "/etc/ssl/cert.pem",  # Alpine
)


class SetupError(Exception):
    """Something that the user must do first; the text says what."""


def say(text: str) -> None:
    """Print one line at once."""
    print(text, flush=True)


def other_python() -> list[str] | None:
    """Return the command of another Python that fits; None where there is none."""
    for minor in range(NEWEST[1], OLDEST[1] - 1, -1):
        if found := shutil.which(f"python3.{minor}"):
            return [found]
        # Windows has one program that calls them all.
        launcher = shutil.which("py") if os.name == "nt" else None
        if launcher and succeeds([launcher, f"-3.{minor}", "-c", ""]):
            return [launcher, f"-3.{minor}"]
    return None


def succeeds(command: list[str]) -> bool:
    """Return whether a command ends well; what it says is dropped."""
    return subprocess.run(command, check=False, capture_output=True).returncode == 0


def check_python() -> None:
    """Run under a fitting Python: this one, or another found on the PATH."""
    if not OLDEST <= sys.version_info[:2] <= NEWEST:
        other = other_python()
        if other is not None:
            command = [*other, str(Path(__file__).resolve()), *sys.argv[1:]]
            sys.exit(give_place(command, dict(os.environ)))
        wanted = f"{OLDEST[0]}.{OLDEST[1]} to {NEWEST[0]}.{NEWEST[1]}"
        example = "py -3.12" if os.name == "nt" else "python3.12"
        raise SetupError(
            f"Python {wanted} is needed; this is {sys.version.split()[0]}. Install one of them and "
            f"call it by its name, for example: {example} packaging/bootstrap.py demo"
        )
    if sysconfig.get_platform() in {"win32", "win-arm64"}:
        raise SetupError(
            "This Python is not the one for 64-bit Intel and AMD, for which alone all packages are "
            "made on Windows. Install that one, which runs on ARM as well, and call again."
        )


def loads(library: str) -> bool:
    """Return whether the system's loader finds a shared library."""
    try:
        ctypes.CDLL(library)
    except OSError:
        return False
    return True


def has_fonts() -> bool:
    """Return whether any scalable font is installed; Qt draws empty boxes without one."""
    folders = (Path("/usr/share/fonts"), Path("/usr/local/share/fonts"), Path.home() / ".fonts")
    return any(
        path.suffix.lower() in {".ttf", ".otf", ".ttc"}
        for folder in folders
        if folder.is_dir()
        for path in folder.rglob("*")
    )


def missing_packages() -> list[str]:
    """Return the Debian packages that this Linux lacks."""
    packages = [package for library, package in QT_LIBRARIES.items() if not loads(library)]
    try:
        import ensurepip  # noqa: F401
        import venv  # noqa: F401
    except ImportError:
        packages.append("python3-venv")
        if sys.executable != "/usr/bin/python3":
            packages.append(f"python{sys.version_info[0]}.{sys.version_info[1]}-venv")
    if not any(Path(path).is_file() for path in CERTIFICATES):
        packages.append("ca-certificates")
    if not has_fonts():
        packages.append("fonts-dejavu-core")
    return packages


def install_system_packages() -> None:
    """Install what Linux lacks where that is allowed, else name the one command to type."""
    if not sys.platform.startswith("linux"):
        return
    packages = missing_packages()
    if not packages:
        return
    names = " ".join(packages)
    if shutil.which("apt-get") is None:
        raise SetupError(
            "These are missing (Debian's names; your distribution's may differ), install them "
            f"and call again: {names}"
        )
    prefix = [] if os.geteuid() == 0 else ["sudo", "-n"]
    may_install = not prefix or (
        shutil.which("sudo") is not None
        and subprocess.call(["sudo", "-n", "true"], stderr=subprocess.DEVNULL) == 0
    )
    command = f"sudo apt-get update && sudo apt-get install -y --no-install-recommends {names}"
    if not may_install:
        raise SetupError(f"System packages are missing. Type this, then call again:\n  {command}")
    say(f"Installing system packages: {names}")
    environment = dict(os.environ, DEBIAN_FRONTEND="noninteractive")
    install = ["apt-get", "install", "-y", "-qq", "--no-install-recommends", *packages]
    for step in (["apt-get", "update", "-qq"], install):
        if subprocess.call(prefix + step, env=environment) != 0:
            raise SetupError(f"That did not succeed. Type this, then call again:\n  {command}")
    left = missing_packages()
    if left:
        raise SetupError(f"Still missing after the installation: {' '.join(left)}")


def venv_python() -> Path:
    """Return the interpreter of the virtual environment."""
    return VENV / ("Scripts/python.exe" if os.name == "nt" else "bin/python")


def state_of(lock: Path) -> str:
    """Return a fingerprint of all that the packages of a lock file are installed from."""
    digest = hashlib.sha256(sys.version.encode() + str(PROJECT).encode())
    for path in (lock, UNUSED_FILES, PROJECT / "pyproject.toml"):
        digest.update(path.read_bytes())
    return digest.hexdigest()


def pip(*arguments: str, megabytes: int = 0) -> None:
    """Run pip inside the environment; say from time to time how much of a download has come.

    pip installs from the folder of its downloads and removes them from it: once there are fewer
    bytes than before, it installs.
    """
    command = [str(venv_python()), "-P", "-m", "pip", "--disable-pip-version-check", "-q"]
    started = time.monotonic()
    most, installs = 0.0, not megabytes
    with tempfile.TemporaryDirectory(prefix="pip-", dir=VENV) as folder:
        variables = {**environment(), "TMPDIR": folder}
        with subprocess.Popen([*command, *arguments], env=variables) as process:
            while True:
                try:
                    code = process.wait(REPORT_INTERVAL)
                    break
                except subprocess.TimeoutExpired:
                    came, passed = size(Path(folder)) / 1e6, time.monotonic() - started
                    installs, most = installs or came < most, max(came, most)
                    loaded = f"{came:.0f} of about {megabytes} MB downloaded"
                    say(f"  {passed:.0f} s: {'installing' if installs else loaded}")
    if code != 0:
        raise SetupError(
            "pip failed; see its message above. Check the network and run this again: what is "
            "installed already is kept."
        )


def size(folder: Path) -> int:
    """Return how many bytes the files below a folder hold, which may go meanwhile."""
    total = 0
    for parent, _, names in os.walk(folder):
        for name in names:
            with contextlib.suppress(OSError):
                total += (Path(parent) / name).stat().st_size
    return total


def patterns(path: Path) -> set[str]:
    """Return the patterns of a file like unused_files.txt; none where there is no such file."""
    lines = path.read_text("utf-8").splitlines() if path.is_file() else []
    return {line for line in lines if line and not line.startswith("#")}


def unused_files(locks: list[Path]) -> Iterator[PackagePath]:
    """Yield the files of locked packages that nothing loads; those of others are the user's."""
    named = "|".join(translate(pattern) for pattern in patterns(UNUSED_FILES))
    locked = {
        canonical(name)
        for lock in locks
        for name in re.findall(r"^([\w.-]+)==", lock.read_text("utf-8"), re.MULTILINE)
    }
    for package in distributions(path=[sysconfig.get_path("purelib", "venv", {"base": str(VENV)})]):
        if canonical(package.name) in locked:
            yield from (file for file in package.files or () if re.match(named, file.as_posix()))


def canonical(name: str) -> str:
    """Return the name of a package as comparisons need it."""
    return re.sub(r"[-_.]+", "-", name).lower()


def remove_unused_files(locks: list[Path]) -> None:
    """Remove what the program never loads of its packages: a third of their size.

    The list is kept beside them: once the program uses more than it did, all is installed anew.
    """
    shutil.copyfile(UNUSED_FILES, VENV / UNUSED_FILES.name)
    for file in unused_files(locks):
        path = Path(os.path.normpath(file.locate()))
        with contextlib.suppress(OSError):  # on Windows, in use
            for compiled in path.parent.glob(f"__pycache__/{path.stem}.*.pyc"):
                compiled.unlink()
            path.unlink(missing_ok=True)
            os.removedirs(path.parent)  # those that are empty


def make_environment() -> None:
    """Make an empty virtual environment, in place of that of another Python or list of files."""
    current = subprocess.run(
        [str(venv_python()), "-c", "import sys; print(sys.version)"],
        check=False, capture_output=True, text=True,
    ).stdout.strip() if venv_python().is_file() else ""  # fmt: skip
    removed = patterns(VENV / UNUSED_FILES.name)
    if current == sys.version.strip() and removed <= patterns(UNUSED_FILES):
        return
    if (VENV / "pyvenv.cfg").is_file():
        shutil.rmtree(VENV, ignore_errors=True)
    try:
        VENV.mkdir(parents=True, exist_ok=True)
        if any(VENV.iterdir()):
            raise SetupError(
                f"{VENV} holds other files. Set GSAPP_VENV to a new folder, and run this again."
            )
        tempfile.TemporaryFile(dir=VENV).close()
    except OSError as error:
        raise SetupError(
            f"Cannot write {VENV} ({error.strerror}). Set the environment variable GSAPP_VENV to "
            "a folder for the virtual environment, such as ~/gsapp-venv, and run this again."
        ) from error
    if subprocess.call([sys.executable, "-m", "venv", str(VENV)]) != 0:
        raise SetupError(f"Cannot make the virtual environment {VENV}; see the message above.")


def set_up(*extras: str) -> None:
    """Make the virtual environment as the lock files say; do nothing if it already is so.

    `extras` are locks beside that of what runs: ``parquet``, ``notebook``, ``dask``, ``test``,
    ``build``.
    """
    install_system_packages()
    stamps = {HERE / f"{name}.lock": VENV / f"{name}.stamp" for name in ("run", *extras)}
    locks = [
        lock
        for lock, stamp in stamps.items()
        if not (venv_python().is_file() and stamp.is_file() and stamp.read_text() == state_of(lock))
    ]
    if not locks:
        return
    loaded, kept = (sum(sizes.get(lock.name, 0) for lock in locks) for sizes in (DOWNLOAD, ON_DISK))
    say(f"Setting up {VENV}, once: up to {loaded} MB to download, {kept} MB on the disk")
    make_environment()
    for lock in locks:
        # Wheels only: nothing is built on the user's machine. Most modules are never imported.
        pip("install", "--require-hashes", "--no-deps", "--no-compile", "--only-binary", ":all:",
            "-r", str(lock), megabytes=DOWNLOAD.get(lock.name, 0))  # fmt: skip
    pip("install", "--no-deps", "--no-build-isolation", "-e", str(PROJECT))
    remove_unused_files(locks)
    # What is imported is compiled now: later, several processes would do so, or users who cannot.
    run(["-P", "-c", IMPORTS], QT_QPA_PLATFORM="offscreen")
    for lock in locks:
        stamps[lock].write_text(state_of(lock))


def environment() -> dict[str, str]:
    """Return the environment for what is run: BLAS on one thread, the venv's commands first."""
    # The first two would let other packages, even of another Python, stand in for the locked ones.
    # With the third each process, hundreds in the tests, would compile the whole program.
    dropped = {"PYTHONPATH", "PYTHONHOME", "PYTHONDONTWRITEBYTECODE"}
    kept = {key: text for key, text in os.environ.items() if key not in dropped}
    if not os.access(PROJECT, os.W_OK):  # a read-only clone
        kept |= {name: str(VENV / "cache" / tool) for name, tool in CACHES.items()}
        kept["PYTEST_ADDOPTS"] = "-p no:cacheprovider"
    return dict(
        kept,
        PATH=f"{venv_python().parent}{os.pathsep}{os.environ.get('PATH', '')}",
        OPENBLAS_NUM_THREADS="1",
        OMP_NUM_THREADS="1",
        VECLIB_MAXIMUM_THREADS="1",
        PYTHONUTF8="1",
    )


def run(arguments: list[str], folder: Path | None = None, **variables: str) -> int:
    """Run the environment's Python, in the user's folder or another; return the exit code."""
    command = [str(venv_python()), *arguments]
    return subprocess.call(command, cwd=folder, env={**environment(), **variables})


def give_place(command: list[str], variables: dict[str, str], folder: Path | None = None) -> int:
    """Run what ends by itself when asked to, in its own time: a record, for example, is closed."""
    if os.name == "nt":
        # They reach what runs as well, which else would be killed a quarter of a second later.
        for number in (signal.SIGINT, signal.SIGBREAK):
            signal.signal(number, lambda _number, _frame: None)
        return subprocess.call(command, cwd=folder, env=variables)
    # In the place of this one, so that whoever stops this process stops that one.
    if folder is not None:
        os.chdir(folder)
    sys.stdout.flush()
    return os.execve(command[0], command, variables)  # noqa: S606


def hand_over(arguments: list[str], folder: Path | None = None) -> int:
    """Give the environment's Python the place of this one."""
    return give_place([str(venv_python()), *arguments], environment(), folder)


def test(arguments: list[str]) -> int:
    """Run every check, the tests last; go on after a failure so that one run shows all.

    Long tests run with ``--all``; what else is given goes to pytest.
    """
    with_long = "--all" in arguments
    selected = [text for text in arguments if text != "--all"] + ["-m", ""] * with_long
    checks = [
        ("ruff, rules", ["-m", "ruff", "check", "."]),
        ("ruff, format", ["-m", "ruff", "format", "--check", "."]),
        ("mypy, strict", ["-m", "mypy", *AS_TWO]),
        ("import contract", ["-c", CONTRACT, "--no-cache"]),
        ("tests", ["-m", "pytest", *ON_TWO_CORES, *selected]),
    ]
    say(f"This usually takes {USUAL_TIME[with_long]}.")
    failed = []
    for name, command in checks:
        started = time.monotonic()
        say(f"--- {name}")
        if run(command, PROJECT, QT_QPA_PLATFORM="offscreen") != 0:
            failed.append(name)
        say(f"--- {name}: {time.monotonic() - started:.0f} s")
    if failed:
        say(f"FAILED: {', '.join(failed)}")
    return 1 if failed else 0


def main() -> int:
    """Do what the first argument says; return the exit code."""
    command, arguments = (sys.argv[1] if len(sys.argv) > 1 else "help"), sys.argv[2:]
    actions = {
        "setup": lambda: 0,
        "run": lambda: hand_over(["-P", "-m", "gsapp", *arguments]),
        "demo": lambda: hand_over(["-P", "-m", "gsapp", "demo", *arguments]),
        "test": lambda: test(arguments),
        "bench": lambda: hand_over(["tests/bench/run.py", *arguments], PROJECT),
    }
    known = ["parquet", "notebook", "dask"]
    extras = {"setup": arguments, "test": [*known, "test"], "bench": [*known, "test"]}
    if command not in actions or (command == "setup" and not set(arguments) <= set(known)):
        say(__doc__ or "")
        return 0 if command in {"help", "-h", "--help"} else 2
    try:
        check_python()
        set_up(*extras.get(command, ()))
        return actions[command]()
    except SetupError as error:
        print(error, file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 130


if __name__ == "__main__":
    sys.exit(main())
