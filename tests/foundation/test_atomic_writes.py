"""A file is replaced whole or not at all."""

import os
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from gsapp.decoding.framing import TextLine
from gsapp.flight.events import Event, EventLog
from gsapp.flight.raw_files import RawWriter
from gsapp.foundation import GroundStationError, files, write_atomically
from gsapp.foundation.files import atomic_folder, create_sibling_folder, list_files, move_into_place


def test_a_failed_write_leaves_the_former_file_and_no_litter(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write_atomically(tmp_path / "a" / "file.txt", "before")

    def refuse(_: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(files, "flush_to_disk", refuse)
    with pytest.raises(OSError, match="No space left"):
        write_atomically(path, "after")
    assert path.read_text() == "before"
    assert [entry.name for entry in path.parent.iterdir()] == ["file.txt"]


def test_an_error_names_the_file_and_not_its_temporary_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(_path: Path, _content: bytes) -> int:
        raise OSError(28, "No space left on device")

    def closed(path: Path, *_: int) -> int:
        raise PermissionError(13, "Permission denied", str(path))

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(OSError, match="No space") as caught:
        write_atomically(tmp_path / "file.txt", "text")
    assert caught.value.filename == str(tmp_path / "file.txt")
    monkeypatch.setattr(os, "open", closed)
    with pytest.raises(PermissionError) as caught:
        write_atomically(tmp_path / "file.txt", "text")
    assert caught.value.filename == str(tmp_path / "file.txt")


@pytest.mark.skipif(sys.platform == "win32", reason="rights of POSIX")
@pytest.mark.parametrize(("mask", "rights"), [(0o022, 0o644), (0o077, 0o600), (0o002, 0o664)])
def test_a_new_file_has_the_rights_that_the_user_gives_to_new_files(
    tmp_path: Path, mask: int, rights: int
) -> None:
    former = os.umask(mask)
    try:
        path = write_atomically(tmp_path / "file.txt", "text")
    finally:
        os.umask(former)
    assert path.stat().st_mode & 0o777 == rights
    path.chmod(0o640)
    write_atomically(path, "again")
    assert path.stat().st_mode & 0o777 == 0o640  # what was set by hand stays


@pytest.mark.skipif(sys.platform == "win32", reason="links need rights of their own")
def test_what_a_link_leads_to_is_replaced_and_the_link_stays(tmp_path: Path) -> None:
    card = write_atomically(tmp_path / "shared" / "card.toml", "before")
    link = tmp_path / "card.toml"
    link.symlink_to(card)
    write_atomically(link, "after")
    assert link.is_symlink()
    assert card.read_text() == "after"
    assert [entry.name for entry in tmp_path.iterdir() if entry.name.startswith(".")] == []


@pytest.mark.skipif(sys.platform == "win32", reason="pipes with names")
def test_a_pipe_takes_what_is_written_and_stays_a_pipe(tmp_path: Path) -> None:
    """As ``--json /dev/stdout`` and ``--json >(program)`` want it; a file took its place."""
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    taken: list[str] = []
    reader = threading.Thread(target=lambda: taken.append(pipe.read_text()), daemon=True)
    reader.start()
    write_atomically(pipe, "all of it")
    reader.join(5.0)
    assert taken == ["all of it"]
    assert pipe.is_fifo()
    assert [entry.name for entry in tmp_path.iterdir()] == ["pipe"]


def test_text_is_utf8_with_line_feeds_on_every_system(tmp_path: Path) -> None:
    path = write_atomically(tmp_path / "file.txt", "α\nβ\n")
    assert path.read_bytes() == "α\nβ\n".encode()


def test_a_file_that_others_read_is_replaced_when_they_are_done(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write_atomically(tmp_path / "file.txt", "before")
    replace, refusals = Path.replace, [PermissionError(13, "in use")] * 3

    def replace_unless_open(self: Path, target: Path) -> Path:
        if refusals:
            raise refusals.pop()
        return replace(self, target)

    monkeypatch.setattr(Path, "replace", replace_unless_open)
    monkeypatch.setattr(sys, "platform", "linux")
    with pytest.raises(PermissionError):
        write_atomically(path, "after")  # elsewhere it is a refusal
    monkeypatch.setattr(sys, "platform", "win32")
    write_atomically(path, "after")
    assert path.read_text() == "after"
    assert not refusals


@pytest.mark.skipif(sys.platform != "win32", reason="elsewhere an open file can be replaced")
def test_a_file_open_in_another_thread_is_replaced_when_it_is_closed(tmp_path: Path) -> None:
    path = write_atomically(tmp_path / "file.txt", "before")
    with path.open() as reader:
        closing = threading.Timer(0.2, reader.close)
        closing.start()
        write_atomically(path, "after")
        closing.join()
    assert path.read_text() == "after"


def test_a_folder_made_beside_its_place_is_open_like_any_other(tmp_path: Path) -> None:
    place = tmp_path / "flight"
    (tmp_path / "usual").mkdir()
    made = [create_sibling_folder(place) for _ in range(3)]
    assert len(set(made)) == 3
    assert {one.parent for one in made} == {tmp_path}
    assert {one.stat().st_mode for one in made} == {(tmp_path / "usual").stat().st_mode}
    (made[0] / "raw.tlog").write_bytes(b"x")
    move_into_place(made[0], place)
    assert (place / "raw.tlog").read_bytes() == b"x"
    with pytest.raises(FileNotFoundError):
        create_sibling_folder(tmp_path / "missing" / "flight")


def fill(place: Path, content: bytes, *, whole: bool = True) -> None:
    with atomic_folder(place) as made:
        (made / "raw.tlog").write_bytes(content)
        if not whole:
            raise RuntimeError("half of it")


def test_a_folder_appears_whole_or_not_at_all(tmp_path: Path) -> None:
    place = tmp_path / "flights" / "one"
    with pytest.raises(RuntimeError, match="half of it"):
        fill(place, b"half", whole=False)
    assert list(place.parent.iterdir()) == []

    place.mkdir()  # empty, as a dialog may have made it
    fill(place, b"whole")
    assert (place / "raw.tlog").read_bytes() == b"whole"

    with pytest.raises(OSError, match=r"(?i)not empty"):
        fill(place, b"other")
    assert (place / "raw.tlog").read_bytes() == b"whole"
    assert [one.name for one in place.parent.iterdir()] == ["one"]


def test_what_a_system_lays_into_a_folder_is_not_ours(tmp_path: Path) -> None:
    place = tmp_path / "one"
    place.mkdir()
    (place / ".DS_Store").touch()
    (place / "Thumbs.db").touch()
    fill(place, b"whole")
    assert [one.name for one in place.iterdir()] == ["raw.tlog"]
    (place / "._raw.tlog").write_bytes(b"\x00\x05\x16\x07")
    (place / "alpha.toml").touch()
    (place / "._alpha.toml").write_bytes(b"\x00\x05\x16\x07")
    assert [one.name for one in list_files(place)] == ["alpha.toml", "raw.tlog"]
    assert [one.name for one in list_files(place, "*.toml")] == ["alpha.toml"]
    assert list_files(tmp_path / "missing") == ()

    mine = tmp_path / "mine"
    mine.mkdir()
    (mine / ".notes").write_text("dear to somebody")
    with pytest.raises(OSError, match=r"(?i)not empty"):
        fill(mine, b"other")
    assert (mine / ".notes").read_text() == "dear to somebody"


class Mac:
    def __init__(self, fault: OSError | None = None) -> None:
        self.fault = fault
        self.calls: list[object] = []

    def fcntl(self, _descriptor: int, command: int) -> int:
        self.calls.append(command)
        if self.fault is not None:
            raise self.fault
        return 0

    def fsync(self, _descriptor: int) -> None:
        self.calls.append("fsync")


@pytest.fixture
def mac(monkeypatch: pytest.MonkeyPatch) -> Mac:
    if sys.platform == "win32":
        pytest.skip("Windows knows one flush only")
    made = Mac()
    monkeypatch.setattr(files, "_FULL_FSYNC", 51)
    monkeypatch.setattr(files, "fcntl", made, raising=False)
    monkeypatch.setattr(os, "fsync", made.fsync)
    return made


def test_a_file_is_flushed_out_of_the_drive_too_where_that_can_be_asked_for(
    mac: Mac, tmp_path: Path
) -> None:
    write_atomically(tmp_path / "file.txt", "kept")
    EventLog(tmp_path / "events.jsonl").append(Event(kind="mark"))
    writer = RawWriter(tmp_path / "flight")
    writer.append(1_000_000, [TextLine(0, b"1,2", 4)])
    writer.sync()  # once a second, and quick
    assert mac.calls == [51, 51, "fsync"]
    writer.append(1_000_001, [TextLine(4, b"3,4", 8)])
    writer.close()
    assert mac.calls == [51, 51, "fsync", 51]


def test_a_file_system_that_knows_no_such_flush_gets_the_usual_one(
    mac: Mac, tmp_path: Path
) -> None:
    mac.fault = OSError(45, "Operation not supported")
    write_atomically(tmp_path / "file.txt", "kept")
    assert mac.calls == [51, "fsync"]


def test_a_folder_that_cannot_be_read_is_not_an_empty_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "kept").mkdir()

    def refuse(path: Path) -> Iterator[Path]:
        raise PermissionError(13, "Permission denied", str(path))

    monkeypatch.setattr(Path, "iterdir", refuse)
    with pytest.raises(GroundStationError, match="check its perm"):
        list_files(tmp_path / "kept", "*.toml")
    assert list_files(tmp_path / "missing") == ()


@pytest.mark.skipif(sys.platform == "win32", reason="links need rights of their own")
def test_a_link_to_nothing_is_not_an_empty_folder(tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to(tmp_path / "gone")
    with pytest.raises(GroundStationError, match="link to a folder"):
        list_files(tmp_path / "link")
