"""The kept runs: listed, named, marked, set beside each other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QAction, QFocusEvent, QKeyEvent
from PySide6.QtWidgets import QVBoxLayout, QWidget

from gsapp.identification.axes import AXIS_TITLES
from gsapp.identification.methods import short_method_title
from ui.display_style import DisplayStyle
from ui.number_format import DASH, symbol_text, value_with_std_text
from ui.review.run_store import RunStore, count_derivatives
from ui.translation import QT_TR_NOOP, tr
from ui.widgets.action_button import ActionButton
from ui.widgets.labels import create_label
from ui.widgets.layout_widgets import add_widgets, create_button_row
from ui.widgets.row_model import TableRow
from ui.widgets.table_view import FittedTableView

if TYPE_CHECKING:
    from gsapp.identification.campaign import CampaignValue
    from gsapp.identification.runs.run_comparison import RunComparison, ValueDifference
    from gsapp.identification.runs.run_store import StoredRun

NAME_COLUMN_INDEX = 1
"""Column of a run's name."""


def build_run_rows(
    runs: Sequence[StoredRun], marked: int | None, shown: int | None
) -> list[TableRow]:
    """Return the kept runs as lines, one marked to compare others with, one shown in figures."""
    lines = []
    for one in runs:
        signs = [
            word
            for on, word in (
                (one.number == marked, tr("◆ marked")),
                (one.number == shown, tr("shown")),
            )
            if on
        ]
        lines.append(
            TableRow(
                key=one.number,
                cells=(
                    str(one.number),
                    one.label,
                    tr(short_method_title(one.method))
                    + ", "
                    + (tr("by surfaces") if one.axis == "both" else AXIS_TITLES[one.axis]),
                    str(one.maneuver_count),
                    one.created_at.astimezone().strftime("%d %b %H:%M"),
                    ", ".join(signs),
                ),
                detail=tr("run {number} of {flights}").format(
                    number=one.number, flights=", ".join(one.flights)
                ),
            )
        )
    return lines


def build_setting_rows(run: StoredRun, comparison: RunComparison | None) -> list[TableRow]:
    """Return the settings of a run; beside another one, those that differ."""
    if comparison is None:
        return [TableRow(key=name, cells=(name, text, "")) for name, text in run.settings.items()]
    return [
        TableRow(key=one.name, cells=(one.name, one.one, one.other)) for one in comparison.settings
    ]


def build_run_value_rows(run: StoredRun, comparison: RunComparison | None) -> list[TableRow]:
    """Return the values of a run; beside another one, both and how far they are apart."""
    if comparison is None:
        return [
            TableRow(key=name, cells=(symbol_text(name), mean_text(value), "", ""))
            for name, value in run.values.items()
        ]
    return [_build_comparison_row(one) for one in comparison.values]


def _build_comparison_row(one: ValueDifference) -> TableRow:
    apart = (
        "" if one.in_bounds is None else tr("{bounds:.1f} bounds").format(bounds=abs(one.in_bounds))
    )
    text = tr("single value") if one.in_bounds is None else f"▲ {apart}" if one.differs else apart
    return TableRow(
        key=one.name,
        cells=(symbol_text(one.name), mean_text(one.one), mean_text(one.other), text),
        state="caution" if one.differs else "plain",
        colored=frozenset({3}),
    )


def mean_text(value: CampaignValue | None) -> str:
    """Return a mean with its bound; a dash where there is none."""
    return DASH if value is None else value_with_std_text(value.mean, value.std)


def describe_run(run: StoredRun, comparison: RunComparison | None) -> str:
    """Return what there is to say of a run, or of two beside each other."""
    if comparison is None:
        parts = [
            tr("{count} derivatives from {maneuvers} maneuvers.").format(
                count=count_derivatives(run.values), maneuvers=run.maneuver_count
            )
        ]
        if run.bounds_ratio is not None:
            parts.append(
                tr("Scatter / bound: {ratio:.1f} (1 = consistent).").format(ratio=run.bounds_ratio)
            )
        if run.failures:
            parts.append(tr("Not fitted: {failures}.").format(failures=", ".join(run.failures)))
        if run.outlying_maneuvers:
            parts.append(tr("Wild: {names}.").format(names=", ".join(run.outlying_maneuvers)))
        return " ".join(parts)
    far = [symbol_text(one.name) for one in comparison.values if one.differs]
    what = (
        tr("{count} of {total} values differ: {values}{more}.").format(
            count=len(far),
            total=len(comparison.values),
            values=", ".join(far[:6]),
            more=" …" if len(far) > 6 else "",
        )
        if far
        else tr("No value differs by more than the bounds allow.")
    )
    versions = (
        tr(" Versions differ: {versions}.").format(versions="; ".join(comparison.versions))
        if comparison.versions
        else ""
    )
    settings = "" if comparison.settings else tr(" The settings are the same.")
    return tr("{one} compared with {other}: {what}{settings}{versions}").format(
        one=comparison.one, other=comparison.other, what=what, settings=settings, versions=versions
    )


_RUN_TITLES = (
    QT_TR_NOOP("No."), QT_TR_NOOP("Name"), QT_TR_NOOP("Method"), QT_TR_NOOP("Of"),
    QT_TR_NOOP("When"), "",
)  # fmt: skip
_SETTING_TITLES = (QT_TR_NOOP("Setting"), QT_TR_NOOP("This run"), QT_TR_NOOP("Marked run"))
_NO_RUNS_TEXT = QT_TR_NOOP("No runs yet. Each run is saved here with its settings.")
_VALUE_TITLES = (
    QT_TR_NOOP("Derivative"), QT_TR_NOOP("This run"), QT_TR_NOOP("Marked run"), QT_TR_NOOP("Apart"),
)  # fmt: skip


class RunsView(QWidget):
    """Kept runs with what was asked for and what came of it."""

    chosen = Signal()
    """Another run has the keyboard, or is marked: other commands may be of use."""
    opened = Signal()
    focused = Signal()

    def __init__(
        self, actions: Mapping[str, QAction], style: DisplayStyle, run_store: RunStore
    ) -> None:
        super().__init__()
        self._style = style
        self._run_store = run_store
        self._shown: int | None = None
        self._pending_number: int | None = None
        self.marked: int | None = None
        self._column = QVBoxLayout(self)
        self._column.setContentsMargins(0, 0, 0, 0)
        self.empty = create_label(tr(_NO_RUNS_TEXT), "muted", wrap=True)
        self.list = _RunList(
            style, tr("Saved runs"), _RUN_TITLES, stretch=NAME_COLUMN_INDEX,
            widths={0: 44, 2: 132, 3: 52, 4: 112, 5: 88}, right=frozenset({0, 3}),
            least=2, most=7, editable=frozenset({NAME_COLUMN_INDEX}),
            title_details={5: tr("Marked, shown")},
        )  # fmt: skip
        self.buttons = create_button_row(
            style,
            ActionButton(actions["review_repeat"], tr("Repeat exactly"), style),
            ActionButton(actions["review_use"], tr("Use its settings"), style),
            ActionButton(actions["review_mark"], tr("Mark to compare"), style),
            ActionButton(actions["review_name"], tr("Name"), style),
            ActionButton(actions["review_forget"], tr("Delete"), style),
        )
        self.message = create_label("", wrap=True, remarks_in=style)
        self.message.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.values = FittedTableView(
            style, tr("Values of the run"), _VALUE_TITLES, stretch=0,
            widths={1: 164, 2: 164, 3: 96}, right=frozenset({1, 2, 3}), most=12,
        )  # fmt: skip
        self.settings = FittedTableView(
            style, tr("Settings of the run"), _SETTING_TITLES, stretch=1, widths={0: 140, 2: 160},
            most=10,
        )  # fmt: skip
        heading = create_label(tr("Saved runs"), "heading")
        self._parts = (self.list, self.buttons, self.message, self.values, self.settings)
        add_widgets(self._column, heading, self.empty, *self._parts)
        self._column.addStretch(1)
        self.list.selectionModel().currentRowChanged.connect(lambda *_: self._show_run())
        self.list.opened.connect(lambda _key: self.opened.emit())
        self.list.deleted.connect(self._delete)
        self.list.marked.connect(self.toggle_mark)
        self.list.focused.connect(self.focused)
        self.list.row_model.edited.connect(self._renamed)
        run_store.changed.connect(self.refresh)
        style.changed.connect(self._fit)
        self._fit()
        self.refresh()

    def _fit(self) -> None:
        self._column.setSpacing(self._style.px(8))

    @property
    def current_run(self) -> StoredRun | None:
        key = self.list.current_key()
        return self._run_store.find_run(key if isinstance(key, int) else None)

    def show_run(self, number: int | None) -> None:
        """Say which run figures and summary show, and put the keyboard's line there.

        A run that has just ended is listed once the catalog was read again. A name that is being
        typed is not left for it.
        """
        self._shown = number
        self._pending_number = number
        self.refresh()

    def refresh(self) -> None:
        runs = self._run_store.runs
        if self.marked is not None and self._run_store.find_run(self.marked) is None:
            self.marked = None
        self.list.show_rows(build_run_rows(runs, self.marked, self._shown))
        unread = self._run_store.read_error
        self.empty.setText(
            tr("They cannot be read: {unread}.").format(unread=unread)
            if unread
            else tr(_NO_RUNS_TEXT)
        )
        self.empty.setVisible(not runs)
        for part in self._parts:
            part.setVisible(bool(runs))
        if self.list.is_editing:
            self._pending_number = None
        if self._run_store.find_run(self._pending_number) is not None:
            self.list.select_row(self._pending_number)
            self._pending_number = None
        if runs and self.current_run is None:
            self.list.setCurrentIndex(self.list.row_model.index(0, 0))
        self._show_run()

    def toggle_mark(self) -> None:
        run = self.current_run
        if run is not None:
            self.marked = None if self.marked == run.number else run.number
            self.refresh()

    def rename(self) -> None:
        run = self.current_run
        if run is not None:
            self.list.setFocus()
            self.list.edit_row(run.number, NAME_COLUMN_INDEX)

    def remove(self) -> None:
        run = self.current_run
        if run is not None:
            self._run_store.remove(run.number)

    def _delete(self, key: object) -> None:
        if isinstance(key, int):
            self._run_store.remove(key)

    def _renamed(self, key: object, text: str) -> None:
        if isinstance(key, int):
            self._run_store.rename(key, text)

    def _comparison(self, run: StoredRun) -> RunComparison | None:
        marked = self._run_store.find_run(self.marked)
        if marked is None or marked.number == run.number:
            return None
        from gsapp.identification.runs.run_comparison import compare_runs

        return compare_runs(run, marked)

    def _show_run(self) -> None:
        run = self.current_run
        if run is not None:
            comparison = self._comparison(run)
            self.message.setText(describe_run(run, comparison))
            self.values.show_rows(build_run_value_rows(run, comparison))
            self.settings.show_rows(build_setting_rows(run, comparison))
            beside = comparison is not None
            for table, columns in ((self.values, (2, 3)), (self.settings, (2,))):
                for column in columns:
                    table.setColumnHidden(column, not beside)
            self.settings.setVisible(bool(self.settings.row_model.rows))
        self.chosen.emit()


class _RunList(FittedTableView):
    """The list; Space marks."""

    marked = Signal()
    focused = Signal()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() == Qt.Key.Key_Space:
            self.marked.emit()
        else:
            super().keyPressEvent(event)

    def focusInEvent(self, event: QFocusEvent) -> None:
        super().focusInEvent(event)
        self.focused.emit()
