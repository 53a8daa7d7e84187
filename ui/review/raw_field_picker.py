"""Chooses a field of the messages of a flight to be drawn beside its channels."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QEvent, QObject, Qt, Signal
from PySide6.QtWidgets import QComboBox, QVBoxLayout, QWidget

from gsapp.session.review.traces import Traces
from ui.background_job import BackgroundJob, JobProgress
from ui.display_style import DisplayStyle
from ui.translation import tr
from ui.widgets.labels import create_label
from ui.widgets.layout_widgets import LabeledComboBox, add_widgets

if TYPE_CHECKING:
    from pathlib import Path

    from gsapp.quantities import FloatArray


class RawFieldPicker(QWidget):
    """A list of all fields that narrows as one types. A field that is chosen again goes away.

    It is filled when somebody goes to it: a long log takes seconds to look through.
    """

    changed = Signal(object)
    """The fields that are shown, in the order in which they were chosen."""

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__()
        self._path: Path | None = None
        self._traces: Traces | None = None
        self._is_listed = False
        self.shown: tuple[str, ...] = ()
        self.job: BackgroundJob | None = None
        self.fields = LabeledComboBox(style, tr("Message field"), letters=16)
        box = self.fields.box
        box.setEditable(True)
        box.setInsertPolicy(QComboBox.InsertPolicy.NoInsert)
        completer = box.completer()
        if completer is not None:
            completer.setFilterMode(Qt.MatchFlag.MatchContains)
            completer.setCompletionMode(completer.CompletionMode.PopupCompletion)
        self.message = create_label("", "muted", wrap=True, remarks_in=style)
        self.message.hide()
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        add_widgets(column, self.fields, self.message)
        box.activated.connect(lambda _place: self.toggle(self.fields.current_key))
        box.installEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        if watched is self.fields.box and event.type() == QEvent.Type.FocusIn:
            self.list_fields()
        return super().eventFilter(watched, event)

    def show_flight(self, path: Path | None, traces: Traces | None) -> None:
        """Offer the fields of another flight; none of them is shown."""
        from gsapp.flight.raw_fields import may_hold_messages

        self._path, self._traces, self.shown = path, traces, ()
        self._is_listed = False
        self._list(())
        self._say("")
        self.setVisible(path is not None and may_hold_messages(path))

    def list_fields(self) -> None:
        """List the fields of the flight, once."""
        path = self._path
        if path is None or self._is_listed:
            return
        self._is_listed = True
        self._say(tr("Listing the fields…"))
        from gsapp.flight.raw_fields import list_raw_fields

        def work(_progress: JobProgress) -> tuple[str, ...]:
            return list_raw_fields(path)

        self._begin(tr("Listing the fields of the flight"), work, partial(self._listed, path))

    def toggle(self, name: str) -> None:
        """Show a field, or hide it."""
        traces, path = self._traces, self._path
        if not name or traces is None or path is None:
            return
        if name in self.shown:
            self._show(tuple(one for one in self.shown if one != name))
        elif name in traces.channels:
            self._show((*self.shown, name))
        else:
            from gsapp.flight.raw_fields import load_raw_field

            def work(_progress: JobProgress) -> tuple[FloatArray, FloatArray]:
                return load_raw_field(path, name)

            self._say(tr("Reading {name}…").format(name=name))
            self._begin(name, work, partial(self._loaded, traces, name))

    def _begin(
        self, title: str, work: Callable[[JobProgress], Any], done: Callable[[Any], None]
    ) -> None:
        self.job = BackgroundJob(title, work, self)
        self.job.done.connect(done)
        self.job.failed.connect(lambda error: self._say(str(error)))
        self.job.start()

    def _listed(self, path: Path, names: tuple[str, ...]) -> None:
        if path == self._path:
            self._list(names)
            self._say("" if names else tr("This flight has no messages."))

    def _loaded(self, traces: Traces, name: str, samples: tuple[FloatArray, FloatArray]) -> None:
        if traces is self._traces:
            traces.add(name, *samples)
            self._say("")
            self._show((*self.shown, name))

    def _show(self, names: tuple[str, ...]) -> None:
        self.shown = names
        self.changed.emit(names)

    def _list(self, names: tuple[str, ...]) -> None:
        self.fields.set_choices([("", ""), *((name, name) for name in names)], "")

    def _say(self, text: str) -> None:
        self.message.setText(text)
        self.message.setVisible(bool(text))
