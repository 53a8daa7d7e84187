"""The checklist before any flight is open: what hands and the card can tell, kept on disk."""

from pathlib import Path

from gsapp.aircraft import load_aircraft
from gsapp.flight.events import EventLog
from gsapp.flight.info import FlightInfo
from gsapp.session.checklist import load_checklist
from gsapp.session.checklist.session_checklist import PendingChecklist


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
