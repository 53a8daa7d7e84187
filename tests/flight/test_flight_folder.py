"""Flight folders: what they hold, the sums of their files, and looks at a record that grows."""

import errno
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from calibration import certificate_paths, load_certificates
from gsapp.aircraft.aircraft_loader import SHIPPED_AIRCRAFT
from gsapp.decoding.framing import LineFramer
from gsapp.flight.atomic_files import atomic_flight_folder
from gsapp.flight.folder import FlightFolder, is_flight_folder
from gsapp.flight.info import FlightInfo, Weather
from gsapp.flight.provenance import find_changed_parts, hash_input_file
from gsapp.flight.raw_files import LINES_FILE, RESIDUE_FILE, RawTail, RawWriter
from gsapp.foundation import FileProblemsError, FlightError


def test_new_folder_states_date_and_versions(tmp_path):
    folder = FlightFolder.create(tmp_path / "deep" / "one")
    info = folder.info()
    assert info.name == "one"
    assert info.date.tzinfo is not None
    assert {"python", "numpy", "pymavlink"} <= set(info.versions)
    assert is_flight_folder(folder.path)
    assert FlightFolder.open(folder.path) == folder


def test_facts_come_back(tmp_path):
    """Every fact survives the file, to the last bit; empty ones are not written."""
    info = FlightInfo.model_validate(
        {
            "name": "Race track 3",
            "date": "2026-05-12T09:30:00+02:00",
            "aircraft": "b777",
            "takeoff_weight": "46.7 lb",
            "landing_weight": "44.1 lbf",
            "fuel": "2.1 lb",
            "weather": {
                "temperature": "71 degF",
                "pressure": "28.9 inHg",
                "wind_speed": "6 kt",
                "wind_from": "240 deg",
                "remarks": "gusts after ten",
            },
            "crew": {"pilot": "R. Roe", "engineer": "J. Doe"},
            "notes": "two\nlines",
            "pilot_comments": 'felt "loose" in yaw',
            "grid_rate": "50 Hz",
        }
    )
    folder = FlightFolder.create(tmp_path / "f", info)
    back = folder.info()
    assert back.model_dump(exclude={"versions"}) == info.model_dump(exclude={"versions"})
    assert back.takeoff_weight == pytest.approx(46.7 * 4.4482216152605)
    assert "channel_map" not in folder.info_file.read_text()
    assert back.weather != Weather()


def test_update_keeps_comments_and_refuses_nonsense(tmp_path):
    folder = FlightFolder.create(tmp_path / "f")
    # Tables come last in TOML, so the hand-written line goes first.
    head, _, versions = folder.info_file.read_text().partition("[versions]")
    text = f'{head}\n# scale in hangar 2\ntakeoff_weight = "46.7 lb"\n[versions]{versions}'
    folder.info_file.write_text(text)
    info = folder.update_info(landing_weight="44.1 lb", notes="landed long")
    after = folder.info_file.read_text()
    assert "# scale in hangar 2" in after
    assert '"46.7 lb"' in after
    assert info.landing_weight == pytest.approx(44.1 * 4.4482216152605)
    assert folder.info() == info
    with pytest.raises(FileProblemsError, match="landing_weight"):
        folder.update_info(landing_weight="44 ft")
    assert folder.info_file.read_text() == after
    folder.update_info(landing_weight=None)
    assert folder.info().landing_weight is None


def test_every_mistake_of_flight_toml_is_named(tmp_path):
    """Unknown keys, wrong units and a log outside the folder are told at once, with remedies."""
    folder = FlightFolder.create(tmp_path / "f")
    folder.info_file.write_text(
        'takeof_weight = "3 lb"\nlanding_weight = "3 ft"\nonboard_log = "../x.bin"\n'
    )
    with pytest.raises(FileProblemsError) as caught:
        folder.info()
    text = str(caught.value)
    for part in ("3 problems", "takeoff_weight", "not a unit of weight", "plain file name"):
        assert part in text


def test_going_on_in_the_same_flight(tmp_path):
    first = FlightFolder.create(tmp_path / "f", FlightInfo(notes="first"))
    again = FlightFolder.create(tmp_path / "f", FlightInfo(notes="second"))
    assert again.info().notes == first.info().notes == "first"
    (tmp_path / "bare").mkdir()
    (tmp_path / "bare" / "raw.tlog").write_bytes(b"")
    assert FlightFolder.open(tmp_path / "bare").info() is None
    assert FlightFolder.create(tmp_path / "bare").info() is not None
    (tmp_path / "begun").mkdir()
    (tmp_path / "begun" / "recorder.lock").write_bytes(b"")
    assert FlightFolder.create(tmp_path / "begun").info() is not None


def test_copies_of_the_files_in_force(tmp_path):
    folder = FlightFolder.create(tmp_path / "f")
    folder.store_aircraft(SHIPPED_AIRCRAFT.find("b777"))
    assert folder.aircraft() is not None
    assert folder.aircraft_file.read_bytes() == SHIPPED_AIRCRAFT.find("b777").read_bytes()
    for name in ("alpha", "beta"):
        (tmp_path / f"{name}.toml").write_text(f"# {name}\n")
    folder.store_certificates([tmp_path / "alpha.toml", tmp_path / "beta.toml"])
    folder.store_certificates([tmp_path / "beta.toml"])
    assert [path.name for path in folder.certificate_files()] == ["beta.toml"]
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "beta.toml").write_text("")
    with pytest.raises(FlightError, match="same file name"):
        folder.store_certificates([tmp_path / "beta.toml", tmp_path / "sub" / "beta.toml"])
    with pytest.raises(FlightError, match="cannot be copied"):
        folder.store_aircraft(tmp_path / "none.toml")


def test_onboard_log_is_copied_and_named(tmp_path):
    folder = FlightFolder.create(tmp_path / "f")
    assert folder.onboard_log() is None
    (tmp_path / "00000001.BIN").write_bytes(b"log")
    folder.store_onboard_log(tmp_path / "00000001.BIN")
    assert folder.onboard_log().read_bytes() == b"log"
    folder.onboard_log().unlink()
    with pytest.raises(FlightError, match=r"00000001\.BIN"):
        folder.onboard_log()


@pytest.mark.parametrize("action", [FlightFolder.create, FlightFolder.open])
def test_a_file_in_the_place_of_the_folder(tmp_path, action):
    (tmp_path / "f").write_text("x")
    with pytest.raises(FlightError, match="f is a file"):
        action(tmp_path / "f")


def test_folders_of_other_things(tmp_path):
    with pytest.raises(FlightError, match="no flight folder"):
        FlightFolder.open(tmp_path / "none")
    (tmp_path / "photos").mkdir()
    (tmp_path / "photos" / "a.jpg").write_text("x")
    with pytest.raises(FlightError, match="not a flight"):
        FlightFolder.open(tmp_path / "photos")
    with pytest.raises(FlightError, match="holds other files"):
        FlightFolder.create(tmp_path / "photos")
    assert (tmp_path / "photos" / "a.jpg").read_text() == "x"


UNPRIVILEGED = """
import fcntl, os, sys
from pathlib import Path
from gsapp.flight.folder import FlightFolder
from gsapp.flight.events import Event, EventLog
from gsapp.foundation import FlightError
if os.getuid() == 0:
    os.setgid(65534); os.setuid(65534)
place = Path(sys.argv[1])
for action, name in [(FlightFolder.open, "closed"), (FlightFolder.create, "fixed"),
                     (FlightFolder.create, "new")]:
    try:
        action(place / name)
    except FlightError as error:
        print(error)
try:
    FlightFolder.open(place / "fixed").events.append(Event(kind="mark"))
except FlightError as error:
    print(error)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="permissions of POSIX")
def test_a_folder_without_rights():
    """Unreadable and unwritable folders are told as such, by a process without privileges."""
    with tempfile.TemporaryDirectory() as name:
        path = Path(name)
        FlightFolder.create(path / "closed")
        FlightFolder.create(path / "fixed")
        try:
            (path / "closed").chmod(0o000)
            (path / "fixed").chmod(0o555)
            path.chmod(0o555)
            done = subprocess.run(
                [sys.executable, "-c", UNPRIVILEGED, name],
                capture_output=True,
                text=True,
                timeout=240,
            )
        finally:
            for folder in (path, path / "closed", path / "fixed"):
                folder.chmod(0o755)
    lines = done.stdout.splitlines()
    assert len(lines) == 4, done.stderr
    assert "cannot be read" in lines[0]
    assert "written" in lines[1]
    assert "cannot be made" in lines[2]
    assert "cannot be written" in lines[3]


def test_a_flight_that_was_on_a_mac_is_the_same_flight(tmp_path):
    (tmp_path / "new").mkdir()
    (tmp_path / "new" / ".DS_Store").touch()
    folder = FlightFolder.create(tmp_path / "new", FlightInfo())
    folder.store_certificates(certificate_paths("b777"))
    before = (hash_input_file("flight", folder.path).sha256, len(folder.certificate_files()))
    for path in [one for one in folder.path.rglob("*") if one.is_file()]:
        path.with_name(f"._{path.name}").write_bytes(b"\x00\x05\x16\x07 not text: \xff")
    flight = FlightFolder.open(folder.path)
    assert len(load_certificates(folder.path)) == before[1] > 0
    assert (
        hash_input_file("flight", flight.path).sha256,
        len(flight.certificate_files()),
    ) == before


def test_a_disk_that_fills_while_a_flight_is_made_is_told_with_the_flight(tmp_path: Path) -> None:
    folder = tmp_path / "flight"

    def fill(error: OSError) -> None:
        with atomic_flight_folder(folder) as part:
            (part / "raw.tlog").write_bytes(b"half")
            raise error

    with pytest.raises(FlightError, match="free disk space"):
        fill(OSError(errno.ENOSPC, "No space left on device"))
    assert list(tmp_path.iterdir()) == []
    # What is no matter of the disk stays what it was.
    with pytest.raises(ConnectionResetError):
        fill(ConnectionResetError())


def made_folder(folder: Path) -> Path:
    (folder / "calibration").mkdir(parents=True)
    (folder / "cache").mkdir()
    for name, text in (
        ("raw.tlog", "frames"),
        ("calibration/alpha.toml", "volts"),
        ("cache/engineering.npz", "made"),
        ("events.jsonl", "a mark"),
    ):
        (folder / name).write_text(text, encoding="utf-8")
    return folder


def test_of_a_folder_each_file_is_named(tmp_path: Path) -> None:
    folder = made_folder(tmp_path / "a")
    before = hash_input_file("flight", folder, name="a")
    assert sorted(before.parts) == ["calibration/alpha.toml", "events.jsonl", "raw.tlog"]
    (folder / "cache/engineering.npz").write_text("made again", encoding="utf-8")
    assert hash_input_file("flight", folder, name="a") == before
    (folder / "events.jsonl").write_text("another mark", encoding="utf-8")
    marked = hash_input_file("flight", folder, name="a")
    assert marked.sha256 != before.sha256
    assert find_changed_parts(before, marked) == ()
    (folder / "calibration/alpha.toml").write_text("others", encoding="utf-8")
    (folder / "onboard.bin").write_bytes(b"log")
    assert find_changed_parts(before, hash_input_file("flight", folder, name="a")) == (
        "a/calibration/alpha.toml",
        "a/onboard.bin",
    )
    # The same content in another order of directories is the same.
    assert hash_input_file("x", made_folder(tmp_path / "b")).sha256 == before.sha256


def test_a_file_is_its_bytes(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_bytes(b"abc")
    before = hash_input_file("flight", path)
    # Of FIPS 180-2.
    assert before.sha256 == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
    assert before.name == str(path)
    path.write_bytes(b"abd")
    assert find_changed_parts(before, hash_input_file("flight", path)) == (str(path),)


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
