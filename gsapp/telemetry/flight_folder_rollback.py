"""A recording that cannot begin leaves nothing behind."""

from __future__ import annotations

import contextlib
import shutil
from collections.abc import Iterator
from pathlib import Path

from gsapp.flight.file_names import LOCK_FILE
from gsapp.flight.folder import FlightFolder
from gsapp.foundation import GroundStationError
from gsapp.foundation.file_lock import lock_holder


@contextlib.contextmanager
def rollback_on_failure(path: Path | str) -> Iterator[None]:
    """Take away what was made inside if the flight cannot begin.

    What stood there before stays, and so does a folder into which anything was recorded, or
    another recorder records.

    Parameters
    ----------
    path : Path or str
        The flight folder that is made inside the context.
    """
    folder = Path(path).absolute()
    made = [each for each in (folder, *folder.parents) if not each.exists()]
    try:
        yield
    except GroundStationError:
        if made and folder.is_dir() and not _in_use(folder):
            shutil.rmtree(folder, ignore_errors=True)
        for each in made:
            with contextlib.suppress(OSError):  # others may have put something there
                each.rmdir()
        raise


def _in_use(folder: Path) -> bool:
    return bool(FlightFolder(path=folder).raw_files) or lock_holder(folder / LOCK_FILE) is not None
