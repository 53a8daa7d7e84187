"""A picture of the report in the window: its theme and scale, drawn anew as the window changes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from PySide6.QtCore import QEvent, Qt, QTimer, Signal
from PySide6.QtGui import QResizeEvent, QShowEvent
from PySide6.QtWidgets import QFrame, QScrollArea, QVBoxLayout, QWidget

from ui.display_style import DisplayStyle
from ui.review.figure_canvas import FigureCanvas
from ui.review.figure_renderer import FigureRenderer, FigureSize, RenderedFigure, RenderRequest
from ui.translation import tr

if TYPE_CHECKING:
    from gsapp.report.document import DocumentFigure
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
        look: DisplayStyle,
        describe: Callable[[str, str], str],
        name: str,
        below: Sequence[QWidget] = (),
    ) -> None:
        super().__init__()
        self.setObjectName("panel")
        self._look = look
        self._build: FigureBuilder | None = None
        self._fits = False
        self.canvas = FigureCanvas(look, describe)
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
        look.changed.connect(self._restyle)
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
        plain = _DPI * self._look.sizes.scale
        wide, high = self._pixels()
        larger = min(
            wide / plain / _COMFORTABLE_SIZE[0], high / plain / _COMFORTABLE_SIZE[1], _MAX_SCALE
        )
        return plain * max(larger, 1.0)

    def _submit(self) -> None:
        if self._build is None or not self.isVisible():
            return
        theme = self._look.theme

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
        words = tr("This figure could not be drawn: {error}.").format(error=error)
        self._show(RenderedFigure(request=order, message=words))
        self.failed.emit(error)

    def _restyle(self) -> None:
        self._page.setSpacing(self._look.px(6))
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
