"""The command line, and the composition root."""

from gsapp.cli.main import main, run_program

__all__ = ["main", "run_program"]
