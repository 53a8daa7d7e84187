"""MAVLink inspector: every message of every sender, as it stands now."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QSize, Signal
from PySide6.QtWidgets import QDialogButtonBox, QVBoxLayout, QWidget

from gsapp.decoding.health import LinkReport, MessageHealth, RejectedSender, SenderHealth
from ui.dialogs.form_dialog import SelfDeletingDialog
from ui.display_style import DisplayStyle
from ui.flight.side_panels import ListPanel
from ui.number_format import DASH, count_text, duration_text, number_text, percent_text
from ui.translation import QT_TR_NOOP, tr
from ui.widgets.flow_layout import arrange
from ui.widgets.labels import create_label
from ui.widgets.row_model import TableRow, TableRowModel
from ui.widgets.table_view import TableRowView

LINK_COLUMN_TITLES = (
    QT_TR_NOOP("Message"), QT_TR_NOOP("Frames"), QT_TR_NOOP("Per s"), QT_TR_NOOP("Age"),
    QT_TR_NOOP("Delay"),
)  # fmt: skip
LIVE_ONLY_COLUMNS = (2, 3)  # Columns that mean nothing once the record has ended.


def describe_senders(report: LinkReport) -> tuple[str, ...]:
    """Return what became of the frames of each sender."""
    found = [_describe_sender(sender) for sender in report.senders]
    found.extend(map(describe_rejected, report.rejected))
    if report.lines:
        found.append(tr("{lines} of text.").format(lines=count_text(report.lines, "line")))
    if report.residue_bytes:
        found.append(
            tr("{bytes} outside any frame.").format(bytes=count_text(report.residue_bytes, "byte"))
        )
    return tuple(found)


def _describe_sender(sender: SenderHealth) -> str:
    whole = sender.arrived + sender.lost
    parts = [
        count_text(sender.arrived, "frame"),
        tr("{percent} lost").format(percent=percent_text(sender.lost / whole if whole else 0.0)),
    ]
    if sender.duplicates:
        parts.append(tr("{duplicates} received twice").format(duplicates=sender.duplicates))
    if sender.reordered:
        parts.append(tr("{reordered} received late").format(reordered=sender.reordered))
    if sender.unknown:
        parts.append(tr("{unknown} with unknown messages").format(unknown=sender.unknown))
    return tr("System {system}, component {component}: {parts}.").format(
        system=sender.system, component=sender.component, parts=", ".join(parts)
    )


def describe_vehicle(vehicle: SenderHealth, *, live: bool) -> str:
    """Return what is heard of a system that can be the flown one, for a menu."""
    what = ", ".join(filter(None, (vehicle.vehicle_type, vehicle.autopilot)))
    name = tr("System {system}").format(system=vehicle.system) + (f" ({what})" if what else "")
    name += f" {vehicle.address}" if vehicle.address else ""
    if not live:
        return f"{name}: {count_text(vehicle.arrived, 'message')}"
    return tr("{name}: {rate}/s, {age} ago").format(
        name=name, rate=number_text(vehicle.rate, 0), age=duration_text(vehicle.age)
    )


_REJECTION_REASONS = {
    "address": QT_TR_NOOP("another address"),
    "unsigned": QT_TR_NOOP("not signed"),
    "false": QT_TR_NOOP("false signature"),
    "replayed": QT_TR_NOOP("signature out of date"),
}


def describe_rejected(sender: RejectedSender) -> str:
    """Return whose frames are ignored, how many, and why."""
    return tr("System {system}{address}: {frames} ignored, {reason}").format(
        system=sender.system,
        address=f" ({sender.address})" if sender.address else "",
        frames=count_text(sender.count, "frame"),
        reason=tr(_REJECTION_REASONS.get(sender.reason, sender.reason)),
    )


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


_DELAY = QT_TR_NOOP(
    "Delay: of the last message, by its own time stamp, relative to the fastest of the last "
    "minutes."
)


class MavlinkInspector(SelfDeletingDialog):
    """Loss by sender; count, rate, age and delay by message.

    `ask`: returns how the link stands; None where nothing came as frames. `live`: whether the
    flight goes on, so that rates and ages mean something.
    """

    fields_requested = Signal(str)  # A message whose fields are to be charted.

    def __init__(
        self,
        style: DisplayStyle,
        ask: Callable[[], LinkReport | None],
        *,
        live: bool,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        self._ask = ask
        self._names: dict[object, str] = {}
        self.setWindowTitle(tr("MAVLink inspector"))
        room = self.screen().availableSize() - QSize(32, 64)
        self.resize(QSize(style.px(760), style.px(600)).boundedTo(room))
        column = arrange(
            QVBoxLayout(self), style.px(8), style.px(24), style.px(16), style.px(24), style.px(16)
        )
        self.senders = create_label("", wrap=True)
        column.addWidget(self.senders)
        model = TableRowModel(style, LINK_COLUMN_TITLES, right=frozenset({1, 2, 3, 4}))
        widths = {1: "1234567", 2: "1000", 3: "99 min", 4: "1000 ms"}
        view = TableRowView(model, style, tr("Messages"), stretch=0, widths=widths, wrap=False)
        for place in () if live else LIVE_ONLY_COLUMNS:
            view.setColumnHidden(place, True)
        self.messages = ListPanel(view, style, tr("No frames received yet."))
        chart = self.messages.add_button(
            tr("Chart fields"),
            tr("Read the fields of the selected message as channels, from the start of the flight"),
            tr("Choose a message first"),
        )
        chart.clicked.connect(self._request_fields)
        column.addWidget(self.messages, 1)
        column.addWidget(create_label(tr(_DELAY), "hint", wrap=True))
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        buttons.rejected.connect(self.reject)
        column.addWidget(buttons)
        self.refresh()

    def refresh(self) -> None:
        report = self._ask()
        sentences = () if report is None else (*describe_senders(report), *report.warnings)
        self.senders.setText("\n".join(sentences))
        self.senders.setVisible(bool(sentences))
        messages = () if report is None else report.messages
        self._names = {(one.system, one.component, one.message_id): one.name for one in messages}
        self.messages.show_rows(() if report is None else build_link_message_rows(report))

    def _request_fields(self) -> None:
        name = self._names.get(self.messages.view.current_key())
        if name is not None:
            self.accept()
            self.fields_requested.emit(name)
