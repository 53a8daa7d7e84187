"""Messages without a stamp that a link delivers in bursts are spread at the sender's rate."""

import random

import numpy as np
import pytest

from gsapp.decoding.channel_map import load_channel_map
from gsapp.decoding.decoder import Decoder
from gsapp.decoding.dialect import dialect
from gsapp.flight.raw_files.record_files import RawRecord
from tests.decoding.decoding_kit import HOST, assert_same, decode_in_chunks

SECONDS = 60


def ramp_records(delivery, *, rate=4.0, lost=range(0)):
    """Return a minute of ATTITUDE at 20 Hz, and of VFR_HUD whose airspeed is the time it was sent.

    `delivery` gives the time at which a VFR_HUD comes, s, by the time at which it was sent.
    """
    module = dialect()
    packer = module.MAVLink(None, srcSystem=1, srcComponent=1)
    sent = [(k / 20.0, None) for k in range(20 * SECONDS)]
    sent += [(delivery(k / rate), k / rate) for k in range(int(rate * SECONDS)) if k not in lost]
    records = []
    for time, airspeed in sorted(sent, key=lambda one: one[0]):
        if airspeed is None:
            message = module.MAVLink_attitude_message(round(1e3 * time) + 5000, 0, 0, 0, 0, 0, 0)
        else:
            message = module.MAVLink_vfr_hud_message(airspeed, 0, 0, 0, 0, 0)
        frame = bytes(message.pack(packer))
        packer.seq = (packer.seq + 1) % 256
        records.append(RawRecord(HOST + round(1e6 * time), "frame", frame))
    return records


def every_second(sent):
    """Return when a message comes that waits for the next whole second, 2 ms after another."""
    return np.ceil(sent + 1e-9) + 0.002 * (4.0 * sent % 4.0)


def decoded(records):
    decoder = Decoder(load_channel_map("ardupilot-plane"), rate=100.0)
    blocks = [*decoder.feed(records), *decoder.finish()]
    rows = [block for block in blocks if "Vc" in block.channels]
    times = np.concatenate([block.times for block in rows]) - 5.0
    return decoder, times, np.concatenate([block["Vc"] for block in rows])


@pytest.mark.parametrize("lost", [range(0), range(100, 140)], ids=["whole", "a pause"])
def test_a_burst_is_spread_at_the_rate_of_its_sender(lost):
    decoder, times, airspeed = decoded(ramp_records(every_second, lost=lost))
    there = ~np.isnan(airspeed)
    # Nothing comes in the first second.
    assert there.sum() / (100.0 * (SECONDS - 1)) > 0.95 - len(lost) / 236.0
    source = decoder.counted_sources()["Vc"]
    assert source.timing == "arrival"
    assert source.rate == pytest.approx(4.0, rel=0.1)
    # The last of a burst came one period after it was sent: no more is known.
    settled = there & (times > 5.0)
    error = times[settled] - airspeed[settled]
    assert np.median(error) == pytest.approx(0.25, abs=0.03)
    assert np.quantile(np.abs(error - 0.25), 0.95) < 0.05


@pytest.mark.parametrize("jitter", [0.0, 0.06])
def test_messages_that_come_evenly_are_timed_by_their_arrival(jitter):
    draw = random.Random(3)
    records = ramp_records(lambda sent: sent + draw.uniform(0.0, jitter))
    _, times, airspeed = decoded(records)
    there = ~np.isnan(airspeed)
    assert there.mean() > 0.97
    assert np.abs(times[there] - airspeed[there]).max() < jitter + 0.011


def test_bursts_are_spread_alike_in_any_pieces():
    records = ramp_records(every_second)
    chosen = load_channel_map("ardupilot-plane")
    whole, _ = decode_in_chunks(lambda: Decoder(chosen), records, [len(records)])
    pieces, _ = decode_in_chunks(lambda: Decoder(chosen), records, [1, 7, 50])
    assert_same(whole, pieces)
