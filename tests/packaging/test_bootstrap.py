"""The bootstrap names what is missing; the locks cover, with hashes, all that is declared."""

from __future__ import annotations

import ast
import importlib.util
import os
import re
import signal
import subprocess
import sys
import tomllib
from pathlib import Path
from types import ModuleType, SimpleNamespace

import pytest

PROJECT = Path(__file__).parents[2]
BOOTSTRAP = PROJECT / "packaging" / "bootstrap.py"


@pytest.fixture
def bootstrap() -> ModuleType:
    spec = importlib.util.spec_from_file_location("bootstrap_under_test", BOOTSTRAP)
    assert spec is not None
    assert spec.loader is not None
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
    run, test = locked("run.lock"), locked("test.lock")
    extras = project["project"]["optional-dependencies"].values()
    declared = names(
        project["project"]["dependencies"] + [text for each in extras for text in each]
    )
    assert declared <= set(run)
    assert names(project["dependency-groups"]["test"]) <= set(run) | set(test)
    for entry in [*run.values(), *test.values()]:
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
    """A record, for example, is closed first. Ctrl-C goes to all, another signal to one process."""
    inner = (
        "import signal, sys, time\n"
        "signal.signal(signal.SIGTERM, signal.default_int_handler)\n"
        "try:\n"
        "    print('ready', flush=True); time.sleep(60)\n"
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
        assert process.stdout is not None
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
    with pytest.raises(bootstrap.SetupError, match=r"apt-get install -y .*libegl1"):
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
    with pytest.raises(bootstrap.SetupError, match=r"Python 3\.11 to 3\.14 is needed"):
        bootstrap.check_python()


def test_on_windows_another_python_is_called_by_the_launcher(
    bootstrap: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The newest that it has; names with a version are not found there."""
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
    with pytest.raises(bootstrap.SetupError, match="64-bit Intel and AMD"):
        bootstrap.check_python()
    monkeypatch.setattr(bootstrap.sysconfig, "get_platform", lambda: "win-amd64")
    bootstrap.check_python()


def test_a_wrong_call_shows_the_commands_and_exits_with_2() -> None:
    done = subprocess.run([sys.executable, BOOTSTRAP, "dance"], capture_output=True, text=True)
    assert done.returncode == 2
    assert "bootstrap.py demo" in done.stdout
