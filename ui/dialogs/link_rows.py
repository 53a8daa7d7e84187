"""What comes over the link as lines of a table: who sends, which message, how often. No Qt."""

from __future__ import annotations

from gsapp.decoding.health import LinkReport, MessageHealth, SenderHealth
from ui.number_format import DASH, count_text, duration_text, number_text, percent_text
from ui.widgets.row_model import TableRow

LINK_COLUMN_TITLES = ("Message", "Frames", "Per s", "Age", "Delay")
LIVE_ONLY_COLUMNS = (2, 3)
"""Columns that mean nothing once the record has ended."""


def describe_senders(report: LinkReport) -> tuple[str, ...]:
    """Return what became of the frames of each sender."""
    found = [_describe_sender(sender) for sender in report.senders]
    if report.lines:
        found.append(f"{count_text(report.lines, 'line')} of text.")
    if report.residue_bytes:
        found.append(f"{count_text(report.residue_bytes, 'byte')} outside any frame.")
    return tuple(found)


def _describe_sender(sender: SenderHealth) -> str:
    whole = sender.arrived + sender.lost
    parts = [
        count_text(sender.arrived, "frame"),
        f"{percent_text(sender.lost / whole if whole else 0.0)} lost",
    ]
    if sender.duplicates:
        parts.append(f"{sender.duplicates} received twice")
    if sender.reordered:
        parts.append(f"{sender.reordered} received late")
    if sender.unknown:
        parts.append(f"{sender.unknown} with unknown messages")
    return f"System {sender.system}, component {sender.component}: {', '.join(parts)}."


def describe_vehicle(vehicle: SenderHealth, *, live: bool) -> str:
    """Return what is heard of a system that can be the flown one, for a menu."""
    what = ", ".join(filter(None, (vehicle.vehicle_type, vehicle.autopilot)))
    name = f"System {vehicle.system}" + (f" ({what})" if what else "")
    if not live:
        return f"{name}: {count_text(vehicle.arrived, 'message')}"
    return f"{name}: {number_text(vehicle.rate, 0)}/s, {duration_text(vehicle.age)} ago"


def build_link_message_rows(report: LinkReport) -> tuple[TableRow, ...]:
    """Return one line for each message of each sender, who is named where there are several."""
    several = len({(message.system, message.component) for message in report.messages}) > 1
    return tuple(_build_row(message, named=several) for message in report.messages)


def _build_row(message: MessageHealth, *, named: bool) -> TableRow:
    sender = f"{message.system}/{message.component}"
    delay = DASH if message.delay is None else f"{number_text(1000.0 * message.delay, 0)} ms"
    return TableRow(
        key=(message.system, message.component, message.message_id),
        cells=(
            f"{sender} {message.name}" if named else message.name,
            str(message.count),
            number_text(message.rate, 1 if message.rate < 9.95 else 0),
            duration_text(message.age),
            delay,
        ),
    )
