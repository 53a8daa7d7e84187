"""The commands. Each imports what it needs when it runs, so that ``--help`` is quick."""

from __future__ import annotations

import sys


def main() -> None:
    """Run the command line; exit code 0 = done, 1 = failed with a message, 2 = wrong call."""
    sys.exit("nothing here yet")
