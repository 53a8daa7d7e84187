"""MAVLink inspector: every message of every sender, as it stands now."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QSize
from PySide6.QtWidgets import QDialogButtonBox, QVBoxLayout, QWidget

from gsapp.decoding.health import LinkReport
from ui.dialogs.form_dialog import SelfDeletingDialog
from ui.dialogs.link_rows import (
    LINK_COLUMN_TITLES,
    LIVE_ONLY_COLUMNS,
    build_link_message_rows,
    describe_senders,
)
from ui.display_style import DisplayStyle
from ui.flight.side_panels import ListPanel
from ui.translation import QT_TR_NOOP, tr
from ui.widgets.labels import create_label
from ui.widgets.row_model import TableRowModel
from ui.widgets.table_view import TableRowView

_DELAY = QT_TR_NOOP(
    "Delay: of the last message, by its own time stamp, relative to the fastest of the last "
    "minutes."
)


class MavlinkInspector(SelfDeletingDialog):
    """Loss by sender; count, rate, age and delay by message.

    Parameters
    ----------
    ask : callable
        Returns how the link stands; None where nothing came as frames.
    live : bool
        Whether the flight goes on, so that rates and ages mean something.
    """

    def __init__(
        self,
        look: DisplayStyle,
        ask: Callable[[], LinkReport | None],
        *,
        live: bool,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        self._ask = ask
        self.setWindowTitle(tr("MAVLink inspector"))
        room = self.screen().availableSize() - QSize(32, 64)
        self.resize(QSize(look.px(760), look.px(600)).boundedTo(room))
        column = QVBoxLayout(self)
        column.setContentsMargins(look.px(24), look.px(16), look.px(24), look.px(16))
        column.setSpacing(look.px(8))
        self.senders = create_label("", wrap=True)
        column.addWidget(self.senders)
        model = TableRowModel(look, LINK_COLUMN_TITLES, right=frozenset({1, 2, 3, 4}))
        widths = {1: "1234567", 2: "1000", 3: "99 min", 4: "1000 ms"}
        view = TableRowView(model, look, tr("Messages"), stretch=0, widths=widths, wrap=False)
        for place in () if live else LIVE_ONLY_COLUMNS:
            view.setColumnHidden(place, True)
        self.messages = ListPanel(view, look, tr("No frames received yet."))
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
        self.messages.show_rows(() if report is None else build_link_message_rows(report))
