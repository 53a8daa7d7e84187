"""The box on the link: frames a foreign reader understands, at the rates agreed; its log."""

import os
import socket
import threading
from collections import Counter
from multiprocessing import active_children
from pathlib import Path

import numpy as np
import pytest
from pymavlink import mavutil

from calibration.adc import ADC_RESOLUTION
from calibration.certificate_toml import load_certificates
from gsapp.decoding.framing import Framer, MavlinkFrame, Residue
from gsapp.telemetry.clock import HostClock
from gsapp.telemetry.sources import open_source
from gsapp.virtual.downlink.downlink_transmitter import DownlinkTransmitter
from gsapp.virtual.downlink.flight_settings import FlightSettings
from gsapp.virtual.downlink.onboard_log import LOG_DATA_BYTES, LOG_ID, LogServer
from gsapp.virtual.downlink.onboard_messages import dialect
from gsapp.virtual.downlink.virtual_source import VirtualSource
from gsapp.virtual.instruments import DAQ_CHANNELS
from gsapp.virtual.settings import VIRTUAL

os.environ.setdefault("MAVLINK20", "1")


SECONDS = 12
START = 1_700_000_000_000_000


def _frames(settings: FlightSettings, seconds: int = SECONDS) -> list[MavlinkFrame]:
    downlink = settings.create_downlink(START)
    data = b"".join(b"".join(packet.live_frames) for packet in downlink.advance(100 * seconds))
    framer = Framer()
    pieces = [*framer.feed(data), *framer.flush()]
    assert all(isinstance(piece, MavlinkFrame) for piece in pieces)
    return [piece for piece in pieces if isinstance(piece, MavlinkFrame)]


@pytest.fixture(scope="module")
def full() -> list[MavlinkFrame]:
    return _frames(FlightSettings(plan="short", seed=3))


@pytest.fixture(scope="module")
def thin() -> list[MavlinkFrame]:
    return _frames(FlightSettings(plan="short", seed=3, thin=True))


def _rates(frames: list[MavlinkFrame]) -> dict[str, float]:
    names = Counter(dialect.mavlink_map[frame.message_id].msgname for frame in frames)
    return {name: count / SECONDS for name, count in names.items()}


def test_the_full_link_has_the_rates_agreed(full: list[MavlinkFrame]) -> None:
    rates = _rates(full)
    expected = {
        "DEBUG_FLOAT_ARRAY": 100, "ATTITUDE": 50, "SERVO_OUTPUT_RAW": 50, "RC_CHANNELS": 20,
        "RAW_RPM": 20, "SCALED_PRESSURE": 10, "VFR_HUD": 5, "SYS_STATUS": 1, "HEARTBEAT": 1,
        "SYSTEM_TIME": 1,
    }  # fmt: skip
    assert {name: rates[name] for name in expected} == expected
    assert "GLOBAL_POSITION_INT" not in rates


def test_the_thin_link_fits_a_57600_baud_radio(thin: list[MavlinkFrame]) -> None:
    assert _rates(thin)["DEBUG_FLOAT_ARRAY"] == 20
    per_second: Counter[int] = Counter()
    second = 0
    for frame in thin:
        if frame.message_id == dialect.MAVLINK_MSG_ID_DEBUG_FLOAT_ARRAY:
            second = int.from_bytes(frame.payload[:8], "little") // 1_000_000
        per_second[second] += len(frame.data)
    assert max(per_second.values()) < VIRTUAL.thin_rate


def test_attitude_can_be_left_out_and_position_added() -> None:
    frames = _frames(FlightSettings(plan="short", seed=3, attitude=False, position=True), 2)
    names = {dialect.mavlink_map[frame.message_id].msgname for frame in frames}
    assert "ATTITUDE" not in names
    assert "GLOBAL_POSITION_INT" in names


def test_sequence_numbers_have_no_gap(full: list[MavlinkFrame], thin: list[MavlinkFrame]) -> None:
    for frames in (full, thin):
        numbers = np.array([frame.sequence for frame in frames])
        assert np.all(np.diff(numbers) % 256 == 1)
        assert {(frame.system, frame.component, frame.version) for frame in frames} == {(1, 1, 2)}


def test_a_foreign_reader_gets_the_volts_over_udp() -> None:
    """MAVUtil on a real socket decodes what Transmitter sends; the volts are counts."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    reader = mavutil.mavlink_connection(f"udpin:127.0.0.1:{port}", dialect="all")
    source = open_source(f"udpout:127.0.0.1:{port}")
    source.open()

    class Line:
        def send(self, data: bytes) -> None:
            source.write(data)

        def receive(self, timeout: float) -> bytes:
            return b"".join(chunk.data for chunk in source.read(timeout))

    downlink = FlightSettings(plan="short", seed=3).create_downlink(START)
    transmitter = DownlinkTransmitter(downlink, Line(), clock=HostClock(), speed=20.0)
    thread = threading.Thread(target=transmitter.transmit, daemon=True)
    thread.start()
    seen: dict[str, object] = {}
    stamps: list[int] = []
    while len(stamps) < 300:
        message = reader.recv_match(blocking=True, timeout=5.0)
        seen[message.get_type()] = message
        if message.get_type() == "DEBUG_FLOAT_ARRAY":
            assert message.name == "daq"
            stamps.append(message.time_usec)
            volts = np.array(message.data[:20])
            assert volts / ADC_RESOLUTION == pytest.approx(
                np.round(volts / ADC_RESOLUTION), abs=1e-3
            )
    assert set(np.diff(stamps)) == {10_000}
    q = load_certificates("b777")["q"].evaluate(volts[DAQ_CHANNELS.index("q")])
    assert abs(float(q)) < 0.1
    assert "BAD_DATA" not in seen
    assert {"HEARTBEAT", "ATTITUDE", "RC_CHANNELS", "SERVO_OUTPUT_RAW"} <= set(seen)
    downlink.stop()
    thread.join(5.0)
    assert not thread.is_alive()
    source.close()
    reader.close()


def test_the_virtual_link_is_a_source_like_any_other() -> None:
    """Flown in another process, in the registry under `virtual`; it ends when it is closed."""
    source = open_source("virtual", settings=FlightSettings(plan="short", seed=3), speed=50.0)
    assert isinstance(source, VirtualSource)
    framer, names = Framer(), Counter[str]()
    clock = HostClock()
    deadline = clock.monotonic() + 60.0
    while sum(names.values()) < 2000 and clock.monotonic() < deadline:
        for chunk in source.read(0.1):
            for piece in framer.feed(chunk.data):
                assert isinstance(piece, MavlinkFrame)
                names[dialect.mavlink_map[piece.message_id].msgname] += 1
    assert names["DEBUG_FLOAT_ARRAY"] > 500
    assert source.connected
    source.write(b"it need not listen")
    source.close()
    source.close()
    assert not source.connected
    assert source.read(0.0) == []
    assert "closed" in source.state


@pytest.mark.usefixtures("pipes_stay")
def test_a_flight_that_dies_while_it_starts_is_over() -> None:
    """Else the recorder would wait for it without end."""
    source = open_source("virtual", settings=FlightSettings(plan="short"))
    source.read(0.0)
    flying = next(child for child in active_children() if child.name == "virtual aircraft")
    flying.kill()
    flying.join()
    assert source.read(0.0) == []
    assert source.finished
    assert "failed" in source.state


def test_a_wrong_plan_is_told_in_the_state_of_the_link() -> None:
    source = open_source("virtual", settings=FlightSettings(plan="nowhere"))
    assert source.read(0.0) == []
    assert "nowhere" in source.state
    assert source.finished


def test_a_thin_flight_hands_out_its_full_log_over_the_same_link(tmp_path: Path) -> None:
    """The log can be listed and fetched; it holds the volts 100 times a second."""
    settings = FlightSettings(plan="short", seed=3, thin=True)
    downlink = settings.create_downlink(START)
    log, server = settings.create_onboard_log(tmp_path / "onboard.tlog", START)
    for packet in downlink.advance(300):
        log.append(packet.stamp_us, packet.onboard_frames)
    log.flush()
    size = log.path.stat().st_size
    downlink.stop()

    class Ground:
        """Asks for the list, then for all of it."""

        def __init__(self) -> None:
            self._ask = dialect.MAVLink(None, srcSystem=255)
            self._framer = Framer()
            self._decoder = dialect.MAVLink(None)
            self.size = 0
            self.pieces: dict[int, bytes] = {}
            self._outbox = [dialect.MAVLink_log_request_list_message(1, 1, 0, 0xFFFF)]

        def send(self, data: bytes) -> None:
            self.take(self._framer.feed(data))

        def end(self) -> None:
            """Take what the framer held: the log holds frames, whose starts look like starts."""
            self.take(self._framer.flush_complete())

        def take(self, pieces: list[MavlinkFrame | Residue]) -> None:
            for piece in pieces:
                assert isinstance(piece, MavlinkFrame)
                message = self._decoder.decode(bytearray(piece.data))
                if message.get_type() == "LOG_ENTRY":
                    self.size = message.size
                    self._outbox.append(
                        dialect.MAVLink_log_request_data_message(1, 1, message.id, 0, 0xFFFFFFFF)
                    )
                elif message.get_type() == "LOG_DATA":
                    self.pieces[message.ofs] = bytes(message.data[: message.count])

        def receive(self, timeout: float) -> bytes:
            del timeout
            return bytes(self._outbox.pop(0).pack(self._ask)) if self._outbox else b""

    ground = Ground()
    transmitter = DownlinkTransmitter(
        downlink, ground, clock=HostClock(), thin=False, log=log, server=server
    )
    transmitter.serve_log_requests(0.3)
    log.close()
    ground.end()
    assert ground.size == size
    fetched = b"".join(data for _, data in sorted(ground.pieces.items()))
    assert fetched == log.path.read_bytes()
    reader = mavutil.mavlink_connection(str(log.path), dialect="all")
    stamps = []
    while (message := reader.recv_match(type="DEBUG_FLOAT_ARRAY")) is not None:
        stamps.append(message.time_usec)
    assert stamps == list(range(0, 3_000_000, 10_000))


@pytest.fixture
def log(tmp_path: Path) -> Path:
    path = tmp_path / "onboard.tlog"
    path.write_bytes(np.random.default_rng(3).bytes(1234))
    return path


def test_the_list_names_one_log_with_its_size(log: Path) -> None:
    server = LogServer(log, started=1_700_000_000)
    server.handle_request(dialect.MAVLink_log_request_list_message(1, 1, 0, 0xFFFF))
    (entry,) = server.pending_responses(1000)
    assert (entry.id, entry.num_logs, entry.last_log_num) == (LOG_ID, 1, LOG_ID)
    assert entry.size == 1234
    assert entry.time_utc == 1_700_000_000


def test_the_whole_log_comes_within_the_budget_of_each_turn(log: Path) -> None:
    server = LogServer(log, started=0)
    server.handle_request(dialect.MAVLink_log_request_data_message(1, 1, LOG_ID, 0, 0xFFFFFFFF))
    pieces, turns = {}, 0
    while answers := list(server.pending_responses(300)):
        turns += 1
        assert len(answers) <= 3
        for answer in answers:
            pieces[answer.ofs] = (answer.count, bytes(answer.data[: answer.count]))
    assert turns > 4
    assert b"".join(data for _, (_, data) in sorted(pieces.items())) == log.read_bytes()
    assert pieces[max(pieces)][0] < LOG_DATA_BYTES


def test_a_lost_piece_can_be_asked_for_again(log: Path) -> None:
    server = LogServer(log, started=0)
    server.handle_request(dialect.MAVLink_log_request_data_message(1, 1, LOG_ID, 180, 180))
    answers = list(server.pending_responses(10_000))
    assert [answer.ofs for answer in answers] == [180, 270]
    assert b"".join(bytes(a.data[: a.count]) for a in answers) == log.read_bytes()[180:360]


def test_erase_is_not_obeyed_and_end_stops(log: Path) -> None:
    server = LogServer(log, started=0)
    before = log.read_bytes()
    server.handle_request(dialect.MAVLink_log_erase_message(1, 1))
    assert list(server.pending_responses(1000)) == []
    assert log.read_bytes() == before
    server.handle_request(dialect.MAVLink_log_request_data_message(1, 1, LOG_ID, 0, 0xFFFFFFFF))
    list(server.pending_responses(200))
    server.handle_request(dialect.MAVLink_log_request_end_message(1, 1))
    assert list(server.pending_responses(1000)) == []


def test_a_request_beyond_the_end_gets_the_end_mark(log: Path) -> None:
    server = LogServer(log, started=0)
    server.handle_request(dialect.MAVLink_log_request_data_message(1, 1, LOG_ID, 5000, 90))
    (answer,) = server.pending_responses(1000)
    assert answer.count == 0
