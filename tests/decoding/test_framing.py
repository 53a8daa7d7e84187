"""Framing: no undamaged frame may be lost, whatever stands around it."""

import os
import random
import struct
from collections import Counter
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gsapp.decoding.dialect import dialect, wire_formats
from gsapp.decoding.framing import Framer, LineFramer, MavlinkFrame, Residue, TextLine
from gsapp.decoding.health import LinkHealth
from gsapp.flight.raw_files import RawDamage, read_tlog
from gsapp.flight.raw_files.record_files import RawRecord

SECRET = b"x" * 32


class Sender:
    """Packs frames as several aircraft would: both versions, some signed, some of unknown id."""

    def __init__(self, seed: int) -> None:
        self.random = random.Random(seed)
        module = dialect()
        self.packers = [module.MAVLink(None, srcSystem=number) for number in (1, 2)]
        for packer in self.packers:
            packer.signing.secret_key = SECRET
            packer.signing.link_id = 1
            packer.signing.timestamp = 1

    def message(self):
        module, choose = dialect(), self.random

        def real() -> float:
            return choose.uniform(-10.0, 10.0)

        kind = choose.randrange(5)
        time = choose.randrange(1 << 31)
        if kind == 0:
            return module.MAVLink_attitude_message(time, *(real() for _ in range(6)))
        if kind == 1:
            return module.MAVLink_heartbeat_message(1, 3, 81, choose.randrange(1 << 30), 4, 3)
        if kind == 2:
            values = [real() for _ in range(58)]
            return module.MAVLink_debug_float_array_message(time, b"daq", 0, values)
        if kind == 3:
            pulses = [choose.randrange(1000, 2000) for _ in range(8)]
            return module.MAVLink_servo_output_raw_message(time, 0, *pulses)
        return module.MAVLink_statustext_message(6, choose.randbytes(50))

    def frame(self, *, signed: bool | None = None, version: int | None = None) -> bytes:
        packer = self.random.choice(self.packers)
        message = self.message()
        one = self.random.random() < 0.5 if version is None else version == 1
        if message.get_type() == "DEBUG_FLOAT_ARRAY":
            one = False
        packer.signing.sign_outgoing = not one and (
            self.random.random() < 0.1 if signed is None else signed
        )
        frame = bytes(message.pack(packer, force_mavlink1=one))
        packer.seq = (packer.seq + 1) % 256
        return frame

    def unknown(self) -> bytes:
        packer = self.random.choice(self.packers)
        payload = self.random.randbytes(self.random.randrange(1, 60))
        header = bytes((0xFD, len(payload), 0, 0, packer.seq, packer.srcSystem, 0))
        packer.seq = (packer.seq + 1) % 256
        return header + (15_000_000).to_bytes(3, "little") + payload + self.random.randbytes(2)

    def garbage(self) -> bytes:
        choose = self.random
        noise = choose.randbytes(choose.randrange(1, 60))
        if choose.random() < 0.5:
            return noise
        if choose.random() < 0.5:
            length, number = choose.choice([(9, 0), (28, 30), (21, 36), (255, 1)])
            head = bytes((0xFE, length, choose.randrange(256), 1, 1, number))
        else:
            sequence, number = choose.randrange(256), choose.choice([0, 30, 350, 15_000_000])
            head = bytes((0xFD, choose.randrange(256), choose.choice([0, 1]), 0, sequence, 1, 1))
            head += number.to_bytes(3, "little")
        place = choose.randrange(len(noise) + 1)
        return noise[:place] + head + noise[place:]

    def damaged(self, frame: bytes) -> bytes:
        choose = self.random
        kind = choose.randrange(3)
        if kind == 0:  # lost bytes
            start = choose.randrange(len(frame))
            return frame[:start] + frame[start + choose.randrange(1, 6) :]
        if kind == 1:  # torn off
            return frame[: choose.randrange(1, len(frame))]
        flipped = bytearray(frame)
        for _ in range(choose.randrange(1, 4)):
            flipped[choose.randrange(len(frame))] ^= 1 << choose.randrange(8)
        return bytes(flipped)


def damaged_stream(seed: int, count: int = 5000) -> tuple[bytes, list[bytes]]:
    sender = Sender(seed)
    stream, whole = bytearray(), []
    for _ in range(count):
        frame = sender.frame()
        if sender.random.random() >= 0.1:
            stream += frame
            whole.append(frame)
        elif sender.random.random() < 0.25:
            stream += sender.garbage() + frame  # garbage is no harm to what follows
            whole.append(frame)
        else:
            stream += sender.damaged(frame)
    return bytes(stream), whole


def split(stream: bytes, sizes: random.Random | None = None) -> list[MavlinkFrame | Residue]:
    framer, items, start = Framer(), [], 0
    while start < len(stream):
        size = sizes.randrange(1, 400) if sizes else len(stream)
        items += framer.feed(stream[start : start + size])
        start += size
    return items + framer.flush()


def joined(items):
    result = []
    for item in items:
        if result and isinstance(item, Residue) and isinstance(result[-1], Residue):
            result[-1] = Residue(result[-1].offset, result[-1].data + item.data)
        else:
            result.append(item)
    return result


@pytest.mark.parametrize("seed", range(8))
def test_no_undamaged_frame_is_lost_in_a_damaged_stream(seed: int) -> None:
    stream, whole = damaged_stream(seed)
    items = split(stream, random.Random(seed))
    assert b"".join(item.data for item in items) == stream
    position = 0
    for item in items:
        assert item.offset == position
        position += len(item.data)
    found = Counter(item.data for item in items if isinstance(item, MavlinkFrame))
    assert Counter(whole) - found == Counter()
    # What was damaged is not passed off as good: only signatures are beyond the checksum.
    assert found.total() - len(whole) < 40


def test_pymavlink_loses_frames_where_this_framer_loses_none() -> None:
    stream, whole = damaged_stream(3, 2000)
    foreign = dialect().MAVLink(None)
    foreign.robust_parsing = True
    messages = foreign.parse_buffer(stream) or []
    good = sum(message.get_type() != "BAD_DATA" for message in messages)
    ours = sum(isinstance(item, MavlinkFrame) for item in split(stream))
    assert ours >= len(whole) > good


def test_foreign_reader_agrees_on_a_clean_stream() -> None:
    sender = Sender(1)
    frames = [sender.frame() for _ in range(500)]
    messages = dialect().MAVLink(None).parse_buffer(b"".join(frames))
    items = split(b"".join(frames))
    assert [item.data for item in items] == frames
    assert [bytes(message.get_msgbuf()) for message in messages] == frames
    for item, message in zip(items, messages, strict=True):
        head = (item.sequence, item.system, item.component, item.message_id)
        assert head == (
            message.get_seq(),
            message.get_srcSystem(),
            message.get_srcComponent(),
            message.get_msgId(),
        )
        start = 10 if item.version == 2 else 6
        assert item.payload == item.data[start : start + message.get_header().mlen]
        assert item.version == (2 if item.data[0] == 0xFD else 1)
        assert item.known


PIECES = st.lists(
    st.tuples(st.sampled_from(["frame", "unknown", "damaged", "garbage"]), st.integers(0, 2**20)),
    max_size=12,
)


@given(pieces=PIECES, cuts=st.lists(st.integers(1, 300), min_size=1, max_size=20))
@settings(max_examples=50, deadline=None)
def test_results_do_not_depend_on_the_pieces(pieces, cuts) -> None:
    stream = b""
    for kind, seed in pieces:
        sender = Sender(seed)
        stream += {
            "frame": sender.frame,
            "unknown": sender.unknown,
            "garbage": sender.garbage,
            "damaged": lambda sender=sender: sender.damaged(sender.frame()),
        }[kind]()
    framer, items, start = Framer(), [], 0
    number = 0
    while start < len(stream):
        size = cuts[number % len(cuts)]
        items += framer.feed(stream[start : start + size])
        start, number = start + size, number + 1
    items += framer.flush()
    single = Framer()
    by_bytes = [item for byte in stream for item in single.feed(bytes((byte,)))] + single.flush()
    assert joined(items) == joined(split(stream)) == joined(by_bytes)
    assert b"".join(item.data for item in items) == stream


@given(st.binary(max_size=600))
@settings(max_examples=50, deadline=None)
def test_any_bytes_come_out_once_and_in_order(data: bytes) -> None:
    items = split(data)
    assert b"".join(item.data for item in items) == data


def test_a_whole_frame_comes_out_at_once() -> None:
    """Nothing waits for the next frame, or the display would lag by one."""
    sender, framer = Sender(5), Framer()
    prompt = 0
    for _ in range(300):
        frame = sender.frame()
        prompt += sum(item.data == frame for item in framer.feed(frame))
        framer.flush_complete()
    assert prompt > 280  # the rest ends in what might be the head of a frame


def test_a_false_header_does_not_hold_back_frames_beyond_a_pause() -> None:
    sender, framer = Sender(6), Framer()
    frame = sender.frame(version=2, signed=False)
    head = bytes((0xFD, 250, 0, 0, 1, 1, 1)) + (30).to_bytes(3, "little")
    assert [item for item in framer.feed(head + frame) if isinstance(item, MavlinkFrame)] == []
    assert [item.data for item in framer.flush_complete()] == [head, frame]


def test_a_frame_that_ends_as_another_begins_comes_out_in_a_pause() -> None:
    sender = Sender(13)
    ending = [
        frame
        for frame in (sender.frame(version=2, signed=False) for _ in range(2000))
        if frame[-1] in (0xFD, 0xFE)
    ]
    assert ending
    for frame in ending:
        for end in (Framer.flush_complete, Framer.flush):
            framer = Framer()
            assert framer.feed(frame) == []
            (item,) = end(framer)
            assert isinstance(item, MavlinkFrame)
            assert item.data == frame


def test_a_pause_in_the_middle_of_a_frame_does_not_cost_it() -> None:
    framer, frame = Framer(), Sender(7).frame()
    assert framer.feed(frame[:7]) == []
    assert framer.flush_complete() == []
    assert [item.data for item in framer.feed(frame[7:]) + framer.flush_complete()] == [frame]


def test_the_end_of_the_stream_leaves_a_torn_frame_as_residue() -> None:
    framer, frame = Framer(), Sender(7).frame()
    assert framer.feed(frame[:-1]) == []
    assert framer.flush() == [Residue(0, frame[:-1])]
    assert [item.offset for item in framer.feed(frame) + framer.flush()] == [len(frame) - 1]


def test_signed_frames_keep_their_signature() -> None:
    frame = Sender(8).frame(version=2, signed=True)
    (item,) = split(frame)
    assert isinstance(item, MavlinkFrame)
    assert item.data == frame
    assert len(frame) == 10 + frame[1] + 2 + 13


def test_a_torn_signature_does_not_swallow_the_next_frame() -> None:
    for seed in range(30):
        sender = Sender(seed)
        torn = sender.frame(version=2, signed=True)[: -1 - seed % 12]
        after = [sender.frame(signed=False) for _ in range(2)]
        items = split(torn + b"".join(after))
        assert [item.data for item in items if isinstance(item, MavlinkFrame)][-2:] == after


def test_unknown_ids_are_kept_unchecked_where_a_frame_follows() -> None:
    sender = Sender(9)
    known, unknown, last = sender.frame(), sender.unknown(), sender.frame()
    items = split(known + unknown + last + unknown)
    assert [item.data for item in items] == [known, unknown, last, unknown]
    assert [item.known for item in items] == [True, False, True, False]


@pytest.mark.parametrize("bit", range(24))
@pytest.mark.parametrize("signed", [False, True])
def test_a_flipped_bit_of_the_id_is_damage_and_not_another_dialect(bit: int, signed: bool) -> None:
    """Whether the flipped id is that of another message or of none; in a stream and in a file."""
    sender = Sender(13)
    first, hurt, last = (sender.frame(signed=signed, version=2) for _ in range(3))
    hurt = flipped(hurt, 7 + bit // 8, bit % 8)
    items = split(first + hurt + last)
    assert [item.data for item in items if isinstance(item, MavlinkFrame)] == [first, last]
    assert b"".join(item.data for item in items) == first + hurt + last
    health = LinkHealth()
    health.feed(
        [
            RawRecord(
                k * 10_000, "frame" if isinstance(item, MavlinkFrame) else "residue", item.data
            )
            for k, item in enumerate(items)
        ]
    )
    assert (health.good, health.unknown) == (2, 0)
    assert health.damaged


@pytest.mark.parametrize("bit", range(8))
def test_a_flipped_bit_of_the_id_of_mavlink_1_is_damage(bit: int) -> None:
    sender = Sender(14)
    first, hurt, last = (sender.frame(version=1) for _ in range(3))
    hurt = flipped(hurt, 5, bit)
    items = split(first + hurt + last)
    assert [item.data for item in items if isinstance(item, MavlinkFrame)] == [first, last]


def flipped(frame: bytes, place: int, bit: int) -> bytes:
    return frame[:place] + bytes((frame[place] ^ 1 << bit,)) + frame[place + 1 :]


def test_a_record_of_a_flipped_id_is_damage(tmp_path: Path) -> None:
    sender = Sender(15)
    frames = [sender.frame(version=2, signed=False) for _ in range(3)]
    frames[1] = flipped(frames[1], 8, 7)
    path = tmp_path / "raw.tlog"
    path.write_bytes(b"".join(struct.pack(">Q", 1_700_000_000_000_000) + one for one in frames))
    damage = RawDamage(name=path.name)
    assert [record.data for record in read_tlog(path, damage)] == [frames[0], frames[2]]
    assert damage.location_count == 1


def test_an_unknown_id_never_costs_a_known_frame() -> None:
    sender = Sender(10)
    frames = [sender.frame(signed=False) for _ in range(10)]
    head = bytes((0xFD, 255, 0, 0, 1, 1, 1)) + (15_000_000).to_bytes(3, "little")
    items = split(head + b"".join(frames))
    assert [item.data for item in items if isinstance(item, MavlinkFrame)] == frames


def test_a_frame_that_carries_frames_is_one_frame() -> None:
    module = dialect()
    inner = Sender(11).frame(version=1)
    payload = list((inner + bytes(251))[:251])
    message = module.MAVLink_file_transfer_protocol_message(0, 1, 1, payload)
    carrier = bytes(message.pack(module.MAVLink(None)))
    assert [item.data for item in split(carrier * 2)] == [carrier, carrier]


def test_wrong_dialect_is_recorded_but_not_called_known() -> None:
    sender = Sender(12)
    frames = [sender.unknown() for _ in range(50)]
    items = split(b"".join(frames))
    assert [item.data for item in items] == frames
    assert not any(item.known for item in items)


def test_wire_formats_know_where_extensions_begin() -> None:
    formats = wire_formats()
    assert formats[30] == (bytes((39,)), 28, 28)  # ATTITUDE
    assert formats[1].size == 31  # SYS_STATUS, as MAVLink 1 sends it
    assert formats[1].full_size == 43
    assert formats[24].size == 30  # GPS_RAW_INT
    assert all(0 <= wire.size <= wire.full_size <= 255 for wire in formats.values())


def shared_data() -> Path:
    given_folder = os.environ.get("GSAPP_SHARED_DATA")
    default = Path(__file__).parents[3] / "shared" / "data"
    return Path(given_folder) if given_folder else default


def test_every_frame_of_a_real_flight_is_found() -> None:
    path = shared_data() / "alfa_carbonz_engine_failure.tlog"
    if not path.is_file():
        pytest.skip(f"the real flight is not at {path}")
    items = split(path.read_bytes())
    # The stamps of the log are residue to a framer; every frame must be found between them.
    assert sum(isinstance(item, MavlinkFrame) for item in items) == 26_183


def lines_of(stream: bytes, cuts: list[int] | None = None, longest: int = 20):
    framer, items, start, number = LineFramer(longest), [], 0, 0
    while start < len(stream):
        size = cuts[number % len(cuts)] if cuts else len(stream)
        items += framer.feed(stream[start : start + size])
        start, number = start + size, number + 1
    return items + framer.flush()


def test_lines_end_with_cr_lf_or_both() -> None:
    items = lines_of(b"1,2\r\n3,4\n5,6\r7,8")
    assert [item.data for item in items] == [b"1,2", b"3,4", b"5,6", b"7,8"]
    assert [item.end for item in items] == [b"\r\n", b"\n", b"\r", b""]


def test_lines_that_are_no_text_are_residue() -> None:
    items = lines_of(b"good\n\xff\xfe bad\n with \0\nd\xc3\xa9j\xc3\xa0\n")
    assert [type(item) for item in items] == [TextLine, Residue, Residue, TextLine]
    assert items[1].data == b"\xff\xfe bad\n"


def test_an_overlong_line_is_cut_and_does_not_fill_the_memory() -> None:
    framer = LineFramer(20)
    for _ in range(1000):
        framer.feed(b"x" * 50)
        assert framer.pending <= 20
    items = framer.feed(b"\ngood\n")
    assert [type(item) for item in items] == [Residue, TextLine]
    assert items[-1].data == b"good"


def test_a_line_ended_by_cr_alone_comes_out_in_a_pause() -> None:
    framer = LineFramer()
    assert framer.feed(b"1,2\r") == []
    assert framer.flush_complete() == [TextLine(0, b"1,2", b"\r")]


@given(
    st.lists(st.sampled_from([b"ab", b"\r", b"\n", b"\r\n", b"\xff", b"x" * 30]), max_size=20),
    st.lists(st.integers(1, 9), min_size=1, max_size=5),
)
@settings(max_examples=50, deadline=None)
def test_lines_do_not_depend_on_the_pieces(parts, cuts) -> None:
    stream = b"".join(parts)
    items = lines_of(stream, cuts)
    assert joined(items) == joined(lines_of(stream))
    whole = b"".join(item.data + getattr(item, "end", b"") for item in items)
    assert whole == stream
