"""A disk that can be stopped and goes on later: a folder mounted by a process of its own.

``python fuse_disk.py FOLDER MOUNT`` serves what lies in FOLDER at MOUNT, by the protocol of
``linux/fuse.h``. Nothing is cached, as on a network drive: all who ask wait for the process.
"""

# The protocol speaks of descriptors and names in bytes, and has as many requests as it has.
# ruff: noqa: PTH102, PTH104, PTH208, C901

import contextlib
import ctypes
import errno
import os
import signal
import stat
import struct
import subprocess
import sys
import time
from pathlib import Path

_ATTRIBUTES = struct.Struct("<6Q10I")
_HEADER = struct.Struct("<IIQQIIII")
_DIRECT = 1  # reads and writes go to the server each time


class FuseDisk:
    """The mounted folder, and its process."""

    def __init__(self, parent: Path) -> None:
        self.place, backing = parent / "mounted", parent / "backing"
        for folder in (self.place, backing):
            folder.mkdir(parents=True)
        self._server = subprocess.Popen([sys.executable, __file__, str(backing), str(self.place)])
        deadline = time.monotonic() + 5.0
        while not os.path.ismount(self.place):
            if self._server.poll() is not None or time.monotonic() > deadline:
                self.end()
                raise PermissionError(errno.EPERM, "a file system cannot be mounted here")
            time.sleep(0.02)

    def stop(self) -> None:
        self._server.send_signal(signal.SIGSTOP)

    def go_on(self) -> None:
        self._server.send_signal(signal.SIGCONT)

    def end(self) -> None:
        self._server.kill()
        self._server.wait()
        ctypes.CDLL(None).umount2(bytes(self.place), 2)


class _Server:
    def __init__(self, backing: str, mount: str) -> None:
        self._channel = os.open("/dev/fuse", os.O_RDWR)
        options = f"fd={self._channel},rootmode=40755,user_id=0,group_id=0,allow_other"
        libc = ctypes.CDLL(None, use_errno=True)
        if libc.mount(b"slow", mount.encode(), b"fuse", 0, options.encode()):
            raise OSError(ctypes.get_errno(), "mount")
        self._paths = {1: backing}
        self._nodes = {backing: 1}

    def serve(self) -> None:
        while True:
            try:
                request = os.read(self._channel, 1 << 18)
            except OSError as error:
                if error.errno == errno.ENODEV:
                    return
                continue
            _, code, unique, node, *_ = _HEADER.unpack_from(request)
            if code in (2, 36, 42):  # forget, interrupt
                continue
            try:
                answer, failure = self._answer(code, node, request[_HEADER.size :]), 0
            except (OSError, KeyError) as error:
                answer, failure = b"", getattr(error, "errno", None) or errno.ENOENT
            with contextlib.suppress(OSError):
                head = struct.pack("<IiQ", 16 + len(answer), -failure, unique)
                os.write(self._channel, head + answer)

    def _answer(self, code: int, node: int, data: bytes) -> bytes:
        path = self._paths.get(node, "")
        match code:
            case 26:  # init
                return struct.pack(
                    "<IIIIHHIIHHI7I", 7, 31, 0, 0, 8, 6, 1 << 17, 1, 32, 0, 0, *[0] * 7
                )
            case 1:  # lookup
                return self._entry(f"{path}/{_name(data)}")
            case 3:  # getattr
                return struct.pack("<QII", 0, 0, 0) + _attributes(path)
            case 4:  # setattr
                valid, size = (
                    struct.unpack_from("<I", data)[0],
                    struct.unpack_from("<Q", data, 16)[0],
                )
                if valid & 8:
                    os.truncate(path, size)
                return struct.pack("<QII", 0, 0, 0) + _attributes(path)
            case 9:  # mkdir
                made = f"{path}/{_name(data[8:])}"
                os.mkdir(made)
                return self._entry(made)
            case 10 | 11:  # unlink, rmdir
                (os.unlink if code == 10 else os.rmdir)(f"{path}/{_name(data)}")
                return b""
            case 12 | 45:  # rename
                old, new = data[8 if code == 12 else 16 :].split(b"\0")[:2]
                target = f"{self._paths[struct.unpack_from('<Q', data)[0]]}/{os.fsdecode(new)}"
                os.rename(f"{path}/{os.fsdecode(old)}", target)
                self._move(f"{path}/{os.fsdecode(old)}", target)
                return b""
            case 14:  # open
                flags = struct.unpack_from("<I", data)[0] & ~(os.O_APPEND | os.O_CREAT | os.O_EXCL)
                return struct.pack("<QII", os.open(path, flags), _DIRECT, 0)
            case 35:  # create
                flags, mode = struct.unpack_from("<II", data)
                made = f"{path}/{_name(data[16:])}"
                opened = os.open(made, (flags & ~os.O_APPEND) | os.O_CREAT, mode & 0o7777)
                return self._entry(made) + struct.pack("<QII", opened, _DIRECT, 0)
            case 15:  # read
                handle, offset, size = struct.unpack_from("<QQI", data)
                return os.pread(handle, size, offset)
            case 16:  # write
                handle, offset, size = struct.unpack_from("<QQI", data)
                return struct.pack("<II", os.pwrite(handle, data[40 : 40 + size], offset), 0)
            case 17:  # statfs
                found = os.statvfs(path)
                return struct.pack(
                    "<5Q4I6I", found.f_blocks, found.f_bfree, found.f_bavail, found.f_files,
                    found.f_ffree, found.f_bsize, 255, found.f_frsize, 0, *[0] * 6,
                )  # fmt: skip
            case 18:  # release
                os.close(struct.unpack_from("<Q", data)[0])
                return b""
            case 27:  # opendir
                return struct.pack("<QII", 0, 0, 0)
            case 28:  # readdir
                offset, size = struct.unpack_from("<QI", data, 8)
                return _listed(path, offset, size)
            case 20 | 25 | 29 | 30:  # fsync, flush, releasedir, fsyncdir
                return b""
        raise OSError(errno.ENOSYS, "not served")

    def _entry(self, path: str) -> bytes:
        attributes = _attributes(path)
        node = self._nodes.setdefault(path, len(self._nodes) + 2)
        self._paths[node] = path
        return struct.pack("<QQQQII", node, 0, 0, 0, 0, 0) + attributes

    def _move(self, old: str, new: str) -> None:
        self._nodes.pop(new, None)
        for path, node in list(self._nodes.items()):
            if path == old or path.startswith(f"{old}/"):
                del self._nodes[path]
                moved = new + path[len(old) :]
                self._nodes[moved] = node
                self._paths[node] = moved


def _name(data: bytes) -> str:
    return os.fsdecode(data.split(b"\0")[0])


def _attributes(path: str) -> bytes:
    found = os.lstat(path)
    times = (found.st_atime_ns, found.st_mtime_ns, found.st_ctime_ns)
    return _ATTRIBUTES.pack(
        found.st_ino, found.st_size, found.st_blocks, *(time // 10**9 for time in times),
        *(time % 10**9 for time in times), found.st_mode, found.st_nlink, found.st_uid,
        found.st_gid, 0, found.st_blksize, 0,
    )  # fmt: skip


def _listed(path: str, offset: int, size: int) -> bytes:
    listed = b""
    for number, name in enumerate([".", "..", *sorted(os.listdir(path))][offset:], offset + 1):
        raw = os.fsencode(name)
        kind = stat.S_IFMT(os.lstat(f"{path}/{name}").st_mode) >> 12
        entry = struct.pack("<QQII", number, number, len(raw), kind) + raw
        entry += b"\0" * (-len(entry) % 8)
        if len(listed) + len(entry) > size:
            break
        listed += entry
    return listed


if __name__ == "__main__":
    _Server(*sys.argv[1:]).serve()
