"""What the page Figures is laid out with: list, choices, the figure and its table, buttons."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

from PySide6.QtCore import QEvent, QSignalBlocker, Qt, QTimer, Signal
from PySide6.QtGui import QAction, QFontMetrics, QResizeEvent, QShowEvent
from PySide6.QtWidgets import (
    QFrame,
    QHBoxLayout,
    QListWidget,
    QScrollArea,
    QSizePolicy,
    QVBoxLayout,
    QWidget,
)

from ui.display_style import DisplayStyle
from ui.review.figure_canvas import FigureCanvas
from ui.review.figure_data import FigureOption
from ui.review.figure_kinds import FIGURE_KINDS, FigureKind
from ui.review.figure_renderer import FigureRenderer, FigureSize, RenderedFigure, RenderRequest
from ui.translation import tr
from ui.widgets.action_button import ActionButton
from ui.widgets.flow_layout import FlowLayout, clear_layout
from ui.widgets.labels import create_label
from ui.widgets.layout_widgets import LabeledComboBox, create_button_row
from ui.widgets.row_model import TableRow
from ui.widgets.table_view import FittedTableView

if TYPE_CHECKING:
    from gsapp.report.document import DocumentFigure, DocumentTable
    from gsapp.report.palette import Palette

FigureBuilder = Callable[["Palette", FigureSize], "DocumentFigure | str"]
"""Returns the picture for a palette and the room there is, or why there is none; called in a
thread."""

_DPI = 100.0
"""Logical pixels of an inch at 100 %: labels of 8 points on paper are 11 of the window."""
_SETTLE_MS = 40
"""Changes closer together than this are drawn once."""
_HINT_MS = 150
"""Drawing that takes longer says so."""
_COMFORTABLE_SIZE, _MAX_SCALE = (11.0, 6.5), 1.6
"""Inches across and down beyond which a figure grows as a whole, and by how much at most."""
_MIN_HEIGHT = 3.2
"""Inches of width below which nothing is drawn narrower."""
_SIZE_TOLERANCE = 0.05
"""Inches that the room may differ by from what was drawn for."""
_MIN_FIGURE_SHARE = 0.55
"""Of the height in sight that a figure takes at least, whatever stands below it."""


class FigureView(QScrollArea):
    """Shows one figure with what stands below it; scrolls where both need more than there is."""

    drawn = Signal(object)
    failed = Signal(object)

    def __init__(
        self,
        style: DisplayStyle,
        describe: Callable[[str, str], str],
        name: str,
        below: Sequence[QWidget] = (),
    ) -> None:
        super().__init__()
        self.setObjectName("panel")
        self._style = style
        self._build: FigureBuilder | None = None
        self._fits = False
        self.canvas = FigureCanvas(style, describe)
        self.canvas.setAccessibleName(name)
        self.canvas.setToolTip("")
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAsNeeded)
        self.setWidgetResizable(True)
        page = QWidget()
        page.setObjectName("panelBody")
        self._page = QVBoxLayout(page)
        self._page.setContentsMargins(0, 0, 0, 0)
        self._page.addWidget(self.canvas)
        self._below = tuple(below)
        for widget in self._below:
            self._page.addWidget(widget)
        self._page.addStretch(1)
        self.setWidget(page)
        self.setFocusProxy(self.canvas)
        self.renderer = FigureRenderer(self)
        self.renderer.drawn.connect(self._show)
        self.renderer.failed.connect(self._fail)
        self._draw_timer = self._timer(_SETTLE_MS, self._submit)
        self._hint_timer = self._timer(_HINT_MS, self._show_busy)
        self.canvas.views_changed.connect(self._draw_timer.start)
        style.changed.connect(self._restyle)
        self._restyle()

    def _timer(self, milliseconds: int, act: Callable[[], None]) -> QTimer:
        timer = QTimer(self)
        timer.setSingleShot(True)
        timer.setInterval(milliseconds)
        timer.timeout.connect(act)
        return timer

    @property
    def rendered_figure(self) -> RenderedFigure | None:
        return self.canvas.rendered_figure

    @property
    def is_up_to_date(self) -> bool:
        return not (self._draw_timer.isActive() or self.renderer.busy)

    def show_figure(self, make: FigureBuilder, *, same: bool = False) -> None:
        """Draw another figure, or the same with other numbers: then zoom and place are kept."""
        self._build = make
        self._fits = False
        if not same:
            self.canvas.discard_views()
            self.verticalScrollBar().setValue(0)
        self._draw_timer.start()

    @property
    def available_size(self) -> FigureSize:
        wide, high = self._pixels()
        dpi = self._dpi
        return FigureSize(width=max(wide / dpi, _MIN_HEIGHT), height=max(high / dpi, 1.0))

    def _pixels(self) -> tuple[float, float]:
        all_high = self.height()
        # A hair less: a figure one pixel too wide would call for a bar below.
        wide = self.width() - self.verticalScrollBar().sizeHint().width() - 2
        below = [one for one in self._below if not one.isHidden()]
        taken = sum(
            one.heightForWidth(wide) if one.hasHeightForWidth() else one.sizeHint().height()
            for one in below
        )
        taken += (len(below) + 1) * self._page.spacing()
        return wide, max(all_high - taken, _MIN_FIGURE_SHARE * all_high)

    @property
    def _dpi(self) -> float:
        """Return the logical pixels of an inch: more where the window has room to spare."""
        plain = _DPI * self._style.sizes.scale
        wide, high = self._pixels()
        larger = min(
            wide / plain / _COMFORTABLE_SIZE[0], high / plain / _COMFORTABLE_SIZE[1], _MAX_SCALE
        )
        return plain * max(larger, 1.0)

    def _submit(self) -> None:
        if self._build is None or not self.isVisible():
            return
        theme = self._style.theme

        def palette() -> Palette:
            from ui.review.figure_renderer import window_palette

            return window_palette(theme)

        order = RenderRequest(
            request_id=self.renderer.next_request_id(), build=self._build, palette=palette,
            room=self.available_size,
            dpi=self._dpi, ratio=self.devicePixelRatioF(), views=dict(self.canvas.views),
        )  # fmt: skip
        if self.rendered_figure is None:
            self.canvas.setFixedSize(self.viewport().size())
        self.renderer.submit(order)
        self._hint_timer.start()

    def _show_busy(self) -> None:
        if self.renderer.busy:
            self.canvas.show_progress_text(tr("Drawing…"))

    def _show(self, drawing: RenderedFigure) -> None:
        self._hint_timer.stop()
        self.canvas.show_rendered_figure(drawing)
        if drawing.figure is None:
            self.canvas.setFixedSize(self.viewport().size())
            self.canvas.setAccessibleDescription(drawing.message)
        else:
            self.canvas.setFixedSize(drawing.width, drawing.height)
            self.canvas.setAccessibleDescription(drawing.figure.caption)
        self.drawn.emit(drawing)
        if (
            not self._fits
            and abs(self.available_size.height - drawing.request.room.height) > _SIZE_TOLERANCE
        ):
            # What stands below takes another height than it did: once more, but only once.
            self._fits = True
            self._draw_timer.start()

    def _fail(self, order: RenderRequest, error: Exception) -> None:
        text = tr("This figure could not be drawn: {error}.").format(error=error)
        self._show(RenderedFigure(request=order, message=text))
        self.failed.emit(error)

    def _restyle(self) -> None:
        self._page.setSpacing(self._style.px(6))
        self._draw_timer.start()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        if event.size() != event.oldSize():
            self._fits = False
            self._draw_timer.start()

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        self._draw_timer.start()

    def changeEvent(self, event: QEvent) -> None:
        super().changeEvent(event)
        if event.type() == QEvent.Type.DevicePixelRatioChange:
            self._draw_timer.start()


_COLUMN_PADDING = 24
"""Points beside the words of a column."""
_MAX_VISIBLE_ROWS = 6
"""Rows in sight."""


class ReportTable(QWidget):
    """Shows one table with its caption; nothing while there is none."""

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__()
        self._style = style
        self._column = QVBoxLayout(self)
        self._column.setContentsMargins(0, 0, 0, 0)
        self._shown: DocumentTable | None = None
        self.lines: FittedTableView | None = None
        self.hide()

    def show_table(self, table: DocumentTable | None) -> None:
        if table == self._shown:
            return
        self._shown = table
        clear_layout(self._column)
        self.lines = None
        self.setVisible(table is not None)
        if table is None:
            return
        self._column.addWidget(
            create_label(table.caption, "label", wrap=True, remarks_in=self._style)
        )
        widths = {place: self._width(table, place) for place in range(1, len(table.columns))}
        self.lines = FittedTableView(
            self._style, table.caption, table.columns, stretch=0, widths=widths,
            right=table.numeric, most=_MAX_VISIBLE_ROWS,
        )  # fmt: skip
        self.lines.show_rows(
            [TableRow(key=place, cells=row) for place, row in enumerate(table.rows)]
        )
        self._column.addWidget(self.lines)

    def _width(self, table: DocumentTable, place: int) -> int:
        text = (table.columns[place], *(row[place] for row in table.rows))
        metrics = QFontMetrics(self._style.font("body"))
        pixels = max(metrics.horizontalAdvance(one) for one in text)
        return round(pixels / self._style.sizes.scale) + _COLUMN_PADDING


_LIST_WIDTH = 152
"""Points of width of the list of figures ..."""
_WIDE_WIDTH = 820
"""... that stands at the left where the page has so many; else above."""
_COMBO_CHARACTERS = 24
"""Of a choice above the figure: a maneuver with its input and flight."""
_MIN_TALL_HEIGHT = 380
"""Points of height below which the buttons give way to the figure."""


class FiguresLayout(QWidget):
    """The figure with its surroundings."""

    kind_chosen = Signal(str)
    option_chosen = Signal(str, str)

    def __init__(
        self,
        actions: Mapping[str, QAction],
        style: DisplayStyle,
        describe: Callable[[str, str], str],
    ) -> None:
        super().__init__()
        self._style = style
        self._row = QHBoxLayout(self)
        self._row.setContentsMargins(0, 0, 0, 0)
        self.list = self._create_list()
        self._row.addWidget(self.list)
        self._column = QVBoxLayout()
        self._row.addLayout(self._column, 1)
        self._column.addWidget(self._create_bar())
        self.table = ReportTable(style)
        self.detail = create_label("", wrap=True, remarks_in=style)
        self.detail.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.caption = create_label("", "hint", wrap=True, remarks_in=style)
        below = (self.table, self.detail, self.caption)
        self.view = FigureView(style, describe, tr("Figure"), below)
        self._column.addWidget(self.view, 1)
        self.buttons = create_button_row(
            style,
            ActionButton(actions["review_exclude"], tr("Exclude / Include"), style),
            ActionButton(actions["review_open_fit"], tr("Its fit"), style),
            ActionButton(actions["review_figure_copy"], tr("Copy picture"), style),
            ActionButton(actions["review_figure_copy_numbers"], tr("Copy numbers"), style),
            ActionButton(actions["review_figure_save"], tr("Save as…"), style),
        )
        self._column.addWidget(self.buttons)
        style.changed.connect(self._restyle)
        self._restyle()

    def _create_list(self) -> QListWidget:
        made = QListWidget()
        made.setProperty("role", "boxed")
        made.setAccessibleName(tr("Figures"))
        made.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        for kind in FIGURE_KINDS:
            made.addItem(tr(kind.title))
            made.item(made.count() - 1).setToolTip(tr(kind.description))
        made.setCurrentRow(0)
        made.currentRowChanged.connect(lambda place: self.kind_chosen.emit(FIGURE_KINDS[place].id))
        return made

    def _create_bar(self) -> QWidget:
        bar = QWidget()
        policy = QSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Minimum)
        policy.setHeightForWidth(True)
        bar.setSizePolicy(policy)
        self._bar = FlowLayout(bar, spacing=self._style.px(8))
        self.figure_choice = LabeledComboBox(self._style, tr("Figure"))
        self.figure_choice.box.currentIndexChanged.connect(
            lambda _place: self.kind_chosen.emit(self.figure_choice.current_key)
        )
        self._bar.addWidget(self.figure_choice)
        self.choices: dict[str, LabeledComboBox] = {}
        return bar

    def show_kind(self, kind: FigureKind) -> None:
        with QSignalBlocker(self.list):
            self.list.setCurrentRow(FIGURE_KINDS.index(kind))
        titles = [(one.id, tr(one.title)) for one in FIGURE_KINDS]
        self.figure_choice.set_choices(titles, kind.id)
        for widget in (self.view, self.view.canvas):
            widget.setAccessibleName(f"{tr(kind.title)}: {tr(kind.description)}")

    def show_options(self, options: Sequence[tuple[FigureOption, str]]) -> None:
        for option, key in options:
            if option.id not in self.choices:
                choice = LabeledComboBox(self._style, option.title, letters=_COMBO_CHARACTERS)
                choice.box.currentIndexChanged.connect(
                    lambda _place, name=option.id: self.option_chosen.emit(
                        name, self.choices[name].current_key
                    )
                )
                self.choices[option.id] = choice
                self._bar.addWidget(choice)
            choice = self.choices[option.id]
            choice.title.setText(option.title)
            choice.box.setAccessibleName(option.title)
            choice.set_choices([(one, tr(text)) for one, text in option.choices], key)
        shown = {option.id for option, _ in options if option.choices}
        for name, choice in self.choices.items():
            choice.setVisible(name in shown)

    def show_message(self, text: str) -> None:
        self.detail.setText(text)
        self.detail.setVisible(bool(text))

    def show_caption(self, text: str) -> None:
        self.caption.setText(text)
        self.caption.setVisible(bool(text))

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit()

    def _fit(self) -> None:
        wide = self.width() >= self._style.px(_WIDE_WIDTH)
        self.list.setVisible(wide)
        self.figure_choice.setVisible(not wide)
        # Their keys and the menu are still there.
        self.buttons.setVisible(self.height() >= self._style.px(_MIN_TALL_HEIGHT))

    def _restyle(self) -> None:
        style = self._style
        self._row.setSpacing(style.px(12))
        self._column.setSpacing(style.px(6))
        self._bar.setSpacing(style.px(8))
        self.list.setFixedWidth(style.px(_LIST_WIDTH))
        self._fit()
