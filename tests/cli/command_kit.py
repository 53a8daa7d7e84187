"""The command line as tests call it: here, or as a process where the test is about that."""

import io
import os
import sys
from contextlib import chdir, redirect_stderr, redirect_stdout
from contextvars import copy_context
from dataclasses import dataclass
from pathlib import Path
from unittest.mock import patch

from gsapp.cli.main import main


@dataclass(frozen=True)
class Done:
    returncode: int
    stdout: str
    stderr: str


def gsapp(*arguments: object, folder: Path | None = None) -> Done:
    code, out, err = 0, io.StringIO(), io.StringIO()
    typed = patch.object(sys, "argv", ["gsapp", *map(str, arguments)])
    with redirect_stdout(out), redirect_stderr(err), typed, chdir(folder or Path.cwd()):
        try:
            copy_context().run(main)  # a call chooses units for itself alone
        except SystemExit as end:
            if isinstance(end.code, str):
                err.write(end.code)
            code = 1 if isinstance(end.code, str) else int(end.code or 0)
    return Done(returncode=code, stdout=out.getvalue(), stderr=err.getvalue())


def busy_worker(parent: int) -> int | None:
    """Return a child of a process that has computed for a second."""
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            state = (folder / "stat").read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if int(state[1]) == parent and int(state[11]) > os.sysconf("SC_CLK_TCK"):
            return int(folder.name)
    return None
