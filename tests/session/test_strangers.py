"""A stranger on the network who sends frames with the id of the aircraft."""

import socket
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from gsapp.decoding.dialect import dialect
from gsapp.flight import load_flight
from gsapp.flight.file_names import SENDERS_FILE
from gsapp.flight.folder_setup import prepare_flight_folder
from gsapp.flight.raw_files import RawTail
from gsapp.session import Session
from gsapp.session.limits import Severity
from gsapp.telemetry.recorder_control import RecorderHandle, start_recorder

pytestmark = pytest.mark.skipif(
    sys.platform != "linux", reason="only Linux has every address of 127.0.0.0/8 at once"
)

AIRCRAFT, STRANGER = "127.0.0.1", "127.0.0.2"


class Transmitter:
    """Sends MAVLink from an address of this computer."""

    def __init__(self, host: str, port: int, system: int = 1) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind((host, 0))
        self._socket.connect(("127.0.0.1", port))
        self.address = f"{host}:{self._socket.getsockname()[1]}"
        self._mavlink = dialect().MAVLink(None, srcSystem=system, srcComponent=1)
        self._start = time.monotonic()
        self.sent = 0

    def _send(self, name: str, *fields: object) -> None:
        message = getattr(dialect(), f"MAVLink_{name}_message")(*fields)
        self._socket.send(bytes(message.pack(self._mavlink)))
        self._mavlink.seq = (self._mavlink.seq + 1) % 256
        self.sent += 1

    def heartbeat(self) -> None:
        self._send("heartbeat", 1, 3, 0, 0, 4, 3)

    def attitude(self, roll: float) -> None:
        boot_ms = 1000 + round(1000 * (time.monotonic() - self._start))
        self._send("attitude", boot_ms, roll, 0.0, 0.0, 0.0, 0.0, 0.0)

    def close(self) -> None:
        self._socket.close()


class Field:
    """A recorder on a UDP port of all addresses of this computer."""

    def __init__(self, folder: Path) -> None:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            probe.bind(("127.0.0.1", 0))
            self.port = probe.getsockname()[1]
        prepare_flight_folder(folder, aircraft="b777", channel_map="ardupilot-plane", source="u")
        self.folder = folder
        self.recorder: RecorderHandle = start_recorder(f"udpin:0.0.0.0:{self.port}", folder)
        self.transmitters: list[Transmitter] = []

    def transmitter(self, host: str, system: int = 1) -> Transmitter:
        self.transmitters.append(Transmitter(host, self.port, system))
        return self.transmitters[-1]

    def close(self) -> None:
        for transmitter in self.transmitters:
            transmitter.close()
        self.recorder.stop()


@pytest.fixture
def field(tmp_path: Path) -> Iterator[Field]:
    found = Field(tmp_path / "flight")
    yield found
    found.close()


def run(session: Session, each: Callable[[], object], until: Callable[[], object]) -> None:
    """Send and follow until something is seen."""
    deadline = time.monotonic() + 15.0
    while not until():
        assert time.monotonic() < deadline
        each()
        session.update()
        time.sleep(0.02)


def rolls(folder: Path) -> np.ndarray:
    values = load_flight(folder).block["phi"]
    return np.unique(np.round(values[np.isfinite(values)], 3))


def test_a_stranger_who_speaks_first_is_not_the_aircraft(field: Field) -> None:
    """It sends frames of system 1 before and after the aircraft does; none of them is decoded."""
    stranger, aircraft = field.transmitter(STRANGER), field.transmitter(AIRCRAFT)
    session = Session.follow(field.folder, cues=False)
    for _ in range(20):
        stranger.attitude(0.9)
        time.sleep(0.01)

    def both() -> None:
        aircraft.heartbeat()
        aircraft.attitude(0.1)
        stranger.heartbeat()
        stranger.attitude(0.9)

    run(session, both, lambda: session.alarm_registry.severity("stranger") is Severity.WARNING)
    alarm = session.alarm_registry.get("stranger")
    assert alarm is not None
    assert STRANGER in alarm.message
    report = session.link_report()
    assert report is not None
    assert (report.flown.address, report.loss) == (aircraft.address, 0.0)
    assert [(one.system, one.address, one.reason) for one in report.rejected] == [
        (1, STRANGER, "address")
    ]
    run(session, both, lambda: session.states(["phi"])["phi"].value == pytest.approx(0.1))
    session.close()
    field.recorder.stop()
    # Nothing is lost: every frame of both is in the record.
    assert len(RawTail(field.folder).poll()) == stranger.sent + aircraft.sent
    assert rolls(field.folder) == pytest.approx([0.1])
    flight = load_flight(field.folder)
    assert {"flown-system", "rejected-address"} <= {event.kind for event in flight.events}


def test_the_crew_chooses_the_address_of_the_flown_system(field: Field) -> None:
    """The first heartbeat was the stranger's; the choice holds for all of the flight."""
    stranger, aircraft = field.transmitter(STRANGER), field.transmitter(AIRCRAFT)
    session = Session.follow(field.folder, cues=False)

    def both() -> None:
        for sender, roll in ((stranger, 0.9), (aircraft, 0.1)):
            sender.heartbeat()
            sender.attitude(roll)

    run(session, both, lambda: session.alarm_registry.severity("stranger") is Severity.WARNING)
    report = session.link_report()
    assert report is not None
    assert [one.address for one in report.rejected_vehicles] == [AIRCRAFT]
    session.select_system(1, AIRCRAFT)
    assert session.system_selection.pending == (1, AIRCRAFT)
    session.close()
    again = Session.follow(field.folder, cues=False)
    run(again, both, lambda: again.states(["phi"])["phi"].value == pytest.approx(0.1))
    assert again.system_selection.pending is None
    again.close()
    field.recorder.stop()
    assert rolls(field.folder) == pytest.approx([0.1])


def test_the_aircraft_may_start_again_on_another_port(field: Field) -> None:
    """Not while the former port sends still: on one computer a stranger has the same host."""
    aircraft, other = field.transmitter(AIRCRAFT), field.transmitter(AIRCRAFT)
    session = Session.follow(field.folder, cues=False)

    def both() -> None:
        for sender, roll in ((aircraft, 0.1), (other, 0.2)):
            sender.heartbeat()
            sender.attitude(roll)

    run(session, both, lambda: session.alarm_registry.severity("stranger") is Severity.WARNING)
    run(session, both, lambda: session.states(["phi"])["phi"].value == pytest.approx(0.1))

    def restarted() -> None:
        other.heartbeat()
        other.attitude(0.2)

    run(session, restarted, lambda: session.states(["phi"])["phi"].value == pytest.approx(0.2))
    session.close()


def test_a_record_without_addresses_is_read_as_before(field: Field) -> None:
    aircraft = field.transmitter(AIRCRAFT)
    session = Session.follow(field.folder, cues=False)

    def send() -> None:
        aircraft.heartbeat()
        aircraft.attitude(0.1)

    run(session, send, lambda: session.states(["phi"])["phi"].value == pytest.approx(0.1))
    session.close()
    field.recorder.stop()
    with_addresses = load_flight(field.folder)
    (field.folder / SENDERS_FILE).unlink()
    without = load_flight(field.folder)
    assert without.block.values.tobytes() == with_addresses.block.values.tobytes()
