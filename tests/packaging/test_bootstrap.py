"""The bootstrap names what is missing; the locks cover, with hashes, all that is declared."""

import ast
import importlib.util
import os
import re
import signal
import subprocess
import sys
import threading
import time
import tomllib
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from types import ModuleType, SimpleNamespace

import pytest

PROJECT = Path(__file__).parents[2]
BOOTSTRAP = PROJECT / "packaging" / "bootstrap.py"


@pytest.fixture
def bootstrap() -> ModuleType:
    spec = importlib.util.spec_from_file_location("bootstrap_under_test", BOOTSTRAP)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def locked(name: str) -> dict[str, str]:
    text = (PROJECT / "packaging" / name).read_text()
    entries = re.split(r"^(?=[A-Za-z0-9])", text, flags=re.MULTILINE)[1:]
    return {re.match(r"[A-Za-z0-9_.-]+", entry)[0]: entry for entry in entries}


def names(requirements: list[str]) -> set[str]:
    return {re.match(r"[A-Za-z0-9_.-]+", text)[0].lower() for text in requirements}


def test_it_needs_the_standard_library_only() -> None:
    tree = ast.parse(BOOTSTRAP.read_text())
    imported = {
        name.name.split(".")[0]
        for node in ast.walk(tree)
        if isinstance(node, ast.Import)
        for name in node.names
    } | {
        node.module.split(".")[0]
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom) and node.module
    }
    assert imported <= set(sys.stdlib_module_names)


def test_the_locks_cover_every_declared_package_with_hashes() -> None:
    project = tomllib.loads((PROJECT / "pyproject.toml").read_text())
    run, test, build = locked("run.lock"), locked("test.lock"), locked("build.lock")
    asked = locked("parquet.lock") | locked("notebook.lock") | locked("dask.lock")
    extras = project["project"]["optional-dependencies"].values()
    declared = names(
        project["project"]["dependencies"] + [text for each in extras for text in each]
    )
    assert declared <= set(run) | set(asked)
    assert names(project["dependency-groups"]["test"]) <= set(run) | set(test)
    assert names(project["dependency-groups"]["build"]) <= set(build)
    for entry in [*run.values(), *asked.values(), *test.values(), *build.values()]:
        assert "--hash=sha256:" in entry
        assert "==" in entry.splitlines()[0]
    # 6.12.0 aborts on Python 3.11: docs/decisions/0003.
    assert re.search(r"==6\.(10|11)\.", run["pyside6-essentials"])


def test_no_foreign_package_can_stand_in_for_the_program() -> None:
    assert "gsapp" not in {*locked("run.lock"), *locked("test.lock")}


def test_what_is_compiled_is_kept(bootstrap, monkeypatch) -> None:
    """Wherever the machine forbids it: each process would compile the whole program."""
    monkeypatch.setenv("PYTHONDONTWRITEBYTECODE", "1")
    look = "import sys; raise SystemExit(sys.dont_write_bytecode)"
    assert subprocess.run([sys.executable, "-c", look]).returncode == 1
    environment = bootstrap.environment()
    assert subprocess.run([sys.executable, "-c", look], env=environment).returncode == 0


def test_no_other_packages_are_mixed_with_the_locked_ones(bootstrap, monkeypatch) -> None:
    monkeypatch.setenv("PYTHONPATH", "/opt/other/site-packages")
    assert "PYTHONPATH" not in bootstrap.environment()


def load_bootstrap(venv: Path, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    monkeypatch.setenv("GSAPP_VENV", str(venv))
    spec = importlib.util.spec_from_file_location("bootstrap_elsewhere", BOOTSTRAP)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_environment_is_made_where_a_variable_says(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    bootstrap = load_bootstrap(tmp_path / "venv", monkeypatch)
    made: list[str] = []
    monkeypatch.setattr(bootstrap.subprocess, "call", lambda command: made.append(command[-1]))
    with pytest.raises(bootstrap.SetupError):
        bootstrap.make_environment()
    assert made == [str(tmp_path / "venv")]
    assert tmp_path / "venv" in bootstrap.venv_python().parents


def test_a_folder_with_other_files_is_never_replaced(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "thesis.tex").write_text("my life")
    bootstrap = load_bootstrap(tmp_path, monkeypatch)
    with pytest.raises(bootstrap.SetupError, match="GSAPP_VENV"):
        bootstrap.make_environment()
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.tex"]


def test_where_nothing_can_be_written_the_variable_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").touch()
    bootstrap = load_bootstrap(tmp_path / "file" / ".venv", monkeypatch)
    with pytest.raises(bootstrap.SetupError, match="GSAPP_VENV"):
        bootstrap.make_environment()


def test_a_read_only_clone_keeps_its_caches_in_the_environment(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    bootstrap = load_bootstrap(tmp_path, monkeypatch)
    monkeypatch.delenv("MYPY_CACHE_DIR", raising=False)
    monkeypatch.setattr(bootstrap.os, "access", lambda *_: True)
    assert "MYPY_CACHE_DIR" not in bootstrap.environment()
    monkeypatch.setattr(bootstrap.os, "access", lambda *_: False)
    for name in ("PYTHONPYCACHEPREFIX", "RUFF_CACHE_DIR", "MYPY_CACHE_DIR"):
        assert tmp_path in Path(bootstrap.environment()[name]).parents


class SlowFile(BaseHTTPRequestHandler):
    def do_GET(self) -> None:
        self.send_response(200)
        self.send_header("Content-Length", "2000000")
        self.end_headers()
        for _ in range(20):
            self.wfile.write(bytes(100_000))
            time.sleep(0.1)

    def log_message(self, *_: object) -> None:
        """Stay quiet."""


def test_a_slow_download_shows_how_far_it_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    bootstrap = load_bootstrap(tmp_path, monkeypatch)
    monkeypatch.setattr(bootstrap, "venv_python", lambda: Path(sys.executable))
    monkeypatch.setattr(bootstrap, "REPORT_INTERVAL", 0.2)
    with ThreadingHTTPServer(("127.0.0.1", 0), SlowFile) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        url = f"http://127.0.0.1:{server.server_port}/slow-1.0-py3-none-any.whl"
        with pytest.raises(bootstrap.SetupError):  # two megabytes of nothing are no package
            bootstrap.pip("download", "--no-cache-dir", "--no-deps", url, megabytes=2)
        server.shutdown()
    lines = re.findall(r"([\d.]+) of about 2 MB", capsys.readouterr().out)
    assert len(lines) > 5
    assert "1" in lines
    assert not list(tmp_path.glob("pip-*"))


PIP = """
import os, pathlib, time
wheel = pathlib.Path(os.environ["TMPDIR"]) / "a.whl"
for size in (1, 2, 3):
    wheel.write_bytes(bytes(size * 1_000_000))
    time.sleep(0.5)
wheel.unlink()
time.sleep(1)
"""


def test_what_follows_the_download_is_the_installation(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    bootstrap = load_bootstrap(tmp_path, monkeypatch)
    (tmp_path / "pip.py").write_text(PIP)
    (tmp_path / "python").write_text(f"#!/bin/sh\nexec {sys.executable} {tmp_path}/pip.py\n")
    (tmp_path / "python").chmod(0o755)
    monkeypatch.setattr(bootstrap, "venv_python", lambda: tmp_path / "python")
    monkeypatch.setattr(bootstrap, "REPORT_INTERVAL", 0.2)
    bootstrap.pip("install", megabytes=3)
    lines = capsys.readouterr().out.splitlines()
    shown = [int(found[1]) for line in lines if (found := re.search(r": (\d+) of", line))]
    assert shown
    assert shown == sorted(shown)
    assert "installing" in lines[-1]


def test_the_readme_tells_the_duration_and_the_download_that_the_program_does(bootstrap) -> None:
    text = (PROJECT / "README.md").read_text(encoding="utf-8")
    assert all(time in text for time in bootstrap.USUAL_TIME.values())
    for lock in ("run.lock", "parquet.lock", "notebook.lock", "dask.lock"):
        assert f"{bootstrap.DOWNLOAD[lock]} MB to download" in text
        assert f"{bootstrap.ON_DISK[lock]} MB on the disk" in text


def add_package(site: Path, name: str, *files: str) -> None:
    for file in files:
        path = site / file
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("")
    about = site / f"{name}-1.0.dist-info"
    about.mkdir(parents=True)
    (about / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
    (about / "RECORD").write_text("".join(f"{file},,\n" for file in files))


def test_only_unused_files_of_locked_packages_are_removed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    bootstrap = load_bootstrap(tmp_path, monkeypatch)
    site = Path(bootstrap.sysconfig.get_path("purelib", "venv", {"base": str(tmp_path)}))
    dialects = "pymavlink/dialects/v20"
    add_package(site, "pymavlink", f"{dialects}/all.py", f"{dialects}/paparazzi.py")
    add_package(site, "NumPy", "numpy/__init__.py", "numpy/ma/tests/test_core.py")
    add_package(site, "mine", "mine/tests/data.py", "mine/fast.h")
    compiled = site / dialects / "__pycache__"
    compiled.mkdir()
    for name in ("all", "paparazzi"):
        (compiled / f"{name}.cpython-313.pyc").touch()
    bootstrap.remove_unused_files([PROJECT / "packaging" / "run.lock"])
    kept = {path.relative_to(site).as_posix() for path in site.rglob("*.*") if path.is_file()}
    assert {name for name in kept if "dist-info" not in name} == {
        f"{dialects}/all.py", f"{dialects}/__pycache__/all.cpython-313.pyc", "numpy/__init__.py",
        "mine/tests/data.py", "mine/fast.h",
    }  # fmt: skip
    assert not (site / "numpy/ma/tests").exists()


def test_an_environment_that_lacks_what_is_used_is_made_anew(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    bootstrap = load_bootstrap(tmp_path, monkeypatch)
    monkeypatch.setattr(bootstrap, "venv_python", lambda: Path(sys.executable))
    made: list[str] = []
    monkeypatch.setattr(bootstrap.subprocess, "call", lambda command: made.append(command[-1]) or 0)
    (tmp_path / "pyvenv.cfg").touch()
    (tmp_path / "unused_files.txt").write_text("lxml/*")
    bootstrap.make_environment()
    assert made == []
    (tmp_path / "unused_files.txt").write_text("lxml/*\nscipy/*")
    bootstrap.make_environment()
    assert made == [str(tmp_path)]
    assert list(tmp_path.iterdir()) == []


def test_what_is_installed_already_is_not_installed_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    bootstrap = load_bootstrap(tmp_path, monkeypatch)
    installed: list[str] = []
    monkeypatch.setattr(bootstrap, "install_system_packages", lambda: None)
    monkeypatch.setattr(bootstrap, "make_environment", lambda: None)
    monkeypatch.setattr(bootstrap, "venv_python", lambda: Path(sys.executable))
    monkeypatch.setattr(bootstrap, "run", lambda *_, **__: 0)
    monkeypatch.setattr(bootstrap, "pip", lambda *args, **_: installed.append(Path(args[-1]).name))

    def install(*extras: str) -> list[str]:
        installed.clear()
        bootstrap.set_up(*extras)
        return [name for name in installed if name.endswith(".lock")]

    assert install() == ["run.lock"]
    assert install("parquet", "test") == ["parquet.lock", "test.lock"]
    assert install("parquet") == install() == []
    monkeypatch.setattr(bootstrap, "state_of", lambda _: "of a new version")
    assert install("parquet") == ["run.lock", "parquet.lock"]


LOADED = r"""
import sys
from pathlib import Path
import matplotlib.backends.backend_pdf, scipy.io, scipy.stats, pyarrow.parquet, h5py
import PySide6.QtWidgets
app = PySide6.QtWidgets.QApplication([])
files = {module.__file__ for module in sys.modules.values() if getattr(module, "__file__", None)}
if sys.platform == "linux":
    maps = Path("/proc/self/maps").read_text().splitlines()
    files |= {line.split(maxsplit=5)[5] for line in maps if "site-packages" in line}
print(*files, sep="\n")
"""


def test_nothing_that_the_program_imports_is_named_as_unused(bootstrap: ModuleType) -> None:
    named = re.compile(
        "|".join(map(bootstrap.translate, bootstrap.patterns(bootstrap.UNUSED_FILES)))
    )
    done = subprocess.run(
        [sys.executable, "-P", "-c", bootstrap.IMPORTS + LOADED],
        capture_output=True, text=True, cwd=PROJECT,
        env={**bootstrap.environment(), "QT_QPA_PLATFORM": "offscreen", "PYTHONPATH": str(PROJECT)},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    files = [Path(line).as_posix() for line in done.stdout.splitlines()]
    files = [file.partition("/site-packages/")[2] for file in files]
    # Tried, and done without: formats of images (Qt, Pillow), remote files (Arrow), lxml.
    tried = re.compile(r"lxml/|PIL/_|pillow\.libs/|pyarrow/(_\w+fs|libarrow_s3)|.*/imageformats/")
    assert "PySide6/QtOpenGL" in " ".join(files)
    assert [file for file in files if named.match(file) and not tried.match(file)] == []


def test_a_stuck_test_stands_in_the_summary_with_the_reasons_of_skips(
    bootstrap: ModuleType, tmp_path: Path
) -> None:
    (tmp_path / "test_stuck.py").write_text("import time\ndef test_waits(): time.sleep(200)\n")
    (tmp_path / "test_skipped.py").write_text(
        "import pytest\n@pytest.mark.skip(reason='no wind')\ndef test_skipped(): pass\n"
    )
    command = [
        sys.executable, "-m", "pytest", "-c", PROJECT / "pyproject.toml", f"--rootdir={tmp_path}",
        *bootstrap.ON_TWO_CORES, "-o", "faulthandler_timeout=1", "-p", "no:cacheprovider", tmp_path,
    ]  # fmt: skip
    done = subprocess.run(command, capture_output=True, encoding="utf-8", timeout=120)
    assert done.returncode == 1
    summary = done.stdout.partition("short test summary")[2]
    assert re.search(r"FAILED .*test_waits", summary)
    assert re.search(r"SKIPPED .*no wind", summary)


@pytest.mark.skipif(os.name == "nt", reason="Ctrl-C is sent another way on Windows")
@pytest.mark.parametrize(("send", "number"), [("killpg", "SIGINT"), ("kill", "SIGTERM")])
@pytest.mark.parametrize(
    "begin",
    [
        "bootstrap.venv_python = lambda: Path(sys.executable); bootstrap.hand_over(['-c', inner])",
        # As under a Python that is too old: the same file is called under another.
        "bootstrap.OLDEST = bootstrap.NEWEST = (3, 99); sys.argv[1:] = [];"
        "bootstrap.other_python = lambda: [sys.executable, '-c', inner]; bootstrap.check_python()",
    ],
)
def test_what_runs_is_asked_to_end_and_may_take_its_time(
    begin: str, send: str, number: str
) -> None:
    # Short sleeps: a signal between the last look of the interpreter and the call that sleeps is
    # answered only after it.
    inner = (
        "import signal, sys, time\n"
        "signal.signal(signal.SIGTERM, signal.default_int_handler)\n"
        "try:\n"
        "    print('ready', flush=True)\n"
        "    for _ in range(600): time.sleep(0.1)\n"
        "except KeyboardInterrupt:\n"
        "    time.sleep(1); sys.exit(7)\n"
    )
    outer = (
        f"import sys; sys.path.insert(0, {str(BOOTSTRAP.parent)!r}); import bootstrap\n"
        f"from pathlib import Path; inner = {inner!r}; {begin}\n"
    )
    command = [sys.executable, "-c", outer]
    # The tests themselves may run where Ctrl-C is ignored: in the background of a script.
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, start_new_session=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),  # noqa: PLW1509 - no locks
    ) as process:  # fmt: skip
        assert process.stdout.readline() == b"ready\n"
        getattr(os, send)(process.pid, getattr(signal, number))
        assert process.wait(20.0) == 7


def test_without_root_the_one_command_is_named(
    bootstrap: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setattr(bootstrap, "loads", lambda library: library != "libEGL.so.1")
    monkeypatch.setattr(bootstrap, "has_fonts", lambda: True)
    monkeypatch.setattr(bootstrap.os, "geteuid", lambda: 1000, raising=False)
    monkeypatch.setattr(
        bootstrap.shutil, "which", lambda name: "/usr/bin/apt-get" if name == "apt-get" else None
    )
    with pytest.raises(bootstrap.SetupError, match="libegl1"):
        bootstrap.install_system_packages()


def test_other_distributions_are_told_what_is_missing(
    bootstrap: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setattr(bootstrap, "loads", lambda _: False)
    monkeypatch.setattr(bootstrap.shutil, "which", lambda _: None)
    with pytest.raises(bootstrap.SetupError, match=r"libgl1 libegl1"):
        bootstrap.install_system_packages()


def test_an_unfit_python_without_another_says_which_is_needed(
    bootstrap: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "version_info", (3, 9, 1))
    monkeypatch.setattr(bootstrap.shutil, "which", lambda _: None)
    with pytest.raises(bootstrap.SetupError, match=r"3\.11 to 3\.14"):
        bootstrap.check_python()


def test_on_windows_another_python_is_called_by_the_launcher(
    bootstrap: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[str] = []

    def succeeds(command: list[str]) -> bool:
        asked.append(command[1])
        return command[1] == "-3.12"

    monkeypatch.setattr(bootstrap, "os", SimpleNamespace(name="nt"))
    monkeypatch.setattr(bootstrap, "succeeds", succeeds)
    monkeypatch.setattr(
        bootstrap.shutil, "which", lambda name: "C:/py.exe" if name == "py" else None
    )
    assert bootstrap.other_python() == ["C:/py.exe", "-3.12"]
    assert asked == ["-3.14", "-3.13", "-3.12"]


def test_another_python_is_found_by_its_name_elsewhere(
    bootstrap: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    named = {"python3.13": "/opt/python3.13", "python3.11": "/usr/bin/python3.11", "py": "/x/py"}
    monkeypatch.setattr(bootstrap.shutil, "which", named.get)
    monkeypatch.setattr(bootstrap, "os", SimpleNamespace(name="posix"))
    assert bootstrap.other_python() == ["/opt/python3.13"]


@pytest.mark.parametrize("system", ["win32", "win-arm64"])
def test_a_python_that_windows_has_no_packages_for_is_told(
    bootstrap: ModuleType, monkeypatch: pytest.MonkeyPatch, system: str
) -> None:
    monkeypatch.setattr(bootstrap.sysconfig, "get_platform", lambda: system)
    with pytest.raises(bootstrap.SetupError, match="64-bit"):
        bootstrap.check_python()
    monkeypatch.setattr(bootstrap.sysconfig, "get_platform", lambda: "win-amd64")
    bootstrap.check_python()


def test_a_wrong_call_shows_the_commands_and_exits_with_2() -> None:
    done = subprocess.run([sys.executable, BOOTSTRAP, "dance"], capture_output=True, text=True)
    assert done.returncode == 2
    assert "bootstrap.py demo" in done.stdout
