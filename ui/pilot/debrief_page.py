"""The debrief: every maneuver with verdict, reason and charts; score by card; trends."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Final

import numpy as np
from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QAction, QKeyEvent, QPainter, QPaintEvent, QResizeEvent
from PySide6.QtWidgets import QGridLayout, QHBoxLayout, QScrollArea, QVBoxLayout, QWidget

from gsapp.excitation.debrief import Debrief, EvaluatedManeuver, FlightTrend
from gsapp.quantities import (
    SURFACE_NAMES,
    FloatArray,
    channel,
    convert_text_units,
    from_si,
    trace_color,
)
from ui.commands import shortcut_text
from ui.display_style import DisplayStyle
from ui.icons import IndicatorState
from ui.number_format import (
    DASH,
    channel_value_text,
    clock_text,
    count_text,
    duration_text,
    number_text,
    percent_text,
    symbol_text,
    unit_text,
)
from ui.pilot.cue_display import RESULT_SIGNS, surfaces_text
from ui.translation import QT_TR_NOOP, tr
from ui.widgets.analysis_plot import FLIGHT_TIME_LABEL, AnalysisPlot, PlotBand, PlotCurve
from ui.widgets.labels import create_label
from ui.widgets.paint_primitives import paint_focus_frame
from ui.widgets.status_list import StatusListItem, StatusListView
from ui.widgets.table_menu import create_table_actions

_RESULT_STATES: Final[Mapping[str, IndicatorState]] = {"good": "good", "unclear": "unknown"}
"""Signs of verdicts; all others are a caution."""


def debrief_headline(debrief: Debrief | None) -> str:
    """Return how the flight went, in one line."""
    if debrief is None:
        return tr("No flight with cues is open")
    flown = len(debrief.maneuvers)
    good = (
        tr("{good} of {inputs} good").format(good=debrief.good, inputs=count_text(flown, "input"))
        if flown
        else tr("no inputs yet")
    )
    text = f"{debrief.flight}: {good}"
    if debrief.score is not None:
        text += tr(" · {score} of the card set").format(score=percent_text(debrief.score))
    return text


def build_maneuver_item(judged: EvaluatedManeuver, units: str) -> StatusListItem:
    """Return one maneuver as a line of the list."""
    verdict = judged.verdict
    speed = "" if verdict.V is None else f", {channel_value_text(channel('V'), verdict.V, units)}"
    counts = tr("counts") if verdict.counts else ""
    return StatusListItem(
        key=verdict.id,
        text=f"{verdict.id}  {surfaces_text(verdict.surfaces)} {verdict.kind}",
        detail=f"{clock_text(verdict.t_input, decimals=1)}{speed}: {verdict.advice}",
        state=_RESULT_STATES.get(verdict.result, "caution"),
        state_text=tr(RESULT_SIGNS[verdict.result][0]).lower(),
        note=" ".join(filter(None, (verdict.card, counts))),
    )


def list_verdict_reasons(judged: EvaluatedManeuver, units: str) -> tuple[str, ...]:
    """Return why a maneuver got its verdict, and what was measured of it, as sentences."""
    verdict = judged.verdict
    said = [finding.words for finding in verdict.findings] or [tr("no objection")]
    said += [_input_shape_text(judged, name, units) for name in verdict.surfaces]
    moved = [f"{SURFACE_NAMES.get(name, name)} {_angle_text(name, size, units)}"
             for name, size in verdict.cross.items()]  # fmt: skip
    if moved:
        said.append(tr("also moved: {moved}").format(moved=", ".join(moved)))
    said.append(_input_start_text(judged))
    said += verdict.judged_by
    return tuple(said)


def _input_shape_text(judged: EvaluatedManeuver, name: str, units: str) -> str:
    verdict, wanted = judged.verdict, judged.target_input
    text = SURFACE_NAMES.get(name, name)
    if name in verdict.amplitudes:
        text += f" {_angle_text(name, verdict.amplitudes[name], units)}"
    if wanted is not None and name in wanted.amplitudes:
        band = wanted.amplitudes[name]
        low, high = (_angle_text(name, limit, units) for limit in (band.low, band.high))
        text += tr(" (wanted {low} to {high})").format(low=low, high=high)
    halves = verdict.halves.get(name, ())
    if halves:
        text += tr(", steps of {steps} s").format(
            steps=", ".join(number_text(step, 2) for step in halves)
        )
    if name in verdict.symmetry:
        text += tr(", halves symmetric to {percent}").format(
            percent=percent_text(verdict.symmetry[name])
        )
    if name in verdict.left_over:
        text += tr(", {percent} residual").format(percent=percent_text(verdict.left_over[name]))
    return text


def _angle_text(name: str, value: float, units: str) -> str:
    return channel_value_text(channel(name), value, units)


def _input_start_text(judged: EvaluatedManeuver) -> str:
    go = judged.go_at
    begun = judged.verdict.t_input
    text = (
        tr("started without GO")
        if go is None
        else tr("begun {duration} after GO").format(duration=duration_text(begun - go))
    )
    off = [f"{name} {number_text(share, 1)}" for name, share in judged.trim_deviations.items()]
    return (
        tr("{words}; deviations in tolerances: {off}").format(words=text, off=", ".join(off))
        if off
        else text
    )


CARD_COLUMN_TITLES: Final = (
    QT_TR_NOOP("Card"), "", QT_TR_NOOP("Good"), QT_TR_NOOP("Flown"), QT_TR_NOOP("Wanted"),
)  # fmt: skip


def build_card_rows(debrief: Debrief | None) -> tuple[tuple[str, ...], ...]:
    """Return the score by card as rows of a table."""
    cards = () if debrief is None else debrief.cards
    return tuple(
        (one.card, one.title, str(one.good), str(one.flown), str(one.requested)) for one in cards
    )


TREND_COLUMN_TITLES: Final = (
    QT_TR_NOOP("Flight"), QT_TR_NOOP("Good"), QT_TR_NOOP("Cards"),
    QT_TR_NOOP("Size flown / target"), QT_TR_NOOP("Trim deviation at start"), QT_TR_NOOP("Apart"),
)  # fmt: skip


def build_trend_rows(trends: Sequence[FlightTrend]) -> tuple[tuple[str, ...], ...]:
    """Return flights in a row as rows of a table, the newest first."""
    return tuple(
        (
            one.flight,
            tr("{good} of {inputs}").format(good=one.good, inputs=one.inputs),
            percent_text(one.score),
            _share_texts(
                {SURFACE_NAMES.get(name, name): value for name, value in one.amplitudes.items()}
            ),
            _share_texts(one.trim_errors),
            duration_text(one.seconds_each),
        )
        for one in reversed(trends)
    )


def _share_texts(values: Mapping[str, float]) -> str:
    return ", ".join(f"{name} {number_text(value, 1)}" for name, value in values.items()) or DASH


_MAX_SURFACES: Final = 2
"""Surfaces that are drawn; no input moves more of them on purpose."""
_RATE_CHANNELS: Final = ("p", "q", "r")
_MIN_CHART_HEIGHT: Final = 150


class ManeuverCharts(QWidget):
    """The charts of one maneuver."""

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__()
        self._style = style
        self._grid = QGridLayout(self)
        self._grid.setContentsMargins(0, 0, 0, 0)
        self.surfaces = [
            AnalysisPlot(
                style, tr("Surface {place}").format(place=place + 1), high=_MIN_CHART_HEIGHT
            )
            for place in range(_MAX_SURFACES)
        ]
        self.response = AnalysisPlot(style, tr("Response"), high=_MIN_CHART_HEIGHT)
        for place, chart in enumerate(self.surfaces):
            self._grid.addWidget(chart, 0, place)
        self._grid.addWidget(self.response, 1, 0, 1, _MAX_SURFACES)

    def show_maneuver(self, judged: EvaluatedManeuver) -> None:
        self._grid.setSpacing(self._style.px(8))
        shown = [name for name in judged.verdict.surfaces if name in judged.curves.series]
        for chart, name in zip(self.surfaces, (*shown, "", ""), strict=False):
            chart.setVisible(bool(name))
            if name:
                self._draw_surface(chart, judged, name)
        self._draw_response(judged)

    def _draw_surface(self, chart: AnalysisPlot, judged: EvaluatedManeuver, name: str) -> None:
        values = judged.curves.series[name]
        moved = self._to_display(name, values - values[0])
        bands = []
        wanted = None if judged.target_input is None else judged.target_input.amplitudes.get(name)
        if wanted is not None:
            low, high = self._to_display(name, np.array([wanted.low, wanted.high])).tolist()
            bands = [
                PlotBand(low=low, high=high, name=tr("wanted"), is_target=True),
                PlotBand(low=-high, high=-low, is_target=True),
            ]
        title = SURFACE_NAMES.get(name, name).capitalize()
        curve = PlotCurve(x=judged.curves.times, y=moved, color=trace_color(name), name=tr("moved"))
        chart.draw(
            [curve],
            [*bands, self._hands_off(judged)],
            title=title,
            bottom=FLIGHT_TIME_LABEL,
            left=tr("From trim [{unit}]").format(unit=self._unit(name)),
            words=tr("{title} of {id}").format(title=title, id=judged.verdict.id),
        )

    def _draw_response(self, judged: EvaluatedManeuver) -> None:
        names = [name for name in _RATE_CHANNELS if name in judged.curves.series]
        curves = [
            PlotCurve(
                x=judged.curves.times,
                y=self._to_display(name, judged.curves.series[name]),
                color=trace_color(name),
                name=symbol_text(channel(name).symbol),
            )
            for name in names
        ]
        unit = self._unit("q")
        self.response.draw(
            curves,
            [self._hands_off(judged)],
            title=tr("Response") if curves else tr("Response not measured"),
            bottom=FLIGHT_TIME_LABEL,
            left=tr("Rate [{unit}]").format(unit=unit),
            words=tr("Rates of {id}").format(id=judged.verdict.id),
        )

    def _hands_off(self, judged: EvaluatedManeuver) -> PlotBand:
        verdict = judged.verdict
        return PlotBand(
            low=verdict.t_input_end,
            high=verdict.t_end,
            name=tr("hands off"),
            is_horizontal=False,
        )

    def _unit(self, name: str) -> str:
        return unit_text(channel(name).display_unit(self._style.units))

    def _to_display(self, name: str, values: FloatArray) -> FloatArray:
        spec = channel(name)
        return from_si(values, spec.display_unit(self._style.units), spec.quantity)


class TextTable(QWidget):
    """A heading, heads of columns, rows; or a sentence where there are none."""

    def __init__(self, style: DisplayStyle, title: str, heads: Sequence[str], stretch: int) -> None:
        super().__init__()
        self._style = style
        self._heads = tuple(map(tr, heads))
        self._rows: tuple[tuple[str, ...], ...] | None = None
        self._stretch = stretch
        self.setAccessibleName(title)
        self._column = column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(create_label(title, "heading", wrap=True))
        self.empty_label = create_label("", "muted", wrap=True)
        column.addWidget(self.empty_label)
        self._holder = QWidget()
        column.addWidget(self._holder)
        self.addActions(create_table_actions(self, lambda: (self._heads, *(self._rows or ()))))
        self.setContextMenuPolicy(Qt.ContextMenuPolicy.ActionsContextMenu)
        self.setFocusPolicy(Qt.FocusPolicy.TabFocus)  # For the menu key.

    def paintEvent(self, event: QPaintEvent) -> None:
        super().paintEvent(event)
        if self.hasFocus():
            painter = QPainter(self)
            paint_focus_frame(painter, self.rect(), self._style)
            painter.end()

    def show_rows(self, rows: Sequence[Sequence[str]], none: str) -> None:
        units = self._style.units
        made = tuple(tuple(convert_text_units(cell, units) for cell in row) for row in rows)
        self.empty_label.setText(none)
        self.empty_label.setVisible(not made)
        if made == self._rows:
            return
        self._rows = made
        # Never without a parent: it would be a window of its own for a moment.
        holder = QWidget(self)
        grid = QGridLayout(holder)
        grid.setContentsMargins(0, 0, 0, 0)
        grid.setHorizontalSpacing(self._style.px(16))
        grid.setVerticalSpacing(self._style.px(6))
        grid.setColumnStretch(self._stretch, 1)
        for index, head in enumerate(self._heads):
            grid.addWidget(create_label(head, "label", wrap=index == self._stretch), 0, index)
        for line, row in enumerate(made, start=1):
            for index, text in enumerate(row):
                cell = create_label(
                    text, "strong" if index == 0 else "", wrap=index >= self._stretch
                )
                grid.addWidget(cell, line, index, Qt.AlignmentFlag.AlignTop)
        holder.setVisible(bool(made))
        self._column.replaceWidget(self._holder, holder)
        self._holder.hide()
        self._holder.deleteLater()
        self._holder = holder
        self.setAccessibleDescription("; ".join(", ".join(row) for row in made) or none)


_SIDE_BY_SIDE_WIDTH: Final = 760
"""Points of width from which list and maneuver stand side by side."""
_SCROLL_STEP: Final = 60


class DebriefPage(QWidget):
    """Goes through the maneuvers of the open flight by keys."""

    changed = Signal()

    def __init__(self, style: DisplayStyle, commands: Sequence[QAction] = ()) -> None:
        super().__init__()
        self.setObjectName("page")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.setAccessibleName(tr("Debrief"))
        self._style = style
        self.debrief: Debrief | None = None
        self._shown: tuple[object, ...] = ()
        self._reading = False
        outer = QVBoxLayout(self)
        self.headline = create_label("", "heading", wrap=True)
        outer.addWidget(self.headline)
        self._row = QHBoxLayout()
        outer.addLayout(self._row, 1)
        self._outer = outer
        self.list = StatusListView(style, tr("Maneuvers"), commands)
        self.list.current_item_changed.connect(lambda _key: self._show_maneuver())
        self.list.item_activated.connect(lambda _key: self.focus_maneuver())
        self._row.addWidget(self.list, 2)
        self.scroll_area = QScrollArea()
        self.scroll_area.setProperty("role", "read")
        self.scroll_area.setWidgetResizable(True)
        self.scroll_area.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.scroll_area.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.scroll_area.setAccessibleName(tr("The maneuver, the cards, the flights"))
        self._row.addWidget(self.scroll_area, 3)
        body = QWidget()
        body.setObjectName("page")
        self._column = QVBoxLayout(body)
        self.title = create_label("", "title", wrap=True)
        self.reasons = create_label("", wrap=True, remarks_in=style)
        self.charts = ManeuverCharts(style)
        self.cards = TextTable(style, tr("Score by card"), CARD_COLUMN_TITLES, 1)
        self.trends = TextTable(style, tr("From flight to flight"), TREND_COLUMN_TITLES, 3)
        for part in (self.title, self.reasons, self.charts, self.cards, self.trends):
            self._column.addWidget(part)
        self._column.addStretch(1)
        self.scroll_area.setWidget(body)
        style.changed.connect(self._restyle)
        self._restyle()

    def _restyle(self) -> None:
        px = self._style.px
        self._outer.setContentsMargins(px(16), px(12), px(8), px(4))
        self._outer.setSpacing(px(8))
        self._row.setSpacing(px(12))
        self._column.setContentsMargins(0, 0, px(8), px(8))
        self._column.setSpacing(px(12))
        self._fit()
        self._shown = ()
        self.show_debrief(self.debrief)

    # What it shows

    def show_debrief(self, debrief: Debrief | None) -> None:
        self.debrief = debrief
        maneuvers = () if debrief is None else debrief.maneuvers
        state = (
            debrief is None, tuple(id(one) for one in maneuvers),
            () if debrief is None else debrief.cards, self._style.units,
        )  # fmt: skip
        if state == self._shown:
            return
        self._shown = state
        self.headline.setText(debrief_headline(debrief))
        self.list.set_items([build_maneuver_item(one, self._style.units) for one in maneuvers])
        self.cards.show_rows(build_card_rows(debrief), tr("This flight has no test cards."))
        self._show_maneuver()
        self.changed.emit()

    def show_trends(self, trends: Sequence[FlightTrend]) -> None:
        self.trends.show_rows(
            build_trend_rows(trends),
            tr("No flight in the catalog. {keys} saves this one.").format(
                keys=shortcut_text("Ctrl+S")
            ),
        )

    @property
    def current_maneuver(self) -> EvaluatedManeuver | None:
        maneuvers = () if self.debrief is None else self.debrief.maneuvers
        key = self.list.current_key
        return next((one for one in maneuvers if one.verdict.id == key), None)

    def _show_maneuver(self) -> None:
        judged = self.current_maneuver
        self.charts.setVisible(judged is not None)
        self.reasons.setVisible(judged is not None)
        if judged is None:
            self.title.setText(tr("Inputs are listed here as they are flown"))
            return
        line = build_maneuver_item(judged, self._style.units)
        self.title.setText(f"{line.text}: {line.state_text}")
        self.reasons.setText(
            "\n".join(f"· {text}" for text in list_verdict_reasons(judged, self._style.units))
        )
        self.charts.show_maneuver(judged)
        self.changed.emit()

    # Keys

    def set_initial_focus(self) -> None:
        self._reading = False
        self._fit()
        self.list.setFocus()

    def focus_maneuver(self) -> None:
        """Go from the list to the maneuver; Esc comes back."""
        self._reading = True
        self._fit()
        self.scroll_area.setFocus()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit()

    def _fit(self) -> None:
        wide = self.width() >= self._style.px(_SIDE_BY_SIDE_WIDTH)
        self.list.setVisible(wide or not self._reading)
        self.scroll_area.setVisible(wide or self._reading)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        bar = self.scroll_area.verticalScrollBar()
        steps: dict[Qt.Key, Callable[[], int]] = {
            Qt.Key.Key_Down: lambda: self._style.px(_SCROLL_STEP),
            Qt.Key.Key_Up: lambda: -self._style.px(_SCROLL_STEP),
            Qt.Key.Key_PageDown: bar.pageStep,
            Qt.Key.Key_PageUp: lambda: -bar.pageStep(),
        }
        key = Qt.Key(event.key())
        if key == Qt.Key.Key_Escape:
            self.set_initial_focus()
        elif key in steps:
            bar.setValue(bar.value() + steps[key]())
        else:
            super().keyPressEvent(event)
