"""A real fixed-wing flight (Carbon-Z T-28 with ArduPlane), where its record is present."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from gsapp.decoding.channel_map import load_channel_map
from gsapp.decoding.decoder import Decoder
from gsapp.flight.raw_files.record_files import RawRecord

G = 9.80665


@pytest.fixture
def records(shared_data: Path) -> list[RawRecord]:
    path = shared_data / "alfa_carbonz_engine_failure.tlog"
    if not path.is_file():
        pytest.skip(f"{path.name} is not in {shared_data}")
    data, found, place = path.read_bytes(), [], 0
    while place < len(data):
        stamp = int.from_bytes(data[place : place + 8], "big")
        magic, length = data[place + 8], data[place + 9]
        size = length + 8 if magic == 0xFE else length + 12 + 13 * (data[place + 10] & 1)
        found.append(RawRecord(stamp, "frame", data[place + 8 : place + 8 + size]))
        place += 8 + size
    return found


def test_every_frame_and_the_airspeed(records: list[RawRecord], cases: SimpleNamespace) -> None:
    """26,183 frames, airspeed 9.7 to 20 m/s, 132 s, and the engine cut at +116.3 s."""
    decoder = Decoder(load_channel_map("ardupilot-plane"))
    found = cases.gather(decoder.feed(records) + decoder.finish())
    assert len(records) == 26_183
    assert decoder.health.good == 26_183
    assert decoder.notices == []
    # SYS_STATUS, which carries no stamp, came before the first that does, 916.989 s.
    assert min(index[0] for index, _ in found.values()) == 91_698
    Vc = found["Vc"][1]
    assert np.nanmin(Vc) == pytest.approx(9.7, abs=0.1)
    assert np.nanmax(Vc) == pytest.approx(20.0, abs=0.1)
    index, throttle = found["throttle"]
    assert index[-1] - index[0] == pytest.approx(13_230, abs=30)
    after = throttle[index > (916.97 + 118.0) * 100]
    # Idle is a pulse of 1100 us.
    assert np.nanmax(after) == pytest.approx(0.1)
    assert np.nanmean(throttle) > 0.2


def test_it_is_consistent_with_itself(records: list[RawRecord], cases: SimpleNamespace) -> None:
    """Signs and units: a_n about 1 g, gyro and attitude filter agree, pitch rate turns pitch."""
    decoder = Decoder(load_channel_map("ardupilot-plane"))
    found = cases.gather(decoder.feed(records) + decoder.finish())
    assert 0.9 * G < np.nanmean(found["an"][1]) < 1.6 * G
    assert np.nanmean(found["an.2"][1]) == pytest.approx(np.nanmean(found["an"][1]), rel=0.05)

    def common(*names: str) -> list[np.ndarray]:
        first = max(found[name][0][0] for name in names)
        last = min(found[name][0][-1] for name in names)
        rows = []
        for name in names:
            index, values = found[name]
            rows.append(values[np.searchsorted(index, first) : np.searchsorted(index, last)])
        good = np.all(np.isfinite(rows), axis=0)
        return [values[good] for values in rows]

    q, q2 = common("q", "q.2")
    assert np.corrcoef(q, q2)[0, 1] > 0.99
    V, Vc, rho = common("V", "Vc", "density")
    np.testing.assert_allclose(V, Vc * np.sqrt(1.225 / rho), rtol=2e-3)
    assert decoder.sources["V"].kind == "derived"
    assert decoder.sources["phi"].kind == "estimated"
    # From the 10 Hz pressure: field elevation some 340 m, flown 30 to 60 m above it.
    altitude, height = common("altitude", "height")
    assert np.corrcoef(altitude, height)[0, 1] > 0.95


def test_it_may_be_cut_anywhere(records: list[RawRecord], cases: SimpleNamespace) -> None:
    def make() -> Decoder:
        return Decoder(load_channel_map("ardupilot-plane"))

    some = records[:6000]
    whole, _ = cases.decode_in_chunks(make, some, [6000])
    pieces, _ = cases.decode_in_chunks(make, some, [1, 7, 50, 333])
    cases.assert_same(whole, pieces)
