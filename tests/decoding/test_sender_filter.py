"""Frames of a system from one address only, whatever the pieces in which they are fed."""

from pathlib import Path

import pytest

from gsapp.decoding.channel_map import load_channel_map
from gsapp.decoding.decoder import Decoder
from gsapp.decoding.sender_filter import FrameOrigin, host_of
from gsapp.decoding.settings import DECODING
from gsapp.flight.flight_loader import guess_channel_map
from gsapp.flight.raw_files.record_files import RawRecord
from tests.decoding.decoding_kit import Sender, assert_same, decode_in_chunks

HOME, ELSEWHERE = "10.0.0.1:5000", "10.0.0.9:5000"


def decoder(**options) -> Decoder:
    return Decoder(load_channel_map("ardupilot-plane"), **options)


def heartbeat(sender: Sender, host_us: int) -> RawRecord:
    return sender(host_us, "heartbeat", 1, 3, 0, 0, 4, 3)


def at(record: RawRecord, address: str, signature: str = "") -> RawRecord:
    return record._replace(origin=FrameOrigin(address, signature))


def two_senders(seconds: int = 6) -> list[RawRecord]:
    """Return records of system 1 from two addresses; the other one begins, home heartbeats."""
    home, other = Sender(), Sender()
    records = []
    for k in range(20 * seconds):
        host = 50_000 * k
        records.append(at(other.attitude(host, 1000 + 50 * k, 0.9), ELSEWHERE))
        if k >= 10:
            if k % 20 == 10:
                records.append(at(heartbeat(home, host + 5), HOME))
            records.append(at(home.attitude(host + 10, 7000 + 50 * k, 0.1), HOME))
    return records


@pytest.mark.parametrize("sizes", [[1], [7, 1, 30], [1000]])
def test_the_first_heartbeat_decides_however_the_record_is_cut(sizes: list[int]) -> None:
    records = two_senders()
    whole, one = decode_in_chunks(decoder, records, [len(records)])
    cut, other = decode_in_chunks(decoder, records, sizes)
    assert_same(whole, cut)
    assert set(whole["phi"][1].round(6)) == {0.1}
    assert one.health.addresses == other.health.addresses == {1: HOME}
    counts = [
        {key: found.count for key, found in each.health.rejected.items()} for each in (one, other)
    ]
    assert counts == [{(1, "10.0.0.9", "address"): 120}] * 2
    assert one.health.lost == 0


@pytest.mark.parametrize("chosen", ["10.0.0.9", ELSEWHERE])
def test_the_address_that_was_chosen_counts_from_the_beginning(chosen: str) -> None:
    found, made = decode_in_chunks(lambda: decoder(system=1, address=chosen), two_senders(), [50])
    assert set(found["phi"][1].round(6)) == {0.9}
    assert sum(one.count for one in made.health.rejected.values()) == 116


def test_a_link_without_an_autopilot_is_read_after_three_seconds() -> None:
    sender = Sender(component=191)
    records = [at(sender.attitude(50_000 * k, 1000 + 50 * k, 0.3), HOME) for k in range(100)]
    found, _ = decode_in_chunks(decoder, records, [10])
    whole, _ = decode_in_chunks(
        decoder, [one._replace(origin=FrameOrigin()) for one in records], [10]
    )
    assert_same(found, whole)


def test_a_flood_of_forged_addresses_takes_no_memory() -> None:
    made, home, forged = decoder(), Sender(), Sender()
    made.feed([at(heartbeat(home, 0), HOME)])
    made.feed([at(heartbeat(forged, k + 1), f"10.1.{k // 250}.{k % 250}:1") for k in range(5000)])
    assert len(made.health.rejected) == DECODING.max_rejected_senders + 1
    assert sum(one.count for one in made.health.rejected.values()) == 5000
    assert len(made.notices) <= DECODING.max_rejected_senders + 2


def test_only_signed_frames_are_taken_where_signatures_are_checked() -> None:
    sender, radio = Sender(), Sender(51, 68)
    records = [
        at(heartbeat(sender, 0), HOME, "valid"),
        at(sender.attitude(10, 1000, 0.1), HOME, "valid"),
        *(
            at(sender.attitude(20 + k, 1020 + k, 0.9), HOME, state)
            for k, state in enumerate(("unsigned", "false", "replayed"))
        ),
        at(radio(40, "radio_status", 180, 190, 100, 40, 45, 0, 0), HOME, "unsigned"),
        at(sender.attitude(50_000, 1050, 0.1), HOME, "valid"),
    ]
    found, made = decode_in_chunks(decoder, records, [3])
    assert set(found["phi"][1].round(6)) == {0.1}
    reasons = {reason: one.count for (_, _, reason), one in made.health.rejected.items()}
    assert reasons == {"unsigned": 1, "false": 1, "replayed": 1}
    assert [one.system for one in made.health.report().senders if one.radio] == [51]


def test_a_stranger_does_not_choose_the_channel_map(tmp_path: Path) -> None:
    home, forged = Sender(), Sender()
    records = [
        at(forged.daq(0, 1000, [1.0]), ELSEWHERE),
        at(heartbeat(home, 1000), HOME),
        at(forged.daq(2000, 2000, [1.0]), ELSEWHERE),
    ]
    names = [load_channel_map(name).name for name in ("ardupilot-plane", "b777")]
    assert guess_channel_map(records, tmp_path).name == names[0]
    trusted = [record._replace(origin=FrameOrigin()) for record in records]
    assert guess_channel_map(trusted, tmp_path).name == names[1]


@pytest.mark.parametrize(
    ("address", "host"),
    [("10.0.0.1:5000", "10.0.0.1"), ("10.0.0.1", "10.0.0.1"), ("fe80::1:5000", "fe80::1")],
)
def test_the_host_of_an_address(address: str, host: str) -> None:
    assert host_of(address) == host
