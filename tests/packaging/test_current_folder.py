"""Folders named like a package of the program lie where users work: `calibration/` holds theirs."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
NAMES = ("calibration", "gsapp", "ui")
WHERE = f"import {', '.join(NAMES)}; print(*(m.__file__ for m in ({', '.join(NAMES)})), sep='\\n')"
OURS = [str(ROOT / name / "__init__.py") for name in NAMES]


def run(*arguments: str | Path, folder: Path, **variables: str) -> subprocess.CompletedProcess[str]:
    kept = {name: text for name, text in os.environ.items() if name != "PYTHONSAFEPATH"}
    return subprocess.run(
        [sys.executable, *arguments], cwd=folder, env={**kept, **variables}, timeout=240,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, encoding="utf-8",
    )  # fmt: skip


@pytest.fixture
def certificates(tmp_path: Path) -> Path:
    for name in NAMES:
        (tmp_path / name / "2026-05-12").mkdir(parents=True)
    return tmp_path


@pytest.fixture
def hostile(tmp_path: Path) -> Path:
    (tmp_path / "calibration").mkdir()
    for name in ("calibration/__init__.py", "ui.py"):
        (tmp_path / name).write_text("raise ImportError('a file of the user')")
    return tmp_path


def test_scripts_and_notebooks_import_the_program(certificates: Path) -> None:
    done = run("-c", f"import sys; assert sys.path[0] == ''; {WHERE}", folder=certificates)
    assert done.stdout.splitlines() == OURS


def test_folders_named_by_pythonpath_do_not_hide_the_program(
    certificates: Path, tmp_path_factory: pytest.TempPathFactory
) -> None:
    elsewhere = tmp_path_factory.mktemp("elsewhere")
    done = run("-c", WHERE, folder=elsewhere, PYTHONPATH=str(certificates))
    assert done.stdout.splitlines() == OURS


def test_a_worker_of_a_notebook_imports_the_program(certificates: Path) -> None:
    program = (
        "import multiprocessing\n"
        "with multiprocessing.get_context('spawn').Pool(1) as pool:\n"
        f"    pool.apply(exec, ({WHERE!r},))\n"
    )
    assert run("-c", program, folder=certificates).stdout.splitlines() == OURS


@pytest.mark.parametrize("module", ["gsapp", "gsapp.cli"])
def test_modules_of_the_user_are_not_imported_by_a_command(hostile: Path, module: str) -> None:
    done = run("-m", module, "certificates", "b777", folder=hostile)
    assert (done.returncode, "a file of the user" in done.stdout) == (0, False), done.stdout


def test_modules_of_the_user_are_not_imported_by_processes_of_a_command(hostile: Path) -> None:
    program = (
        "import contextlib, multiprocessing, subprocess, sys; from gsapp.cli import main\n"
        "sys.argv = ['gsapp', '--version']\n"
        "with contextlib.suppress(SystemExit): main()\n"
        f"subprocess.run([sys.executable, '-c', {WHERE!r}])\n"
        f"with multiprocessing.get_context('spawn').Pool(1) as pool: pool.apply(exec, ({WHERE!r},))"
    )
    done = run("-c", program, folder=hostile)
    assert done.stdout.splitlines()[1:] == [*OURS, *OURS]


def test_the_bootstrap_runs_the_program_in_a_folder_with_modules_of_the_user(hostile: Path) -> None:
    program = (
        f"import sys; sys.path.insert(0, {str(ROOT / 'packaging')!r})\n"
        "from pathlib import Path; import bootstrap\n"
        "bootstrap.venv_python = lambda: Path(sys.executable)\n"
        "bootstrap.set_up = lambda *_: None\n"
        "sys.argv[1:] = ['run', 'certificates', 'b777']; sys.exit(bootstrap.main())\n"
    )
    done = run("-c", program, folder=hostile, PYTHONPATH=str(hostile))
    assert (done.returncode, "a file of the user" in done.stdout) == (0, False), done.stdout
