"""Writing files so that a reader never meets half of one."""

from __future__ import annotations

import contextlib
import os
import tempfile
from pathlib import Path


def write_atomically(path: Path | str, content: bytes | str) -> Path:
    """Write a whole file under a temporary name, flush it to disk, and rename it into place.

    Parameters
    ----------
    path : Path or str
        Where the file shall stand. Missing parent folders are made.
    content : bytes or str
        The whole content; text is written as UTF-8 with line feeds.

    Returns
    -------
    Path
        The path written.

    Raises
    ------
    OSError
        If the disk refuses. The former file then still stands, unchanged.
    """
    target = Path(path)
    data = content.encode("utf-8") if isinstance(content, str) else content
    target.parent.mkdir(parents=True, exist_ok=True)
    handle, temporary = tempfile.mkstemp(prefix=f".{target.name}.", dir=target.parent)
    try:
        with os.fdopen(handle, "wb") as stream:
            stream.write(data)
            stream.flush()
            os.fsync(stream.fileno())
        # A temporary file is private to its maker; a document is not.
        Path(temporary).chmod(target.stat().st_mode & 0o777 if target.exists() else 0o644)
        Path(temporary).replace(target)
    except BaseException:
        with contextlib.suppress(OSError):
            Path(temporary).unlink()
        raise
    return target
