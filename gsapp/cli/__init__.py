"""The command line, and the composition root."""

from gsapp.cli.main import main

__all__ = ["main"]
