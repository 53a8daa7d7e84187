"""The checklist: what is not green stands in red on top; Space ticks; start all the same."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from PySide6.QtCore import QFileSystemWatcher, QRectF, Qt, QTimer, QUrl
from PySide6.QtGui import QAction, QDesktopServices, QPainter, QPaintEvent, QResizeEvent
from PySide6.QtWidgets import QHBoxLayout, QVBoxLayout, QWidget

from gsapp.foundation import GroundStationError
from gsapp.session.checklist import EvaluatedItem
from ui.commands import CommandRequirement
from ui.dialogs.form_dialog import FieldMessage
from ui.display_style import DisplayStyle
from ui.icons import IndicatorState, paint_indicator
from ui.preflight.checklist_model import ChecklistModel, describe_summary
from ui.preflight.form_fields import set_touch_height
from ui.preflight.preflight_model import PreflightModel
from ui.preflight.preflight_steps import PreflightStepPage
from ui.translation import QT_TR_NOOP, tr
from ui.undo import UndoHistory
from ui.widgets.action_button import ActionButton
from ui.widgets.labels import create_label
from ui.widgets.status_list import StatusListItem, StatusListView

_ROOMY_SIZE = (640, 440)
"""Points of width and height of the window below which only what matters most is shown."""
_MAX_NAMED_ITEMS = 5
"""Items named on top; the others stand below."""
_SETTLE_MS = 200
"""An editor writes a file in several steps."""


class _Summary(QWidget):
    """Sign and number of what is not green, large."""

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__()
        self._style = style
        self._state: IndicatorState = "unknown"
        self.text = ""
        style.changed.connect(self._fit)
        self._fit()

    def _fit(self) -> None:
        self.setFixedHeight(self._style.px(44))
        self.setMinimumWidth(self._style.px(240))
        self.update()

    def show_words(self, text: str, state: IndicatorState) -> None:
        """Show other words."""
        if (text, state) != (self.text, self._state):
            self.text, self._state = text, state
            self.setAccessibleName(text)
            self.update()

    def paintEvent(self, _event: QPaintEvent) -> None:
        style = self._style
        painter = QPainter(self)
        side = style.px(24)
        top = (self.height() - side) / 2
        color = style.state_color(self._state)
        paint_indicator(painter, self._state, QRectF(0, top, side, side), color)
        font = style.font("title", strong=True)
        font.setPixelSize(style.px(28))
        painter.setFont(font)
        painter.setPen(color)
        painter.drawText(
            QRectF(side + style.px(12), 0, self.width(), self.height()),
            Qt.AlignmentFlag.AlignVCenter,
            self.text,
        )
        painter.end()


_STATE_TEXTS: Mapping[str, tuple[IndicatorState, str]] = {
    "red": ("warning", QT_TR_NOOP("Not OK")),
    "amber": ("caution", QT_TR_NOOP("Look")),
    "open": ("unknown", QT_TR_NOOP("To do")),
    "green": ("good", QT_TR_NOOP("Done")),
}
"""Sign and words of each state."""


def _build_item(item: EvaluatedItem) -> StatusListItem:
    state, text = _STATE_TEXTS[item.state]
    return StatusListItem(
        key=item.id,
        text=item.text,
        detail=item.why,
        state=state,
        state_text=tr(text),
        note=tr("manual") if item.checked_by == "hand" or item.can_tick else tr("automatic"),
        is_checkable=item.can_tick and item.state != "green",
        is_done=item.state == "green",
    )


class ChecklistPage(PreflightStepPage):
    """Goes through the checklist."""

    def __init__(
        self,
        style: DisplayStyle,
        actions: Mapping[str, QAction],
        fail: Callable[[BaseException], object],
    ) -> None:
        super().__init__(style, tr("Checklist"))
        self._fail = fail
        self.model: ChecklistModel | None = None
        self._column = QVBoxLayout(self)
        self._top = QHBoxLayout()
        self.summary = _Summary(style)
        self._top.addWidget(self.summary, 1)
        self.start = ActionButton(actions["preflight_start"], tr("Start the flight"), style)
        self.start.setProperty("role", "primary")
        self.reset_button = ActionButton(actions["checklist_reset"], tr("Reset"), style)
        self.change = ActionButton(actions["checklist_edit"], tr("Edit the list…"), style)
        for button in (self.start, self.reset_button, self.change):
            set_touch_height(button)
            self._top.addWidget(button)
        self._column.addLayout(self._top)
        self.red = create_label("", "strong", wrap=True)
        self.red.setProperty("state", "warning")
        self._column.addWidget(self.red)
        self.message = FieldMessage()
        self._column.addWidget(self.message)
        self.list = StatusListView(
            style, tr("Checklist"), [actions["checklist_tick"], actions["checklist_edit"]]
        )
        self.list.item_activated.connect(self._tick)
        self._column.addWidget(self.list, 1)
        self._watcher = QFileSystemWatcher(self)
        self._settle = QTimer(self)
        self._settle.setSingleShot(True)
        self._settle.setInterval(_SETTLE_MS)
        self._settle.timeout.connect(self._reload)
        for changed in (self._watcher.fileChanged, self._watcher.directoryChanged):
            changed.connect(lambda _path: self._settle.start())
        style.changed.connect(self._fit)
        self._fit()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit()

    def _fit(self) -> None:
        px = self.display_style.px
        roomy = self.width() >= px(_ROOMY_SIZE[0]) and self.window().height() >= px(_ROOMY_SIZE[1])
        for button in (self.reset_button, self.change):
            button.setVisible(roomy)
        self.red.setMaximumHeight(px(1000 if roomy else 0))
        self._column.setContentsMargins(px(16), px(12), px(16), 0)
        self._column.setSpacing(px(8))
        self._top.setSpacing(px(16))

    # Showing

    @property
    def handlers(self) -> Mapping[str, Callable[[], object]]:
        return {
            "checklist_tick": self.tick,
            "checklist_reset": self.reset,
            "checklist_edit": self.edit,
        }

    @property
    def present(self) -> tuple[CommandRequirement, ...]:
        if self.model is None or not self.model.accepts_ticks:
            return ()
        return ("checklist", "checklist_ticked") if self.model.ticks else ("checklist",)

    def set_model(self, model: PreflightModel) -> None:
        """Show the checklist of another flight."""
        self.model = model.checklist
        self._watch_files()
        self.message.set_message("")
        self.show_items()
        self.list.select_row(0)

    def refresh(self) -> None:
        """Show how the items stand by now."""
        self.show_items()

    def show_items(self) -> None:
        """Show how the items stand."""
        model = self.model
        if model is None:
            return
        self.list.set_items([_build_item(item) for item in model.items])
        left = model.open_items
        state: IndicatorState = "warning" if left else "good"
        self.summary.show_words(
            describe_summary(model.items), state if model.accepts_ticks else "unknown"
        )
        names = [item.text for item in left[:_MAX_NAMED_ITEMS]]
        if len(left) > _MAX_NAMED_ITEMS:
            names.append(tr("{count} more").format(count=len(left) - _MAX_NAMED_ITEMS))
        self.red.setText("; ".join(names))
        self.red.setVisible(bool(left) and model.accepts_ticks)
        if model.own_list_error:
            self.message.set_message(
                tr("The previous list applies: {own_list_error}").format(
                    own_list_error=model.own_list_error
                ),
                "warning",
            )
        elif model.started_text:
            self.message.set_message(model.started_text)
        elif not model.accepts_ticks:
            self.message.set_message(
                tr("Replay: checklist from telemetry; items cannot be ticked.")
            )
        self.message.setVisible(bool(self.message.text()))

    def set_initial_focus(self) -> None:
        """Put the keyboard into the list."""
        self.list.setFocus()
        if not self.list.current_key:
            self.list.select_row(0)

    # What the crew does

    def _do(self, act: Callable[[ChecklistModel], object]) -> None:
        if self.model is None:
            return
        try:
            act(self.model)
        except GroundStationError as error:
            self._fail(error)
        self.show_items()
        self.changed.emit()

    def tick(self) -> None:
        """Tick the line that the keyboard is on."""
        self._tick(self.list.current_key)

    def _tick(self, item_id: str) -> None:
        model = self.model
        if model is None or not item_id:
            return
        row = self.list.currentIndex().row()
        item = next(one for one in model.items if one.id == item_id)
        done: list[bool] = []
        self.message.set_message("")
        self._do(lambda model: done.append(model.toggle(item_id)))
        if done == [False]:
            who = tr("Checked by telemetry") if model.accepts_ticks else tr("This is a replay")
            self.message.set_message(
                tr("{who}: “{text}” cannot be ticked.").format(who=who, text=item.text), "caution"
            )
            self.message.show()
        elif item.state != "green":
            # What was ticked went down; the next one stands in its place.
            self.list.select_row(row)

    def reset(self) -> None:
        """Begin anew; Ctrl+Z brings the ticks back."""
        self.message.set_message("")
        self._do(lambda model: model.restart())
        self.list.select_row(0)

    def edit(self) -> None:
        """Open the crew's own list in the editor of this computer; saved there, it counts here."""
        if self.model is None:
            return
        try:
            path = self.model.create_own_list()
        except OSError as error:
            self._fail(error)
            return
        self._watch_files()
        opened = QDesktopServices.openUrl(QUrl.fromLocalFile(str(path)))
        text = tr("is open in the editor") if opened else tr("is the file to edit")
        self.message.set_message(
            tr("{path} {words}; saved changes apply at once.").format(path=path, words=text),
            "good",
        )
        self.message.show()

    @property
    def undo_history(self) -> UndoHistory | None:
        model = self.model
        return model.undo_stack if model is not None and model.accepts_ticks else None

    def undo(self) -> None:
        self._do(lambda model: model.undo_stack.undo())

    def redo(self) -> None:
        self._do(lambda model: model.undo_stack.redo())

    # The file

    def _watch_files(self) -> None:
        """Notice when the crew's own list changes: many editors put a new file in its place."""
        if self.model is None:
            return
        own = self.model.own
        wanted = [str(path) for path in (own.parent, own) if path.exists()]
        missing = [
            path
            for path in wanted
            if path not in (*self._watcher.files(), *self._watcher.directories())
        ]
        if missing:
            self._watcher.addPaths(missing)

    def _reload(self) -> None:
        self._watch_files()
        if self.model is not None and self.model.read_if_changed():
            self.message.set_message("")
            self.show_items()
            self.changed.emit()
