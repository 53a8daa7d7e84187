"""What to do about it when a system refuses to read or write."""

from __future__ import annotations

import errno
from typing import Final

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
    """Return what to do about an error of the system.

    Parameters
    ----------
    otherwise : str
        What to do where the error does not tell, as where the permissions are missing.

    Returns
    -------
    str
        The end of a sentence, without a period.
    """
    return _REMEDIES.get(error.errno or 0, otherwise)


def format_os_error(what: object, error: OSError, otherwise: str, *, verb: str = "written") -> str:
    """Return the sentence for a file or folder that could not be written.

    Parameters
    ----------
    what : object
        Path, or words that end in one.
    otherwise : str
        As for `os_error_remedy`.
    verb : str
        What could not be done with it.
    """
    said = error.strerror or str(error)
    return f"{what} cannot be {verb} ({said}); {os_error_remedy(error, otherwise)}"
