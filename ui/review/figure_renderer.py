"""Figures drawn in a thread, in the colors of the window, which only shows the finished picture.

Drawing takes a tenth of a second to one second and is never done in the thread of the window.
Orders that were overtaken by another are dropped.
"""

from __future__ import annotations

import itertools
import math
import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from PySide6.QtCore import QObject, Signal
from PySide6.QtGui import QImage

from gsapp.report.palette import Palette
from ui.display_style import mix_colors
from ui.review.figure_geometry import FigureCurve, Limits, ManeuverPoint, Subplot, ViewRange
from ui.theme import Theme, luminance

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from gsapp.report.document import DocumentFigure
    from gsapp.report.palette import Palette

_PRINT_LINE_WIDTH = 1.8
"""Width of a trace of the window at which a picture's lines are as heavy as on paper."""
_BAND, _BAND_ON_DARK = 0.14, 0.28
"""How far bands lie from the background to the color of measured traces."""


def window_palette(theme: Theme) -> Palette:
    """Return the colors in which pictures are drawn in a theme."""
    dark = luminance(theme.plot) < luminance(theme.text)
    return Palette(
        background=theme.plot,
        ink=theme.text,
        secondary_ink=theme.muted,
        faint=mix_colors(theme.plot, theme.axis, 0.55).name(),
        previous=theme.previous,
        band=mix_colors(theme.plot, theme.traces["blue"], _BAND_ON_DARK if dark else _BAND).name(),
        excluded=theme.previous,
        traces=theme.traces,
        line_scale=theme.line_width / _PRINT_LINE_WIDTH,
    )


_MIN_SCALE = 0.85
"""Of a picture's height on paper that it needs in the window."""
_MAX_SCALE = 2.5
"""Of that height, beyond which room is left empty."""
_FEW = 8
"""Points up to which a line is no curve to be read: axes, limits, means."""
_IDLE_SECONDS = 3.0
"""Without an order after which the thread ends; the next order begins another."""
_POLL_SECONDS = 0.1
"""Seconds between two looks at whether the program ends."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FigureSize:
    """What a figure has: inches across and down in sight."""

    width: float
    height: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RenderRequest:
    """A figure to be drawn."""

    request_id: int
    build: Callable[[Palette, FigureSize], DocumentFigure | str]
    """Returns the picture for a palette and the room there is, or why there is none, in words."""
    palette: Callable[[], Palette]
    """Returns the colors; called in the thread."""
    room: FigureSize
    dpi: float
    ratio: float = 1.0
    """Pixels of the screen to a logical pixel."""
    views: Mapping[int, ViewRange] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RenderedFigure:
    """A figure, drawn."""

    request: RenderRequest
    figure: DocumentFigure | None = None
    """None where there is nothing to draw."""
    message: str = ""
    image: QImage | None = None
    width: int = 0
    height: int = 0
    subplots: tuple[Subplot, ...] = ()
    points: tuple[ManeuverPoint, ...] = ()


def render_figure(order: RenderRequest) -> RenderedFigure:
    """Draw a figure now."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    from gsapp.report.document import figure_style

    palette = order.palette()
    picture = order.build(palette, order.room)
    if isinstance(picture, str):
        return RenderedFigure(request=order, message=picture)
    least, most = _MIN_SCALE * picture.height, _MAX_SCALE * picture.height
    height = max(min(order.room.height, most), least)
    with figure_style(palette):
        figure = Figure(
            figsize=(order.room.width, height), dpi=order.dpi * order.ratio,
            facecolor=palette.background,
        )  # fmt: skip
        canvas = FigureCanvasAgg(figure)
        picture.draw(figure)
        for index, axes in enumerate(figure.axes):
            if index in order.views:
                _apply_view(axes, order.views[index])
        canvas.draw()
        pixels = np.asarray(canvas.buffer_rgba())
        high, wide = pixels.shape[:2]
        image = QImage(pixels.tobytes(), wide, high, 4 * wide, QImage.Format.Format_RGBA8888).copy()
        image.setDevicePixelRatio(order.ratio)
        return RenderedFigure(
            request=order, figure=picture, image=image,
            width=round(wide / order.ratio), height=round(high / order.ratio),
            subplots=_extract_subplots(figure, order.ratio), points=_extract_points(figure,
            order.ratio),
        )  # fmt: skip


def _apply_view(axes: Axes, view: ViewRange) -> None:
    x, y = view.x, view.y
    axes.set_xlim(*(_powers_of_ten(x) if axes.get_xscale() == "log" else x))
    axes.set_ylim(*(_powers_of_ten(y) if axes.get_yscale() == "log" else y))


def _powers_of_ten(limits: Limits) -> Limits:
    return 10.0 ** limits[0], 10.0 ** limits[1]


def _read_limits(limits: tuple[float, float], scale: str) -> Limits:
    low, high = float(limits[0]), float(limits[1])
    return (math.log10(low), math.log10(high)) if scale == "log" else (low, high)


def _extract_curves(axes: Axes) -> tuple[FigureCurve, ...]:
    found = []
    for line in axes.lines:
        x, y = (np.asarray(part, dtype=np.float64) for part in line.get_data())
        label = str(line.get_label())
        if line.get_linestyle() != "None" and x.size > _FEW and bool((np.diff(x) > 0.0).all()):
            found.append(FigureCurve(label="" if label.startswith("_") else label, x=x, y=y))
    return tuple(found)


def _extract_subplots(figure: Figure, ratio: float) -> tuple[Subplot, ...]:
    from gsapp.report.plot_elements import ClockFormatter, mathtext_to_plain

    tall = figure.bbox.height
    places = {axes: place for place, axes in enumerate(figure.axes)}
    found = []
    for axes, place in places.items():
        if not axes.get_visible():
            continue
        box = axes.get_window_extent()
        shared = axes.get_shared_x_axes().get_siblings(axes)
        siblings = [places[one] for one in shared]
        titles = (one.get_xlabel() for one in sorted(shared, key=places.__getitem__))
        found.append(
            Subplot(
                index=place,
                name=axes.get_gid() or "",
                left=box.x0 / ratio,
                top=(tall - box.y1) / ratio,
                right=box.x1 / ratio,
                bottom=(tall - box.y0) / ratio,
                view=ViewRange(
                    x=_read_limits(axes.get_xlim(), axes.get_xscale()),
                    y=_read_limits(axes.get_ylim(), axes.get_yscale()),
                ),
                group=min(siblings),
                shares_x_axis=len(siblings) > 1,
                x_title=mathtext_to_plain(next(filter(None, titles), "")),
                y_title=mathtext_to_plain(axes.get_ylabel() or axes.get_title(loc="left")),
                x_log=axes.get_xscale() == "log",
                y_log=axes.get_yscale() == "log",
                x_is_time=isinstance(axes.xaxis.get_major_formatter(), ClockFormatter),
                curves=_extract_curves(axes),
            )
        )
    return tuple(found)


def _extract_points(figure: Figure, ratio: float) -> tuple[ManeuverPoint, ...]:
    from gsapp.report.plot_elements import point_names

    tall = figure.bbox.height
    found = []
    for index, axes in enumerate(figure.axes):
        box = axes.get_window_extent().padded(2.0)
        for line in axes.lines:
            names = point_names(line)
            if not names:
                continue
            pixels = axes.transData.transform(np.column_stack(line.get_data()))
            for name, (x, y) in zip(names, pixels, strict=True):
                if np.isfinite(x + y) and box.contains(x, y):
                    spot = ManeuverPoint(
                        subplot_index=index,
                        maneuver=name,
                        x=float(x / ratio),
                        y=float((tall - y) / ratio),
                    )
                    found.append(spot)
    return tuple(found)


class FigureRenderer(QObject):
    """Draws the newest order in a thread of its own."""

    drawn = Signal(object)
    """A `RenderedFigure`; of overtaken orders none."""
    failed = Signal(object, object)
    """The newest order, and the exception that it ended with."""
    _ended = Signal(object, object)

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._counter = itertools.count(1)
        self._newest = 0
        self._pending: RenderRequest | None = None
        self._condition = threading.Condition()
        self._thread: threading.Thread | None = None
        self._ended.connect(self._end)

    @property
    def busy(self) -> bool:
        return self._newest != 0

    def next_request_id(self) -> int:
        return next(self._counter)

    def submit(self, order: RenderRequest) -> None:
        """Draw this and nothing that was ordered before."""
        with self._condition:
            self._newest = order.request_id
            self._pending = order
            if self._thread is None:
                # The program waits for it at its end: what draws must not be cut off within.
                self._thread = threading.Thread(target=self._work, name="figures")
                self._thread.start()
            self._condition.notify()

    def _work(self) -> None:
        while True:
            with self._condition:
                order = self._next_request()
                if order is None:
                    self._thread = None
                    return
            result: RenderedFigure | Exception
            try:
                result = render_figure(order)
            except Exception as error:
                result = error
            try:
                self._ended.emit(order, result)
            except RuntimeError:
                # The window was closed meanwhile and this object with it.
                return

    def _next_request(self) -> RenderRequest | None:
        """Return the order that waits, or comes soon; None to end, as when the program does."""
        patience = round(_IDLE_SECONDS / _POLL_SECONDS)
        while self._pending is None and patience and threading.main_thread().is_alive():
            self._condition.wait(_POLL_SECONDS)
            patience -= 1
        order, self._pending = self._pending, None
        return order if threading.main_thread().is_alive() else None

    def _end(self, order: RenderRequest, result: RenderedFigure | Exception) -> None:
        if order.request_id != self._newest:
            return
        self._newest = 0
        if isinstance(result, Exception):
            self.failed.emit(order, result)
        else:
            self.drawn.emit(result)
