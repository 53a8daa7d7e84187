"""A look at a growing record that reads nothing misses nothing, and is quiet in between."""

from pathlib import Path

from gsapp.decoding.framing import LineFramer
from gsapp.flight.raw_files import LINES_FILE, RESIDUE_FILE, RawTail, RawWriter

STAMP = 1_700_000_000_000_000


def test_a_look_tells_of_everything_that_a_poll_would_find(tmp_path: Path) -> None:
    """Proves that a window that polls only after such a look gets every record, and rests."""
    tail, writer = RawTail(tmp_path), RawWriter(tmp_path)
    found = []
    assert tail.has_grown()
    assert tail.poll() == []
    assert not tail.has_grown()
    for number in range(20):
        writer.append(STAMP + number, LineFramer().feed(b"%d\n" % number))
        assert tail.has_grown()
        assert tail.has_grown(), "a look must not use up the news"
        found += [record.data for record in tail.poll()]
        assert not tail.has_grown()
    writer.close()
    assert found == [b"%d" % number for number in range(20)]


def test_what_a_short_poll_left_is_news(tmp_path: Path) -> None:
    """Proves that records left for the next poll are not forgotten while nothing is written."""
    tail, writer = RawTail(tmp_path), RawWriter(tmp_path)
    writer.append(STAMP, LineFramer().feed(b"".join(b"%d\n" % k for k in range(10))))
    writer.close()
    found = []
    while tail.has_grown():
        found += tail.poll(3)
    assert len(found) == 10


def test_a_record_half_written_is_no_news_until_it_grows(tmp_path: Path) -> None:
    """Proves that a torn end does not make the window read the file at every look."""
    tail = RawTail(tmp_path)
    path = tmp_path / LINES_FILE
    path.write_bytes(b"1700000000000000\tone\n170000000000")
    assert [record.data for record in tail.poll()] == [b"one"]
    tail.poll()
    assert not tail.has_grown()
    with path.open("ab") as stream:
        stream.write(b"0001\ttwo\n")
    assert tail.has_grown()
    assert [record.data for record in tail.poll()] == [b"two"]


def test_a_file_that_appears_is_news(tmp_path: Path) -> None:
    """Proves that residue, of which most flights have none, is seen from its first byte."""
    tail = RawTail(tmp_path)
    tail.poll()
    assert not tail.has_grown()
    (tmp_path / RESIDUE_FILE).write_bytes(b"\0")
    assert tail.has_grown()
