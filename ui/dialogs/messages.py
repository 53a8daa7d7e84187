"""All messages of this session: those that were closed can be read, copied and shown again."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QDialog, QDialogButtonBox, QVBoxLayout, QWidget

from gsapp.quantities import convert_text_units
from ui.display_style import DisplayStyle
from ui.flight.side_panels import ListPanel
from ui.icons import IndicatorState
from ui.translation import tr
from ui.widgets.row_model import TableRow, TableRowModel
from ui.widgets.table_view import TableRowView
from ui.window_frame.banners import LEVEL_TITLES, BannerMessage, BannerStack

_STATES: dict[str, IndicatorState] = {"caution": "caution", "warning": "warning"}


class MessagesDialog(QDialog):
    """The list, newest first. Stays open beside the window."""

    def __init__(
        self, look: DisplayStyle, banners: BannerStack, parent: QWidget | None = None
    ) -> None:
        super().__init__(parent)
        self._look, self._banners = look, banners
        self.setWindowTitle(tr("Messages"))
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.resize(look.px(720), look.px(440))
        column = QVBoxLayout(self)
        column.setContentsMargins(look.px(16), look.px(16), look.px(16), look.px(16))
        column.setSpacing(look.px(8))
        model = TableRowModel(look, (tr("Time"), tr("Kind"), tr("Message")))
        widths = {0: "00:00:00", 1: max(map(tr, LEVEL_TITLES.values()), key=len)}
        self.view = TableRowView(model, look, tr("Messages"), stretch=2, widths=widths)
        self.panel = ListPanel(self.view, look, tr("No message yet."))
        self.show_again_button = self.panel.add_button(
            tr("Show again"),
            tr("Show the message again below the page"),
            tr("Choose a message first"),
        )
        self.show_again_button.clicked.connect(self._show_again)
        self.view.opened.connect(lambda _key: self._show_again())
        column.addWidget(self.panel, 1)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        buttons.rejected.connect(self.reject)
        column.addWidget(buttons)
        banners.changed.connect(self.refresh)
        look.changed.connect(self.refresh)
        self.refresh()

    def refresh(self) -> None:
        self.panel.show_rows(
            [_line(message, self._look.units) for message in self._banners.messages]
        )

    def _show_again(self) -> None:
        message = self.view.current_key()
        if isinstance(message, BannerMessage):
            self._banners.show_again(message)


def _line(message: BannerMessage, units: str) -> TableRow:
    return TableRow(
        key=message,
        cells=(
            message.time.strftime("%H:%M:%S"),
            tr(LEVEL_TITLES[message.level]),
            convert_text_units(message.text, units),
        ),
        state=_STATES.get(message.level, "plain"),
        colored=frozenset({1}),
    )
