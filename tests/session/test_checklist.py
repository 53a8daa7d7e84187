"""The checklist: rules on a real record of the virtual aircraft on the ground, and live."""

import socket
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from calibration import load_certificates
from calibration.validity import CalibrationInForce
from gsapp.aircraft import load_aircraft
from gsapp.flight.events import EventLog, read_events
from gsapp.flight.flight_loader import load_flight
from gsapp.flight.folder import FlightFolder
from gsapp.flight.folder_setup import prepare_flight_folder
from gsapp.flight.info import FlightInfo
from gsapp.flight.raw_files import FRAMES_FILE, read_tlog
from gsapp.foundation import FileProblemsError, UnknownNameError
from gsapp.foundation.toml import validate_content
from gsapp.quantities import Block
from gsapp.quantities.constants import DEGREE
from gsapp.session import ChannelState, Freshness, Session
from gsapp.session.checklist import (
    Checklist,
    ChecklistContext,
    ChecklistFile,
    EvaluatedItem,
    SessionChecklist,
    load_checklist,
    shipped_checklists,
)
from gsapp.session.checklist.session_checklist import FLIGHT_START_EVENT, PendingChecklist
from gsapp.session.replay_runner import run_replay
from gsapp.virtual.downlink.flight_settings import FlightSettings
from gsapp.virtual.downlink.onboard_log import OnboardLog

GROUND = """
name = "ground"
[engines]
start = "0.5 s"
running = "60 s"
[[engines.run_ups]]
at = "1 s"
throttle = 0.5
[[engines.run_ups]]
at = "4 s"
throttle = 1.0
[[engines.run_ups]]
at = "7 s"
throttle = 0.0
[range_check]
at = "7 s"
pulses = ["de", "da", "dr"]
shape = "doublet"
duration = "0.7 s"
"""
"""Half, full, idle; then both sides of every surface, as a pilot does it."""
STANDS = 14.0
A_SECOND = 258.0
"""Frames that the aircraft sends."""

TELEMETRY = (
    "recorder_battery", "excitation", "receiver_signal", "gyros", "sensors",
    "elevator", "aileron", "rudder", "range_check", "engines_idle", "engines_mid", "engines_full",
)  # fmt: skip
"""Items of the shipped list that a record tells."""


@pytest.fixture(scope="module")
def ground(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("ground")
    (place / "plan.toml").write_text(GROUND)
    settings = FlightSettings(plan=str(place / "plan.toml"), seed=3)
    folder = prepare_flight_folder(place / "flight", aircraft="b777", channel_map="b777")
    log = OnboardLog(folder.tlog_file)
    box = settings.create_downlink(1_778_000_000_000_000)
    flown = 0.0
    while flown < STANDS:
        for packet in box.advance(100):
            log.append(packet.stamp_us + 12_000, packet.live_frames)
            flown = packet.time
    log.close()
    return folder.path


@pytest.fixture(scope="module")
def measured(ground: Path) -> Block:
    return load_flight(ground).block


def rules(*rows: dict[str, Any]) -> Checklist:
    items = [{"id": f"i{k}", "words": "x", "rule": row} for k, row in enumerate(rows)]
    return Checklist(validate_content("list.toml", {"items": items}, ChecklistFile))


def by_id(items: Sequence[EvaluatedItem]) -> dict[str, EvaluatedItem]:
    return {item.id: item for item in items}


def facts_for(checklist: Checklist, **changes: Any) -> ChecklistContext:
    states = {
        name: ChannelState(channel=name, freshness=Freshness.FRESH)
        for name in checklist.required_channels
    }
    for name, change in changes.items():
        states[name] = replace(states[name], **change)
    return ChecklistContext(states=states)


def judged(
    checklist: Checklist, block: Block, facts: ChecklistContext | None = None
) -> EvaluatedItem:
    names = [name for name in checklist.required_channels if name in block]
    checklist.feed(block.select(names))
    (item,) = checklist.evaluate(facts or facts_for(checklist))
    return item


def changed(block: Block, **columns: np.ndarray) -> Block:
    values = np.array(block.values)
    for name, samples in columns.items():
        values[:, block.channels.index(name)] = samples
    return Block(channels=block.channels, times=block.times, values=values)


# The file


def test_shipped_lists_load_and_what_they_watch_exists() -> None:
    assert "b777" in shipped_checklists()
    for name in shipped_checklists():
        found = load_checklist(name)
        assert {item.checked_by for item in found.items} == {"hand", "telemetry"}


def test_all_mistakes_of_a_list_are_told_at_once(tmp_path: Path) -> None:
    """Unknown rules, channels, units, keys, ids given twice: one pass with key paths."""
    path = tmp_path / "list.toml"
    path.write_text(
        """
[[items]]
id = "a"
words = "Battery"
rule = { kind = "within", channel = "batery", low = "11 V" }
[[items]]
id = "a"
words = "Battery"
rule = { kind = "within", channel = "battery", low = "11 V", low_red = "12 V" }
[[items]]
id = "c"
words = "Battery"
rule = { kind = "within", channel = "battery", low = "11 ft" }
[[items]]
id = "d"
word = "Magic"
rule = { kind = "magic" }
[[items]]
id = "e"
words = "Engines"
rule = { kind = "engines", low = "9000 rpm", high = "6000 rpm" }
"""
    )
    with pytest.raises(FileProblemsError) as caught:
        load_checklist(path)
    text = str(caught.value)
    for part in (
        "no channel is called 'batery'; did you mean 'battery",
        "low_red, low, high and high_red must grow",
        "'ft' is not a unit of voltage",
        "'within', 'link', 'recorder'",
        "items[3].words: is missing",
        "low must lie below high",
        "items: the id 'a' is given 2 times",
    ):
        assert part in text


# A record of the virtual aircraft


def test_a_sound_aircraft_is_green_after_its_run_up(ground: Path) -> None:
    """The shipped list on the virtual aircraft's own record: all that a record tells is green.

    What only a live flight has stays open, and what the box does not measure is left to hands.
    """
    session = Session.replay(ground, speed=float("inf"))
    going = SessionChecklist(session, load_checklist("b777"))
    before = by_id(going.update())
    assert before["engines_full"].state == "open"
    run_replay(session)
    for _ in range(5):
        items = going.update()
    found = by_id(items)
    assert {name: found[name].state for name in TELEMETRY} == dict.fromkeys(TELEMETRY, "green"), {
        name: found[name].why for name in TELEMETRY
    }
    assert "12.6 V" in found["recorder_battery"].why or "12.5" in found["recorder_battery"].why
    assert found["link"].state == found["recorder"].state == "open"
    # Its certificates are the examples that ship, as bar and step say, too.
    assert found["calibrated"].state == "amber"
    assert session.snapshot().calibration_status.state == "caution"
    assert session.snapshot().calibration_status.detail in found["calibrated"].why
    assert found["receiver_battery"].state == "amber"
    assert found["receiver_battery"].can_tick
    order = ["red", "amber", "open", "green"]
    assert [item.state for item in items] == sorted((item.state for item in items), key=order.index)
    session.close()


def test_it_does_not_matter_how_samples_are_cut(measured: Block) -> None:
    """Blocks of 29, of 400 and of all samples give the same words."""
    said = []
    for size in (29, 400, len(measured)):
        checklist = Checklist(load_checklist("b777"))
        names = [name for name in checklist.required_channels if name in measured]
        chosen = measured.select(names)
        for first in range(0, len(chosen), size):
            checklist.feed(
                Block(
                    channels=chosen.channels,
                    times=chosen.times[first : first + size],
                    values=chosen.values[first : first + size],
                )
            )
        said.append([(item.id, item.state, item.why) for item in checklist.evaluate(
            facts_for(checklist))])  # fmt: skip
    assert said[0] == said[1] == said[2]


ELEVATOR = {
    "kind": "follows", "stick": "stick_pitch", "surface": "de", "sign": -1, "surface_reach": "8 deg"
}  # fmt: skip


def test_surfaces_are_seen_to_follow_and_faults_are_named(measured: Block) -> None:
    """Right, reversed, stuck, weak, and right again once mended; half a stick is not enough."""
    elevator = measured["de"]
    assert judged(rules(ELEVATOR), measured).state == "green"
    reversed_ = judged(rules(ELEVATOR), changed(measured, de=-elevator))
    assert reversed_.state == "red"
    assert "wrong direction" in reversed_.why
    stuck = judged(rules(ELEVATOR), changed(measured, de=np.full(len(measured), 0.5 * DEGREE)))
    assert (stuck.state, "hardly moves" in stuck.why) == ("red", True)
    weak = judged(rules(ELEVATOR), changed(measured, de=0.3 * elevator))
    assert (weak.state, "8.0 deg required" in weak.why) == ("red", True)
    timid = judged(rules(ELEVATOR), changed(measured, stick_pitch=0.5 * measured["stick_pitch"]))
    assert (timid.state, "pitch stick" in timid.why) == ("open", True)
    mended = rules(ELEVATOR)
    assert judged(mended, changed(measured, de=-elevator)).state == "red"
    later = Block(channels=measured.channels, times=measured.times + 60.0, values=measured.values)
    assert judged(mended, later).state == "green"
    # An elevator that the trim lever holds off its middle follows as well.
    assert judged(rules(ELEVATOR), changed(measured, de=elevator + 3.0 * DEGREE)).state == "green"


RPM = np.pi / 30.0
IDLE = {
    "kind": "engines", "low": "6000 rpm", "high": "8500 rpm", "apart": "800 rpm",
    "duration": "3 s", "throttle": ["-5 %", "5 %"],
}  # fmt: skip


def test_engines_within_bounds_left_and_right(measured: Block) -> None:
    left = measured["rpm_left"]
    assert judged(rules(IDLE), measured).state == "green"
    hung = judged(rules(IDLE), changed(measured, rpm_left=left + 3000.0 * RPM))
    assert hung.state == "red"
    assert "left engine speed" in hung.why
    assert "above 8500 rpm" in hung.why
    dead = judged(rules(IDLE), changed(measured, rpm_left=np.zeros(len(measured))))
    assert (dead.state, "0 rpm, below 6000 rpm" in dead.why) == ("red", True)
    apart = judged(rules(IDLE), changed(measured, rpm_left=left + 900.0 * RPM))
    assert (apart.state, "apart, 800 rpm allowed" in apart.why) == ("red", True)
    still = np.zeros(len(measured))
    off = judged(rules(IDLE), changed(measured, rpm_left=still, rpm_right=still))
    assert (off.state, off.why) == ("open", "the engines are off")
    running_up = measured.between(2.5, 6.5)
    assert judged(rules(IDLE), running_up).state == "open"
    # Without a throttle in the telemetry the bounds alone tell.
    bare = measured.select(["rpm_left", "rpm_right"])
    checklist = rules(IDLE)
    present = {
        name: state for name, state in facts_for(checklist).states.items() if name != "throttle"
    }
    assert judged(checklist, bare, ChecklistContext(states=present)).state == "green"


def test_pulses_of_the_range_check_are_counted(measured: Block) -> None:
    row = {"kind": "pulses", "channels": ["de", "da", "dr"], "size": "8 deg", "count": 6}
    seen = judged(rules(row), measured)
    assert seen.state == "green"
    assert "2 of the rudder" in seen.why
    before = judged(rules(row), measured.between(0.0, 7.0))
    assert (before.state, "0 of 6 pulses" in before.why) == ("open", True)
    small = judged(
        rules(row), changed(measured, **{name: 0.3 * measured[name] for name in ("de", "da", "dr")})
    )
    assert small.state == "open"
    times = np.arange(0.0, 30.0, 0.01)
    moved = np.where(times > 5.0, 12.0 * DEGREE, 0.0)
    held = Block(channels=("dr",), times=times, values=moved[:, None])
    one = {"kind": "pulses", "channels": ["dr"], "size": "8 deg"}
    assert judged(rules(one), held).state == "open"


def test_batteries_and_sensors(measured: Block) -> None:
    """Amber and red bands, a gyro that is stuck, at its end, silent, implausible or not carried."""
    battery = {"kind": "within", "channel": "battery", "low": "11.4 V", "low_red": "11.0 V"}
    assert judged(rules(battery), measured).state == "green"
    volts = np.ones(len(measured))
    low = judged(rules(battery), changed(measured, battery=11.2 * volts))
    assert (low.state, low.why) == ("amber", "11.20 V, below 11.40 V")
    empty = judged(rules(battery), changed(measured, battery=10.2 * volts))
    assert (empty.state, empty.why) == ("red", "10.20 V, below 11.00 V")
    # It recovered half a second ago: not yet.
    recovering = np.where(measured.times > measured.times[-1] - 0.5, 12.0, 11.0)
    assert judged(rules(battery), changed(measured, battery=recovering)).state == "open"

    air = {"kind": "within", "channel": "temperature", "low": "-10 degC", "high": "20 degC"}
    hot = changed(measured, temperature=303.15 * volts)
    assert judged(rules(air), hot).why == "86 degF, above 68 degF"
    assert (
        judged(rules(air), hot, replace(facts_for(rules(air)), system="SI")).why
        == "30 degC, above 20 degC"
    )

    gyros = {"kind": "alive", "channels": ["p", "q", "r"], "moving": True}
    assert judged(rules(gyros), measured).state == "green"
    stuck = judged(rules(gyros), changed(measured, q=0.01 * volts))
    assert (stuck.state, "pitch rate stuck at" in stuck.why) == ("red", True)
    wild = judged(rules(gyros), changed(measured, r=1e3 * volts))
    assert (wild.state, "implausible" in wild.why) == ("red", True)
    for change, word in (
        ({"clipped": True}, "at the end of its range"),
        ({"freshness": Freshness.STALE, "age": 4.0}, "silent for 4 s"),
    ):
        checklist = rules(gyros)
        found = judged(checklist, measured, facts_for(checklist, q=change))
        assert found.state == "red"
        assert word in found.why
    checklist = rules(gyros)
    states = dict(facts_for(checklist).states)
    del states["r"]
    absent = judged(checklist, measured, ChecklistContext(states=states))
    assert (absent.state, absent.can_tick) == ("amber", True)
    checklist.tick("i0", "J. Doe")
    (ticked,) = checklist.evaluate(ChecklistContext(states=states))
    assert (ticked.state, ticked.checked_by) == ("green", "hand")
    assert ticked.why.startswith("ticked by J. Doe")


def test_certificates_in_force_and_their_age() -> None:
    row = {"kind": "calibrated", "channels": ["alpha", "rudder"], "age": "18 h"}
    noon = datetime(2026, 5, 12, 12, 0, tzinfo=UTC)
    shipped = load_certificates("b777")

    def item_of(lacking: Sequence[str] = (), **hours: float) -> EvaluatedItem:
        certificates = {
            name: replace(shipped[name], who="crew", stamp=noon - timedelta(hours=age))
            for name, age in hours.items()
        }
        in_force = CalibrationInForce(certificates=certificates, flight_date=noon, missing=lacking)
        (item,) = rules(row).evaluate(ChecklistContext(calibration=in_force))
        return item

    assert item_of(alpha=2.5, rudder=0.2).state == "green"
    old = item_of(alpha=0.1, rudder=30.0)
    assert (old.state, "Rudder surface" in old.why) == ("amber", True)
    # The check is the crew's: what holds is ticked, and the item is green.
    assert old.can_tick
    assert not item_of(rudder=1.0).can_tick
    assert item_of(["rudder"], alpha=1.0).state == "red"
    assert item_of().state == "amber"
    assert rules(row).evaluate(ChecklistContext())[0].state == "open"


def test_the_flight_card_is_looked_at() -> None:
    checklist = rules({"kind": "card", "fields": ["takeoff_weight", "weather.temperature"]})
    (none,) = checklist.evaluate(ChecklistContext())
    (empty,) = checklist.evaluate(ChecklistContext(card=FlightInfo()))
    assert none.state == empty.state == "open"
    assert all(name in empty.why for name in ("takeoff weight", "temperature"))
    card = FlightInfo.model_validate(
        {"takeoff_weight": "46 lb", "weather": {"temperature": "15 degC"}}
    )
    assert checklist.evaluate(ChecklistContext(card=card))[0].state == "green"
    assert (
        checklist.evaluate(ChecklistContext(card=card, card_issues=("a slip",)))[0].state == "amber"
    )


# Live

LIVE = """
[[items]]
id = "airframe"
words = "Hatches closed"
[[items]]
id = "vanes"
words = "Vane covers off"
[[items]]
id = "link"
words = "Telemetry"
rule = { kind = "link", age = "0.5 s" }
[[items]]
id = "recorder"
words = "Recorder writes"
rule = { kind = "recorder" }
[[items]]
id = "space"
words = "Room on the disk"
rule = { kind = "space", time = "1 min", time_red = "1 s", gigabytes = 0.001 }
[[items]]
id = "excitation"
words = "Supply of the potentiometers"
rule = { kind = "within", channel = "excitation", low = "4.7 V", high = "5.3 V" }
[[items]]
id = "weak"
words = "Battery of another aircraft"
rule = { kind = "within", channel = "battery", low = "20 V" }
"""


def test_a_live_flight_is_checked_and_started_all_the_same(
    field: Any, ground: Path, patience: Callable[..., None], tmp_path: Path
) -> None:
    """A recorder, a link and the record's frames: equipment goes green, red when it stops.

    Ticks and the start with what was not green stand in events.jsonl; a window that comes later
    knows them.
    """
    (tmp_path / "list.toml").write_text(LIVE)
    file = load_checklist(tmp_path / "list.toml")
    field.record()
    session = Session.follow(field.folder, channel_map="b777", aircraft="b777")
    going = SessionChecklist(session, file)
    assert by_id(going.update())["link"].state == "open"
    frames = (record.data for record in read_tlog(ground / FRAMES_FILE))
    out = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    begun, sent = time.monotonic(), 0

    def send() -> None:
        nonlocal sent
        due = int((time.monotonic() - begun) * A_SECOND) - sent
        for frame in islice(frames, due):
            out.sendto(frame, ("127.0.0.1", field.port))
            sent += 1

    def state_of(item: str, state: str, *, sending: bool = True) -> Callable[[], bool]:
        def come() -> bool:
            if sending:
                send()
            session.update()
            return by_id(going.update())[item].state == state

        return come

    for item in ("recorder", "link", "space", "excitation"):
        patience(state_of(item, "green"))
    going.tick("airframe", "J. Doe")
    with pytest.raises(UnknownNameError, match="no item 'airfame'"):
        going.tick("airfame")
    going.tick("vanes")
    going.untick("vanes")
    patience(state_of("weak", "red"))
    started = going.start("R. Roe")
    assert "Battery of another aircraft (red: 1" in started.text
    assert started.data["red"] == ["weak"]
    assert "airframe" in started.data["green"]
    assert "vanes" in started.data["open"]
    kept = read_events(FlightFolder(path=field.folder).events.path).events
    assert [event.kind for event in kept if event.kind.startswith("checklist")] == [
        "checklist-tick",
        "checklist-tick",
        "checklist-untick",
    ]
    assert [event.data["who"] for event in kept if event.kind == FLIGHT_START_EVENT] == ["R. Roe"]
    later = SessionChecklist(
        Session.follow(field.folder, channel_map="b777", aircraft="b777"), file
    )
    found = by_id(later.update())
    assert (found["airframe"].why, found["vanes"].state) == ("ticked by J. Doe", "open")
    assert later.start_event is not None

    def seen() -> bool:
        send()
        later.session.update()
        return by_id(later.update())["excitation"].state == "green"

    # What was seen before the start it sees as well.
    patience(seen)
    later.restart()
    assert by_id(later.update())["airframe"].state == "open"
    assert by_id(going.update())["airframe"].state == "open"
    assert going.start_event is None
    # Nothing comes any more.
    patience(state_of("link", "red", sending=False))
    out.close()
    going.session.close()
    later.session.close()


def begin(folder: Path, card: FlightInfo | None = None) -> PendingChecklist:
    return PendingChecklist(
        EventLog(folder / "next" / "events.jsonl"),
        load_checklist("b777"),
        card=lambda: card,
        aircraft=load_aircraft("b777"),
    )


def states(checklist: PendingChecklist) -> dict[str, str]:
    return {item.id: item.state for item in checklist.update()}


def test_ticks_are_kept_and_every_window_sees_them(tmp_path: Path) -> None:
    one, other = begin(tmp_path), begin(tmp_path)
    assert states(one)["airframe"] == "open"
    one.tick("airframe", "Ann")
    one.tick("vanes")
    assert states(other)["airframe"] == "green"
    other.untick("vanes")
    assert states(one)["vanes"] == "open"
    # A window started after a crash knows them too.
    assert states(begin(tmp_path))["airframe"] == "green"
    one.restart()
    assert states(other)["airframe"] == "open"


def test_the_card_counts_and_telemetry_is_still_to_come(tmp_path: Path) -> None:
    full = FlightInfo.model_validate(
        {
            "takeoff_weight": "46.5 lb", "fuel": "2.7 lb", "crew": {"pilot": "Ann"},
            "weather": {"temperature": "20 degC", "pressure": "1000 hPa"},
        }
    )  # fmt: skip
    assert states(begin(tmp_path))["card"] != "green"
    found = states(begin(tmp_path, full))
    assert found["card"] == "green"
    assert {found[name] for name in ("link", "recorder", "elevator")} == {"open"}
