"""The commands, and the start and end of the program.

Commands are declared apart from what they do: each imports that when it runs, so that ``--help`` is
quick.
"""

from __future__ import annotations

import contextlib
import os
import sys
from io import TextIOWrapper
from pathlib import Path
from typing import Annotated

import typer

from gsapp.cli._commands import CommandApp
from gsapp.cli._options import DISPLAY_UNITS
from gsapp.cli.calibration_commands import calibrate, certificates
from gsapp.cli.catalog import catalog
from gsapp.cli.compatibility import compatibility
from gsapp.cli.debrief import debrief
from gsapp.cli.demo import demo
from gsapp.cli.discrepancy import discrepancy
from gsapp.cli.estimate import estimate
from gsapp.cli.flight_files import export, import_, onboard
from gsapp.cli.fly import fly
from gsapp.cli.inertia import inertia
from gsapp.cli.linear_models import linear_models
from gsapp.cli.maneuvers import maneuvers
from gsapp.cli.record import record
from gsapp.cli.replay import replay
from gsapp.cli.report import report
from gsapp.cli.runs import runs
from gsapp.cli.table_commands import cut, merge, resample
from gsapp.cli.terms import terms

app = CommandApp(
    pretty_exceptions_enable=False,
    # Plain help is twice as quick as the colored one.
    rich_markup_mode=None,
    context_settings={
        "help_option_names": ["-h", "--help"],
        "max_content_width": sys.maxsize,  # the terminal's
    },
    help="Ground station for flight-testing remotely piloted research aircraft. "
    "Without a command it opens the window.",
)

_ORDER = (
    demo,
    fly,
    record,
    replay,
    import_,
    onboard,
    export,
    maneuvers,
    debrief,
    estimate,
    report,
    compatibility,
    terms,
    catalog,
    runs,
    linear_models,
    discrepancy,
    cut,
    merge,
    resample,
    calibrate,
    certificates,
    inertia,
)
"""As the help lists them: from flight to report, then files, then the ground."""
for _command in _ORDER:
    # A name that is a word of the language ends in an underscore.
    app.command(_command.__name__.rstrip("_").replace("_", "-"))(_command)


def _show_version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        typer.echo(version("gsapp-ground-station"))
        raise typer.Exit


@app.callback(invoke_without_command=True)
def window(
    context: typer.Context,
    version: Annotated[  # noqa: ARG001  acts in its callback
        bool,
        typer.Option(
            "--version", "-V", callback=_show_version, is_eager=True, help="Show the version"
        ),
    ] = False,
) -> None:
    """Open the ground station window when no command is given."""
    if context.invoked_subcommand is None:
        from ui.app import run_window

        raise typer.Exit(run_window())


_LONGEST_NAME = 200


def run_program() -> None:
    """Run `main` as the whole process, and end it, once a window has closed, past its threads."""
    try:
        main()
    except SystemExit as ending:
        if isinstance(ending.code, int) and "ui.app" in sys.modules:
            from gsapp.foundation.process_control import exit_process

            exit_process(ending.code)
        raise


def main() -> None:
    """Run the command line; exit code 0 = done, 1 = failed with a message, 2 = wrong call."""
    _isolate_import_path()
    _set_output_encoding()
    try:
        app(prog_name="gsapp")  # also as `python -m gsapp`
    except KeyboardInterrupt:
        sys.exit(130)
    except Exception as error:
        sentence = _error_message(error)
        if sentence is None:
            raise
        from gsapp.cli._usage_errors import CommandUsageError
        from gsapp.quantities import convert_text_units

        sentence = convert_text_units(sentence, DISPLAY_UNITS.get())
        _discard_stdout()
        if isinstance(error, CommandUsageError):
            sys.stderr.write(f"gsapp: {sentence}\n")
            sys.exit(2)
        sys.exit(f"gsapp: {sentence}")


def _isolate_import_path() -> None:
    """Keep the user's folders, such as `calibration`, from hiding a package of the program.

    ``python -m`` searches the current folder first, and so would child processes.
    """
    os.environ["PYTHONSAFEPATH"] = "1"
    with contextlib.suppress(FileNotFoundError):  # the current folder was removed
        here = Path.cwd()
        if here not in Path(__file__).parents and sys.path[0] in {"", str(here)}:
            del sys.path[0]


def _set_output_encoding() -> None:
    """Let no character end the program: Windows hands over pipes and files in its old code pages.

    What goes there is UTF-8, as every file of this program; a terminal shows what it can.
    """
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            encoding = None if stream.isatty() else "utf-8"
            stream.reconfigure(encoding=encoding, errors="replace")


def _discard_stdout() -> None:
    """Let a full disk be told once: Python 3.13 would print again as it ends, and exit with 120."""
    if not isinstance(sys.stdout, TextIOWrapper):
        return
    try:
        sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _error_message(error: Exception) -> str | None:
    """Return what to tell the user; None for an error that nobody foresaw."""
    from gsapp.foundation import GroundStationError  # not needed for --help

    if isinstance(error, GroundStationError):
        return str(error)
    if isinstance(error, UnicodeEncodeError) and error.reason == "surrogates not allowed":
        return "a file or folder name in this call is not UTF-8; rename it"
    if isinstance(error, OSError):
        from gsapp.foundation.errors import os_error_remedy

        text = error.strerror or str(error)
        if error.filename is None:
            # A name is missing where what was printed could not be written.
            return f"{text}; {os_error_remedy(error)}" if error.errno else text
        name = str(error.filename)
        shown = name if len(name) <= _LONGEST_NAME else f"{name[:40]}...{name[-40:]}"
        return f"{shown}: {text}; {os_error_remedy(error)}"
    return None
