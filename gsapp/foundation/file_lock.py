"""Locks on files, which end with the process that holds them, however that ends."""

from __future__ import annotations

import contextlib
import errno
import os
import stat
import sys
import time
from collections.abc import Iterator
from pathlib import Path

from gsapp.foundation.errors import FlightError
from gsapp.foundation.files import GROUP_FILE_MODE

if sys.platform == "win32":
    import msvcrt
else:
    import fcntl

_HELD = frozenset({errno.EWOULDBLOCK, errno.EAGAIN, errno.EACCES, errno.EDEADLK})
_FAR = 1 << 30
"""Where Windows locks: far behind the end, since it would forbid reading what is locked."""
_PROBE_COUNT = 4
"""Looks in a row that must meet a lock on Windows: others who look hold it for an instant too."""
_PAUSE = 0.003
"""Seconds between two tries to get a lock that somebody holds for an instant."""
_PATIENCE = 10.0
"""Seconds for which a file that another process writes is waited for."""


def _close_to_readers(descriptor: int) -> None:
    """Let only those open a lock file who may write it: opening it is enough to hold the lock."""
    if sys.platform == "win32":
        return
    mode = stat.S_IMODE(os.fstat(descriptor).st_mode)
    writers = mode & 0o222
    if mode & 0o444 != writers << 1:
        # That of another user is used as it is: only its owner can change its rights.
        with contextlib.suppress(PermissionError):
            os.fchmod(descriptor, writers | writers << 1)


class FileLock:
    """Hold a lock on a file; the file tells the process id of the holder.

    Users who may only read there can neither hold the lock nor look at it.

    It stays when the lock is released: removing it would let two in.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._descriptor = -1

    def acquire(self, patience: float = 1.0) -> bool:
        """Take the lock; return False where another process holds it.

        It is tried for some seconds: somebody may be looking whether it is held. Raise OSError if
        the file cannot be written, FlightError if it lies where there are no locks.
        """
        descriptor = os.open(self.path, os.O_RDWR | os.O_CREAT, GROUP_FILE_MODE)
        try:
            _close_to_readers(descriptor)
            if self._wait(descriptor, time.monotonic() + patience):
                os.ftruncate(descriptor, 0)
                os.lseek(descriptor, 0, os.SEEK_SET)
                os.write(descriptor, str(os.getpid()).encode())
                self._descriptor = descriptor
        finally:
            # A descriptor left open would hold the lock for as long as this process lives.
            if self._descriptor != descriptor:
                os.close(descriptor)
        return self._descriptor == descriptor

    def _wait(self, descriptor: int, deadline: float) -> bool:
        while True:
            try:
                if _lock(descriptor, shared=False):
                    return True
            except OSError as error:
                raise FlightError(
                    f"{self.path} cannot be locked ({error.strerror or error}); some network "
                    "drives do not support locks: choose a local folder"
                ) from error
            if time.monotonic() >= deadline:
                return False
            time.sleep(0.02)

    def release(self) -> None:
        if self._descriptor >= 0:
            _unlock(self._descriptor)
            os.close(self._descriptor)
            self._descriptor = -1


def lock_holder(path: Path) -> int | None:
    """Return the process id of who holds a lock file; None where nobody does.

    A process id alone proves nothing: after a crash the system gives it to another process.
    """
    try:
        descriptor = os.open(path, os.O_RDWR)
    except OSError:
        return None
    try:
        if _is_unlocked(descriptor):
            return None
        os.lseek(descriptor, 0, os.SEEK_SET)
        text = os.read(descriptor, 32)
        return int(text) if text.isdigit() else None
    except OSError:
        return None  # a disk that fails; or one without locks, so that nobody holds one
    finally:
        os.close(descriptor)


def _refuse_unless_held(error: OSError) -> None:
    if error.errno not in _HELD:
        raise error


if sys.platform == "win32":

    def _lock(descriptor: int, *, shared: bool) -> bool:  # noqa: ARG001 - none there
        os.lseek(descriptor, _FAR, os.SEEK_SET)
        try:
            msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
        except OSError as error:
            _refuse_unless_held(error)
            return False
        return True

    def _unlock(descriptor: int) -> None:
        # Closing does it as well, but later, when the system finds time.
        os.lseek(descriptor, _FAR, os.SEEK_SET)
        msvcrt.locking(descriptor, msvcrt.LK_UNLCK, 1)

    def _is_unlocked(descriptor: int) -> bool:
        for look in range(_PROBE_COUNT):
            if look:
                time.sleep(_PAUSE)
            if _lock(descriptor, shared=True):
                _unlock(descriptor)
                return True
        return False

    @contextlib.contextmanager
    def exclusive_lock(descriptor: int) -> Iterator[None]:
        """Hold an open file alone among the processes that ask for it, waiting for it."""
        deadline = time.monotonic() + _PATIENCE
        # The system's own waiting looks once a second.
        while not _lock(descriptor, shared=False):
            if time.monotonic() >= deadline:
                raise OSError(errno.EDEADLK, "locked by another process")
            time.sleep(_PAUSE)
        try:
            yield
        finally:
            _unlock(descriptor)

else:

    def _lock(descriptor: int, *, shared: bool) -> bool:
        try:
            fcntl.flock(descriptor, (fcntl.LOCK_SH if shared else fcntl.LOCK_EX) | fcntl.LOCK_NB)
        except OSError as error:
            _refuse_unless_held(error)
            return False
        return True

    def _unlock(descriptor: int) -> None:
        fcntl.flock(descriptor, fcntl.LOCK_UN)

    def _is_unlocked(descriptor: int) -> bool:
        return _lock(descriptor, shared=True)

    @contextlib.contextmanager
    def exclusive_lock(descriptor: int) -> Iterator[None]:
        """Hold an open file alone among the processes that ask for it, waiting for it.

        Those who may only read the file can hold the lock too, for as long as they like: after a
        while the file is written all the same.
        """
        deadline = time.monotonic() + _PATIENCE
        while not (held := _lock(descriptor, shared=False)) and time.monotonic() < deadline:
            time.sleep(_PAUSE)
        try:
            yield
        finally:
            if held:
                _unlock(descriptor)
