"""Raw files: whole records survive whatever happens to the end or the middle of a file."""

import errno
import os
import random
import shutil
import struct
import sys
import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gsapp.decoding.framing import Framer, LineFramer, Residue
from gsapp.decoding.sender_filter import FrameOrigin
from gsapp.flight.file_names import SENDERS_FILE
from gsapp.flight.raw_files import (
    FRAMES_FILE,
    LINES_FILE,
    RESIDUE_FILE,
    RawDamage,
    RawTail,
    RawWriter,
    raw_writer,
    read_nonempty_tlog,
    read_tlog,
)
from gsapp.flight.raw_files.record_files import RawRecord
from gsapp.foundation import FlightError

STAMP = 1_700_000_000_000_000


def stored(folder: Path, stream: bytes, framer, *, size: int = 100, poll=lambda: None) -> None:
    writer = RawWriter(folder)
    stamp = max(STAMP, writer.last_stamp)
    for start in range(0, len(stream), size):
        stamp += 1000
        writer.append(stamp, framer.feed(stream[start : start + size]))
        poll()
    writer.append(stamp + 1, framer.flush())
    writer.close()


def all_of(folder: Path) -> list[RawRecord]:
    return RawTail(folder).poll()


def noisy(frames: list[bytes], seed: int = 1) -> bytes:
    choose = random.Random(seed)
    return b"".join(
        frame + (choose.randbytes(choose.randrange(20)) if choose.random() < 0.2 else b"")
        for frame in frames
    )


def test_files_have_the_documented_form(tmp_path: Path, frames) -> None:
    frame = frames(1)[0]
    writer = RawWriter(tmp_path)
    writer.append(STAMP, Framer().feed(b"noise" + frame))
    writer.append(STAMP + 1, LineFramer().feed(b"1,2,3\r\n"))
    writer.close()
    assert (tmp_path / FRAMES_FILE).read_bytes() == struct.pack(">Q", STAMP) + frame
    assert (tmp_path / LINES_FILE).read_bytes() == f"{STAMP + 1}\t1,2,3\n".encode()
    head = struct.pack(">QQI", STAMP, 0, 5)
    assert (tmp_path / RESIDUE_FILE).read_bytes() == head + b"noise"


def test_pymavlink_reads_the_log(tmp_path: Path, frames) -> None:
    from pymavlink import mavutil

    sent = frames(300)
    stored(tmp_path, b"".join(sent), Framer())
    log = mavutil.mavlink_connection(str(tmp_path / FRAMES_FILE))
    read = []
    while (message := log.recv_msg()) is not None:
        read.append((bytes(message.get_msgbuf()), message._timestamp))
    log.close()
    assert [data for data, _ in read] == sent
    assert read[0][1] == pytest.approx((STAMP + 1000) / 1e6)


@given(
    st.lists(st.tuples(st.integers(1, 400), st.sampled_from([None, 1, 7, 1000])), max_size=30),
    st.integers(0, 1000),
)
@settings(max_examples=25, deadline=None)
def test_tails_read_the_same_whenever_they_look(looks, seed) -> None:
    from_test = noisy(_FRAMES, seed)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        tail, seen, writer, framer = RawTail(folder), [], RawWriter(folder), Framer()
        start, stamp = 0, STAMP
        for size, limit in looks:
            stamp += 1
            writer.append(stamp, framer.feed(from_test[start : start + size]))
            start += size
            seen += tail.poll(limit)
        writer.append(stamp + 1, framer.flush())
        writer.close()
        while more := tail.poll(50):
            seen += more
        assert seen == all_of(folder)
        assert tail.poll() == []
        stamps = [record.stamp_us for record in seen]
        assert stamps == sorted(stamps)
        fed = from_test[: sum(size for size, _ in looks)]
        assert sum(len(record.data) for record in seen) == len(fed)


_FRAMES: list[bytes] = []


@pytest.fixture(autouse=True)
def _some_frames(frames) -> None:
    if not _FRAMES:
        _FRAMES.extend(frames(60))


def test_a_tail_waits_for_files_and_for_the_rest_of_a_record(tmp_path: Path, frames) -> None:
    folder = tmp_path / "later"
    tail = RawTail(folder)
    assert tail.poll() == []
    record = struct.pack(">Q", STAMP) + frames(1)[0]
    folder.mkdir()
    with (folder / FRAMES_FILE).open("ab", buffering=0) as file:
        for count in range(len(record)):
            file.write(record[count : count + 1])
            assert len(tail.poll()) == (count == len(record) - 1)
    assert tail.position.frames == len(record)
    assert tail.damage == ()


@pytest.mark.parametrize("name", [FRAMES_FILE, LINES_FILE, RESIDUE_FILE])
def test_a_torn_end_costs_only_the_torn_record(tmp_path: Path, frames, name: str) -> None:
    """Wherever a file was torn, a reader gets all before it, and a writer goes on behind it."""
    text = name == LINES_FILE
    stream = b"1,2,3\n" * 20 if text else noisy(frames(20))
    stored(tmp_path, stream, LineFramer() if text else Framer())
    path = tmp_path / name
    whole, records = path.read_bytes(), all_of(tmp_path)
    kind = {FRAMES_FILE: "frame", LINES_FILE: "line", RESIDUE_FILE: "residue"}[name]
    mine = [record for record in records if record.kind == kind]
    beside = {"frame": 8, "line": len(f"{STAMP}\t\n"), "residue": 20}[kind]
    ends = np.cumsum([beside + len(record.data) for record in mine])
    assert ends[-1] == len(whole)
    for cut in range(1, 40):
        path.write_bytes(whole[:-cut])
        good = [record for record in all_of(tmp_path) if record.kind == kind]
        assert good == mine[: np.count_nonzero(ends <= len(whole) - cut)]
        writer = RawWriter(tmp_path)
        assert writer.last_stamp >= good[-1].stamp_us
        if text:
            writer.append(STAMP * 2, LineFramer().feed(b"9,9\n"))
        elif kind == "frame":
            writer.append(STAMP * 2, Framer().feed(frames(1)[0]))
        else:
            writer.append(STAMP * 2, [Residue(0, b"after")])
        writer.close()
        after = RawTail(tmp_path)
        again = [record for record in after.poll() if record.kind == kind]
        assert again[:-1] == good
        assert again[-1].stamp_us == STAMP * 2
        assert after.damage == ()


@pytest.mark.parametrize("name", [FRAMES_FILE, LINES_FILE, RESIDUE_FILE])
def test_a_long_file_goes_on_where_it_was_torn(tmp_path: Path, frames, name: str) -> None:
    some, text, count = frames(50), LineFramer(), 2000
    writer = RawWriter(tmp_path)
    for number in range(count):
        item = {
            FRAMES_FILE: lambda k: Framer().feed(some[k % 50]),
            LINES_FILE: lambda k: text.feed(b"%d,2,3,4,5,6,7,8,9\n" % k),
            RESIDUE_FILE: lambda k: [Residue(30 * k, bytes(30))],
        }[name](number)
        writer.append(STAMP + number, item)
    writer.close()
    path = tmp_path / name
    assert path.stat().st_size > 65536
    whole = all_of(tmp_path)
    os.truncate(path, path.stat().st_size - 5)
    writer = RawWriter(tmp_path)
    assert writer.last_stamp == STAMP + count - 2
    assert "was removed" in writer.state.notes[0]
    writer.append(STAMP + count - 1, item)
    writer.close()
    assert all_of(tmp_path) == whole


def test_a_frame_that_cannot_be_checked_waits_for_what_follows(tmp_path: Path, frames) -> None:
    unknown = bytes((0xFD, 3, 0, 0, 0, 1, 1, 0xF0, 0xFF, 0xFF, 1, 2, 3, 9, 9))
    first, second = (struct.pack(">Q", STAMP) + data for data in (unknown, frames(1)[0]))
    path = tmp_path / FRAMES_FILE
    for count in range(len(second) + 1):
        path.write_bytes(first + second[:count])
        assert len(all_of(tmp_path)) == (2 if count == len(second) else count not in range(1, 9))
        RawWriter(tmp_path).close()
        assert path.read_bytes() == first + (second if count == len(second) else b"")


def damaged(data: bytes, choose: random.Random) -> bytes:
    out = bytearray(data)
    for _ in range(choose.randrange(1, 4)):
        place, count = choose.randrange(len(out)), choose.randrange(1, 20)
        match choose.randrange(3):
            case 0:
                out[place] ^= 1 << choose.randrange(8)
            case 1:
                del out[place : place + count]
            case _:
                out[place:place] = choose.randbytes(count)
    return bytes(out)


@pytest.mark.parametrize("name", [FRAMES_FILE, LINES_FILE, RESIDUE_FILE])
def test_damage_costs_the_same_whenever_a_tail_looks(tmp_path: Path, name: str) -> None:
    text = name == LINES_FILE
    stream = b"1,2,3\n" * 20 if text else noisy(_FRAMES[:15])
    stored(tmp_path, stream, LineFramer() if text else Framer(), size=40)
    whole = (tmp_path / name).read_bytes()
    for seed in range(40):
        choose = random.Random(seed)
        data = damaged(whole, choose)
        cuts = sorted(choose.randrange(len(data)) for _ in range(3))
        read = []
        for ends in ([len(data)], [*cuts, len(data)]):
            folder = tmp_path / f"{seed}-{len(ends)}"
            folder.mkdir()
            tail, records = RawTail(folder), []
            for end in ends:
                (folder / name).write_bytes(data[:end])
                records += tail.poll()
            read.append((records, tail.damage))
        assert read[0] == read[1]


def test_damage_in_the_middle_costs_only_what_it_hit(tmp_path: Path, frames) -> None:
    sent = frames(200)
    stored(tmp_path, b"".join(sent), Framer())
    path = tmp_path / FRAMES_FILE
    data = bytearray(path.read_bytes())
    choose = random.Random(4)
    place = len(data) // 2
    data[place : place + 30] = choose.randbytes(30)
    del data[place // 2 : place // 2 + 11]
    path.write_bytes(data)
    damage = RawDamage("")
    read = [record.data for record in read_tlog(path, damage)]
    assert len(set(sent) - set(read)) <= 5
    assert set(read) <= set(sent)
    assert damage.location_count == 2
    assert "2 places" in damage.describe()


def test_damage_in_residue_and_lines_is_stepped_over(tmp_path: Path) -> None:
    writer = RawWriter(tmp_path)
    for number in range(20):
        writer.append(STAMP + number, [Residue(number * 5, b"piece")])
        writer.append(STAMP + 100 + number, LineFramer().feed(b"1,2,3\n"))
    writer.close()
    residue = bytearray((tmp_path / RESIDUE_FILE).read_bytes())
    residue[60:70] = b"\xff" * 10
    (tmp_path / RESIDUE_FILE).write_bytes(residue)
    lines = (tmp_path / LINES_FILE).read_bytes().splitlines(keepends=True)
    lines[3] = lines[3].replace(b"\t", b"?")
    (tmp_path / LINES_FILE).write_bytes(b"".join(lines))
    tail = RawTail(tmp_path)
    records = tail.poll()
    assert sum(record.kind == "residue" for record in records) == 19
    assert sum(record.kind == "line" for record in records) == 19
    line = len(f"{STAMP + 100}\t1,2,3\n")
    assert {damage.describe().split(" damaged")[0] for damage in tail.damage} == {
        f"{LINES_FILE}: {line}",
        f"{RESIDUE_FILE}: {20 + len(b'piece')}",
    }
    assert all(damage.describe() for damage in tail.damage)


@given(st.binary(max_size=500))
@settings(max_examples=50, deadline=None)
def test_no_content_makes_the_readers_fail(content: bytes) -> None:
    with tempfile.TemporaryDirectory() as name:
        for file in (FRAMES_FILE, LINES_FILE, RESIDUE_FILE):
            (Path(name) / file).write_bytes(content)
        RawTail(name).poll()
        RawWriter(name).close()
        list(read_tlog(Path(name) / FRAMES_FILE))


def test_a_damaged_stamp_does_not_send_a_record_to_another_century(tmp_path, frames) -> None:
    first, second = frames(2)
    stamps = (STAMP, STAMP | 1 << 60)
    content = b"".join(
        struct.pack(">Q", stamp) + frame
        for stamp, frame in zip(stamps, (first, second), strict=True)
    )
    (tmp_path / FRAMES_FILE).write_bytes(content)
    damage = RawDamage("")
    records = list(read_tlog(tmp_path / FRAMES_FILE, damage))
    assert [record.stamp_us for record in records] == [STAMP, STAMP]
    assert damage.stamps == 1
    assert "1 impossible stamp" in damage.describe()


def test_a_real_log_is_read_whole(real_log: Path) -> None:
    damage = RawDamage("")
    records = list(read_tlog(real_log, damage))
    assert len(records) == 26_183
    assert not damage
    assert {record.data[0] for record in records} == {0xFE, 0xFD}
    assert (records[-1].stamp_us - records[0].stamp_us) / 1e6 == pytest.approx(132.3, abs=0.1)


def test_a_log_without_a_message_is_none(tmp_path: Path, frames) -> None:
    log = tmp_path / "other.tlog"
    for content in (b"", random.Random(3).randbytes(5000)):
        log.write_bytes(content)
        assert list(read_tlog(log)) == []
        with pytest.raises(FlightError, match=r"other\.tlog"):
            list(read_nonempty_tlog(log))


def test_an_unreadable_file_gets_a_sentence(tmp_path: Path) -> None:
    with pytest.raises(FlightError, match="no such file"):
        list(read_tlog(tmp_path / "missing.tlog"))
    (tmp_path / FRAMES_FILE).mkdir()
    with pytest.raises(FlightError, match="it is a folder"):
        RawTail(tmp_path).poll()
    (tmp_path / "file").write_text("")
    with pytest.raises(FlightError, match="cannot be written"):
        RawWriter(tmp_path / "file" / "folder")


class FullDisk:
    def __init__(self, room: int) -> None:
        self.room = room

    def write(self, descriptor: int, data: bytes) -> int:
        if self.room <= 0:
            raise OSError(errno.ENOSPC, "No space left on device")
        count = os.write(descriptor, data[: self.room])
        self.room -= count
        return count


@pytest.mark.parametrize("room", [0, 1, 100, 333, 1000])
def test_a_full_disk_is_survived(tmp_path: Path, frames, room: int) -> None:
    disk = FullDisk(room)
    writer = RawWriter(tmp_path, write=disk.write)
    sent = frames(100)
    framer = Framer()
    for index, frame in enumerate(sent):
        writer.append(STAMP + index, framer.feed(b"no" + frame))
    assert "disk" in writer.state.error
    assert "full" in writer.state.error
    assert writer.state.waiting_bytes > 0
    assert not writer.retry()
    disk.room = 10**9
    assert writer.retry()
    assert (writer.state.error, writer.state.waiting_bytes) == ("", 0)
    writer.append(STAMP + 1000, framer.flush())
    writer.close()
    tail = RawTail(tmp_path)
    assert [record.data for record in tail.poll() if record.kind == "frame"] == sent
    assert tail.damage == ()


def test_what_waits_in_the_end_is_told_apart_from_what_was_dropped(tmp_path: Path, frames) -> None:
    writer = RawWriter(tmp_path, write=FullDisk(50).write, memory_bytes=2000)
    framer = Framer()
    for index, frame in enumerate(frames(300)):
        writer.append(STAMP + index, framer.feed(frame) + framer.flush_complete())
    dropped, waiting = writer.state.dropped_records, writer.state.waiting_bytes
    writer.close()
    state = writer.state
    assert (state.dropped_records, state.lost_bytes) == (dropped, waiting)
    assert state.lost_records == state.unwritten[FRAMES_FILE] - dropped > 0
    assert state.unwritten[FRAMES_FILE] in (299, 300)


def test_a_full_memory_keeps_the_newest_and_tells(tmp_path: Path, frames) -> None:
    disk = FullDisk(50)  # in the middle of a record
    writer = RawWriter(tmp_path, write=disk.write, memory_bytes=2000)
    sent, framer = frames(300), Framer()
    for index, frame in enumerate(sent):
        writer.append(STAMP + index, framer.feed(frame) + framer.flush_complete())
    assert writer.state.waiting_bytes <= 2000
    assert writer.state.dropped_records > 200
    disk.room = 10**9
    writer.close()
    tail = RawTail(tmp_path)
    read = [record.data for record in tail.poll()]
    kept = len(sent) - writer.state.dropped_records
    assert len(read) == kept
    assert read[-10:] == sent[-10:]
    assert read[0] == sent[0]
    assert tail.damage == ()


def test_a_disk_that_does_not_keep_what_it_took_is_told_until_it_does(
    tmp_path: Path, frames, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nothing waits in memory, and writing goes on: another sentence than for a full disk."""
    failing = True

    def flush(_: int) -> None:
        if failing:
            raise OSError(errno.EIO, "Input/output error")

    monkeypatch.setattr(os, "fsync", flush)
    writer, framer = RawWriter(tmp_path), Framer()
    sent = frames(4)

    def take(number: int) -> None:
        writer.append(STAMP + number, framer.feed(sent[number]) + framer.flush_complete())

    take(0)
    writer.sync()
    assert "Input/output error" in writer.state.sync_error
    assert "memory" not in writer.state.sync_error
    assert writer.state.error == ""
    told = writer.state.sync_error
    take(1)
    assert writer.retry()
    assert writer.state.sync_error == told
    # A system forgets what it could not flush: success without anything new proves nothing.
    writer.sync()
    failing = False
    writer.sync()
    assert writer.state.sync_error == told
    take(2)
    writer.sync()
    assert writer.state.sync_error == ""
    take(3)
    writer.close()
    assert [record.data for record in RawTail(tmp_path).poll()] == sent


def test_the_drive_empties_its_memory_as_a_record_ends(
    tmp_path: Path, frames, monkeypatch: pytest.MonkeyPatch
) -> None:
    emptied: list[int] = []
    monkeypatch.setattr(
        raw_writer, "flush_to_disk", lambda file: emptied.append(os.fstat(file).st_ino)
    )
    writer, framer = RawWriter(tmp_path), Framer()
    writer.append(STAMP, framer.feed(b"no" + frames(1)[0]) + framer.flush_complete())
    writer.sync()
    assert emptied == []
    writer.close()
    written = [tmp_path / name for name in (FRAMES_FILE, RESIDUE_FILE)]
    assert sorted(emptied) == sorted(path.stat().st_ino for path in written)


@pytest.mark.skipif(sys.platform == "win32", reason="Windows renames no folder with open files")
def test_a_disk_that_was_pulled_out_is_written_to_again_when_it_is_back(
    tmp_path: Path, frames
) -> None:
    """What was open on it stays dead; the files are opened anew, and nothing is missing."""
    folder, pulled = tmp_path / "stick", tmp_path / "pulled"
    dead: set[int] = set()

    def write(descriptor: int, data: bytes) -> int:
        if os.fstat(descriptor).st_ino in dead:
            raise OSError(errno.EIO, "Input/output error")
        return os.write(descriptor, data)

    writer, framer, sent = RawWriter(folder, write=write), Framer(), frames(9)

    def take(numbers: range) -> None:
        for number in numbers:
            writer.append(STAMP + number, framer.feed(sent[number]) + framer.flush_complete())

    take(range(3))
    dead.add((folder / FRAMES_FILE).stat().st_ino)
    folder.rename(pulled)
    take(range(3, 6))
    assert writer.state.waiting_bytes > 0
    assert "Input/output error" in writer.state.error
    assert "full" not in writer.state.error
    assert not writer.retry()
    shutil.copytree(pulled, folder)
    take(range(6, 9))
    assert writer.retry()
    assert (writer.state.error, writer.state.waiting_bytes) == ("", 0)
    writer.close()
    assert [record.data for record in RawTail(folder).poll()] == sent


def test_senders_are_read_as_far_as_frames_need_them(tmp_path: Path, frames) -> None:
    """Two take turns for so long that the file has several blocks; a late poll finds the rest."""
    sent = frames(2)
    origins = [FrameOrigin(f"10.0.0.{k}:14550", "valid") for k in (1, 2)]
    writer, framer = RawWriter(tmp_path), Framer()
    count = 60_000
    for k in range(count):
        writer.append(1_700_000_000_000_000 + k, framer.feed(sent[k % 2]), origins[k % 2])
    tail = RawTail(tmp_path)
    assert (tmp_path / SENDERS_FILE).stat().st_size > 2 << 20
    first = tail.poll(10)
    assert [record.origin for record in first] == [origins[k % 2] for k in range(10)]
    assert len(tail._senders.records) < count - 10_000
    rest = tail.poll()
    writer.append(1_700_000_000_900_000, framer.feed(sent[0]))
    writer.close()
    last = tail.poll()
    whole = [*first, *rest, *last]
    assert [record.origin for record in whole] == [origins[k % 2] for k in range(count)] + [
        FrameOrigin()
    ]
    assert [record.origin for record in RawTail(tmp_path).poll()] == [r.origin for r in whole]


def test_a_record_that_goes_on_has_its_own_sender(tmp_path: Path, frames) -> None:
    """Continued over a link without addresses, frames do not become those of the former sender."""
    one, two = frames(2)
    for stamp, frame, origin in ((1, one, FrameOrigin("10.0.0.1:5")), (2, two, FrameOrigin())):
        writer = RawWriter(tmp_path)
        writer.append(stamp, Framer().feed(frame), origin)
        writer.close()
    assert [r.origin for r in RawTail(tmp_path).poll()] == [
        FrameOrigin("10.0.0.1:5"),
        FrameOrigin(),
    ]


@pytest.mark.parametrize("memory", range(2000, 2600, 100))
def test_a_full_disk_never_gives_frames_to_another_sender(
    tmp_path: Path, frames, memory: int
) -> None:
    """What memory drops are the oldest frames; those that stay keep their sender."""
    (frame,) = frames(1)
    full = True

    def write(descriptor: int, data: bytes) -> int:
        if full:
            raise OSError(errno.ENOSPC, "No space left on device")
        return os.write(descriptor, data)

    writer = RawWriter(tmp_path, memory_bytes=memory, write=write)
    for k in range(1000):
        origin = FrameOrigin(f"10.0.0.{k // 10 % 7}:5")
        writer.append(1_700_000_000_000_000 + k, Framer().feed(frame), origin)
    assert writer.state.waiting_bytes < memory + 200
    full = False
    writer.close()
    kept = RawTail(tmp_path).poll()
    assert 0 < len(kept) < 100
    for record in kept:
        k = record.stamp_us - 1_700_000_000_000_000
        assert record.origin.address == f"10.0.0.{k // 10 % 7}:5"
