"""MAVLink 2 signatures in both directions, with pymavlink as the other end."""

import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from hashlib import sha256
from pathlib import Path

import pytest

from gsapp.decoding.dialect import dialect
from gsapp.flight.raw_files import RawTail
from gsapp.foundation import LinkError
from gsapp.session import Session
from gsapp.session.limits import Severity
from gsapp.telemetry.recorder_control import RecorderHandle, start_recorder
from gsapp.telemetry.send_queue import GroundPacker
from gsapp.telemetry.signing import (
    SignatureVerifier,
    derive_key,
    read_signing_key,
    signature_time,
    write_signing_key,
)
from tests.telemetry.conftest import free_port, wait_until
from tests.telemetry.test_listen_only import ask_for_logs

WORDS = "the crew of the B777"
KEY = sha256(WORDS.encode()).digest()
NOW = 1_760_000_000_000_000


class Signer:
    """pymavlink as a sender in this process, whose clock is that of the test."""

    def __init__(self, key: bytes | None = KEY, host_us: int = NOW, link: int = 0) -> None:
        self._mavlink = dialect().MAVLink(None, srcSystem=1, srcComponent=1)
        if key is not None:
            signing = self._mavlink.signing
            signing.secret_key, signing.sign_outgoing = key, True
            signing.timestamp, signing.link_id = signature_time(host_us), link

    def __call__(self) -> bytes:
        message = dialect().MAVLink_attitude_message(0, 0.1, 0.0, 0.0, 0.0, 0.0, 0.0)
        return bytes(message.pack(self._mavlink))


def test_frames_of_pymavlink_are_judged() -> None:
    verifier, signer = SignatureVerifier(KEY, NOW), Signer()
    first, second = signer(), signer()
    assert [verifier.verify(frame) for frame in (first, second)] == ["valid", "valid"]
    assert verifier.verify(second) == verifier.verify(first) == "replayed"
    assert verifier.verify(Signer(derive_key("another"), NOW + 1_000_000)()) == "false"
    assert verifier.verify(Signer(None)()) == "unsigned"
    damaged = bytearray(signer())
    damaged[-1] ^= 1
    assert verifier.verify(bytes(damaged)) == "false"
    assert verifier.verify(signer()) == "valid"


@pytest.mark.parametrize(("age", "found"), [(59.0, "valid"), (61.0, "replayed")])
def test_a_new_stream_is_at_most_a_minute_old(age: float, found: str) -> None:
    verifier = SignatureVerifier(KEY, NOW)
    assert verifier.verify(Signer(host_us=NOW - round(age * 1e6))()) == found


def test_every_link_of_a_sender_has_its_own_time() -> None:
    verifier = SignatureVerifier(KEY, NOW)
    later, earlier = Signer(host_us=NOW + 5_000_000, link=1), Signer(link=2)
    assert [verifier.verify(each()) for each in (later, earlier, later, earlier)] == ["valid"] * 4


def test_a_forged_time_stamp_does_not_silence_the_aircraft() -> None:
    verifier, signer = SignatureVerifier(KEY, NOW), Signer()
    assert verifier.verify(signer()) == "valid"
    assert verifier.verify(Signer(bytes(32), NOW + 10**12)()) == "false"
    assert verifier.verify(signer()) == "valid"


def test_what_is_sent_is_signed_with_rising_time_stamps() -> None:
    """Pymavlink checks it, also where the clock of the aircraft is ahead of this computer's."""
    verifier = SignatureVerifier(KEY, NOW)
    ahead = Signer(host_us=NOW + 3_600_000_000)
    assert verifier.verify(ahead()) == "valid"
    packer = GroundPacker(verifier)
    aircraft = dialect().MAVLink(None)
    aircraft.signing.secret_key = KEY
    aircraft.signing.timestamp = signature_time(NOW + 3_600_000_000)
    for _ in range(3):  # in one moment
        message = aircraft.decode(bytearray(packer.pack_heartbeat(NOW)))
        assert (message.get_type(), message.get_srcSystem()) == ("HEARTBEAT", 255)


@pytest.fixture
def key_file(tmp_path: Path) -> Path:
    path = tmp_path / "home" / "signing.key"
    write_signing_key(path, KEY)
    return path


class Field:
    """A recorder with a key, and signers of pymavlink as processes."""

    def __init__(self, folder: Path, key: Path) -> None:
        self.folder = folder / "flight"
        self.heard = folder / "heard"
        self.port = free_port(socket.SOCK_DGRAM)
        self.recorder: RecorderHandle = start_recorder(
            f"udpin:127.0.0.1:{self.port}", self.folder, heartbeat=True, signing_key=str(key)
        )
        self.signers: list[subprocess.Popen[bytes]] = []

    def signer(self, key: bytes = KEY, ahead: float = 0.0) -> subprocess.Popen[bytes]:
        script = Path(__file__).with_name("foreign_signer.py")
        command = [sys.executable, str(script), str(self.port), str(self.heard), str(ahead)]
        self.signers.append(subprocess.Popen([*command, key.hex()]))
        return self.signers[-1]

    def signatures(self) -> dict[str, int]:
        status = self.recorder.status()
        return {} if status is None else status.signatures

    def types_heard(self) -> list[str]:
        return self.heard.read_text().split() if self.heard.exists() else []

    def close(self) -> None:
        for signer in self.signers:
            signer.kill()
            signer.wait()
        self.recorder.stop()


@pytest.fixture
def field(tmp_path: Path, key_file: Path) -> Iterator[Field]:
    found = Field(tmp_path, key_file)
    yield found
    found.close()


def test_signed_frames_of_pymavlink_are_valid_and_ours_valid_there(field: Field) -> None:
    field.signer()
    wait_until(lambda: field.signatures().get("valid", 0) > 20)
    wait_until(lambda: "HEARTBEAT" in field.types_heard())
    ask_for_logs(field.folder)
    wait_until(lambda: "LOG_REQUEST_LIST" in field.types_heard())
    assert set(field.signatures()) == {"valid"}
    assert set(field.types_heard()) == {"HEARTBEAT", "LOG_REQUEST_LIST"}


@pytest.mark.parametrize(
    ("key", "ahead", "state"),
    [(b"", 0.0, "unsigned"), (bytes(32), 0.0, "false"), (KEY, -120.0, "replayed")],
)
def test_other_frames_are_counted_announced_and_not_decoded(
    field: Field, key: bytes, ahead: float, state: str
) -> None:
    field.signer(key, ahead)
    session = Session.follow(field.folder, channel_map="ardupilot-plane", cues=False)
    deadline = time.monotonic() + 20.0
    while session.alarm_registry.severity("stranger") is not Severity.WARNING:
        assert time.monotonic() < deadline
        session.update()
        time.sleep(0.01)
    report = session.link_report()
    assert report is not None
    assert {one.reason for one in report.rejected} == {state}
    assert report.vehicles == ()
    session.close()
    wait_until(lambda: set(field.signatures()) == {state})
    status = field.recorder.status()
    assert status is not None
    assert len(status.warnings) == 1
    assert len(RawTail(field.folder).poll()) > 0  # all the same recorded


def test_neither_key_nor_its_path_is_in_a_file_of_the_flight(field: Field, key_file: Path) -> None:
    field.signer()
    wait_until(lambda: field.signatures().get("valid", 0) > 20)
    field.close()
    forms = (KEY, KEY.hex().encode(), WORDS.encode(), str(key_file).encode())
    for path in field.folder.rglob("*"):
        content = path.read_bytes() if path.is_file() else b""
        assert not any(form in content for form in forms), path


@pytest.mark.parametrize(
    ("content", "key"),
    [
        (KEY, KEY),
        (KEY.hex().encode() + b"\n", KEY),
        (WORDS.encode() + b"\r\n", KEY),
        (b"x" * 32, sha256(b"x" * 32).digest()),
        (b"g" * 64, sha256(b"g" * 64).digest()),
    ],
)
def test_forms_of_a_key_file(content: bytes, key: bytes, tmp_path: Path) -> None:
    path = tmp_path / "key"
    path.write_bytes(content)
    path.chmod(0o600)
    assert read_signing_key(path) == key


@pytest.mark.parametrize("content", [b"", b"\n", b"two\nlines", bytes(31), b"\xff" * 33])
def test_what_is_no_key_is_refused(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "key"
    path.write_bytes(content)
    path.chmod(0o600)
    with pytest.raises(LinkError):
        read_signing_key(path)


@pytest.mark.skipif(sys.platform == "win32", reason="modes of files are those of POSIX")
@pytest.mark.parametrize("mode", [0o640, 0o604, 0o660])
def test_a_key_that_others_may_read_is_refused(key_file: Path, mode: int) -> None:
    assert key_file.stat().st_mode & 0o777 == 0o600
    key_file.chmod(mode)
    with pytest.raises(LinkError):
        read_signing_key(key_file)


def test_a_key_in_a_flight_folder_is_refused(key_file: Path) -> None:
    (key_file.parent / "raw.tlog").touch()
    with pytest.raises(LinkError):
        read_signing_key(key_file)
