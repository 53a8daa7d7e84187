"""The errors that the program raises on purpose.

Each is also the builtin that it most resembles, so that a caller may catch either. The text of
an error is one sentence for the person at the screen: what, where, and what to do.
"""

from __future__ import annotations

import errno
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final


class GroundStationError(Exception):
    """Base of every error that is meant for the user to read."""

    def __str__(self) -> str:
        return str(self.args[0]) if self.args else ""


class UnitError(GroundStationError, ValueError):
    """A unit is unknown, or cannot express the quantity at hand."""


class UnknownNameError(GroundStationError, KeyError):
    """A channel, file, source or effect of that name does not exist."""


class LinkError(GroundStationError, OSError):
    """A link cannot be opened, or was lost."""


class FlightError(GroundStationError, ValueError):
    """A flight cannot be read, or lacks what was asked of it."""


class UnmappedError(FlightError):
    """A flight needs a channel map, or another one: naming it is the remedy."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FileProblem:
    """One mistake in a file."""

    where: str  # Key path (``mass.ixx``), or ``line 12`` where it is a matter of syntax.
    what: str  # What is wrong, in words.
    remedy: str = ""  # What to write instead; empty where nothing can be proposed.
    line: int | None = None  # Of the file, from 1, where `where` names none.

    @classmethod
    def from_error(cls, where: str, error: Exception) -> FileProblem:
        """Return the problem that an error tells of: its sentence is ``what; remedy``."""
        what, _, remedy = str(error).partition("; ")
        return cls(where=where, what=what, remedy=remedy)

    def __str__(self) -> str:
        line = f"line {self.line}, " if self.line else ""
        tail = f"; {self.remedy}" if self.remedy else ""
        return f"{line}{self.where}: {self.what}{tail}"


class FileProblemsError(GroundStationError, ValueError):
    """A file holds one or more mistakes, all of them named, in the order of the file."""

    def __init__(self, path: Path | str, problems: Sequence[FileProblem]) -> None:
        self.path = Path(path)
        self.problems = tuple(problems)
        count = "1 problem" if len(problems) == 1 else f"{len(problems)} problems"
        lines = "\n".join(f"  {problem}" for problem in problems)
        super().__init__(f"{path}: {count}\n{lines}")

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.path, self.problems)


DISK_FULL_ERRNOS: Final = frozenset({errno.ENOSPC, getattr(errno, "EDQUOT", errno.ENOSPC)})
"""What a system says where the disk is full, or the share of it that a user may have."""

_REMEDIES = {
    **dict.fromkeys(DISK_FULL_ERRNOS, "free disk space"),
    errno.EFBIG: "choose a disk that allows files of that size",
    errno.EROFS: "choose a folder with write permission",
    errno.ENAMETOOLONG: "choose a shorter name",
    errno.ENOENT: "check the path",
    errno.ENOTDIR: "check the path: part of it is a file",
    errno.EISDIR: "name a file, not a folder",
}


def os_error_remedy(error: OSError, otherwise: str = "check the path and the permissions") -> str:
    """Return what to do about an error of the system: the end of a sentence, without a period.

    `otherwise` is what to do where the error does not tell, as where the permissions are missing.
    """
    return _REMEDIES.get(error.errno or 0, otherwise)


def format_os_error(what: object, error: OSError, otherwise: str, *, verb: str = "written") -> str:
    """Return the sentence for a file or folder that could not be written.

    `what` is a path, or words that end in one, and `verb` what could not be done with it;
    `otherwise` as for `os_error_remedy`.
    """
    text = error.strerror or str(error)
    return f"{what} cannot be {verb} ({text}); {os_error_remedy(error, otherwise)}"
