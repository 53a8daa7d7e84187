"""Show: before and after, on maneuvers that neither naming nor fitting has seen."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from PySide6.QtGui import QAction, QResizeEvent

from gsapp.quantities import trace_color
from gsapp.report.discrepancy_pictures import channel_gaps, channel_overlay, waterfall_steps
from ui.display_style import DisplayStyle
from ui.gap.gap_bars import ChannelGapBars, MisfitWaterfall
from ui.gap.gap_selection import find_maneuver_view, list_model_names
from ui.gap.gap_text import axis_unit, channel_text, gap_closed_text, join_with_and, maneuver_text
from ui.gap.gap_view_models import (
    build_gap_rows,
)
from ui.gap.stage_view import StageView
from ui.translation import tr
from ui.widgets.action_button import ActionButton
from ui.widgets.analysis_plot import FLIGHT_TIME_LABEL, AnalysisPlot, PlotBand, PlotCurve
from ui.widgets.labels import create_label
from ui.widgets.layout_widgets import LabeledComboBox, StackingColumns, create_button_row
from ui.widgets.table_view import FittedTableView

_ALL_COLUMNS_WIDTH = 620
_NOISE_COLUMN = 2


class ShowStage(StageView):
    """Overlay, what is left of it, bars per channel, waterfall and numbers."""

    def __init__(self, look: DisplayStyle, actions: Mapping[str, QAction]) -> None:
        super().__init__(look)
        pair = StackingColumns(look, (7, 5))
        self.column.addWidget(pair, 1)
        self.maneuver = LabeledComboBox(look, tr("Maneuver"), letters=32)
        self.channel = LabeledComboBox(look, tr("Channel"), letters=16)
        self.buttons = {
            "gap_report": ActionButton(actions["gap_report"], tr("Write the report…"), look),
            "gap_save": ActionButton(actions["gap_save"], tr("Save the model…"), look),
        }
        pair.left.addWidget(create_button_row(look, self.maneuver, self.channel))
        self.overlay = AnalysisPlot(look, tr("Measured and simulated"))
        pair.left.addWidget(self.overlay, 3)
        self.rest = AnalysisPlot(look, tr("Residual"), high=132)
        pair.left.addWidget(self.rest, 2)
        self.closed = create_label("", "heading", wrap=True)
        pair.right.addWidget(self.closed)
        self.on = create_label("", "muted", wrap=True)
        pair.right.addWidget(self.on)
        pair.right.addWidget(
            create_label(tr("Gap per channel: gray before, color after"), "strong", wrap=True)
        )
        self.bars = ChannelGapBars(look)
        pair.right.addWidget(self.bars)
        pair.right.addWidget(create_label(tr("All channels by step"), "strong"))
        self.waterfall = MisfitWaterfall(look)
        pair.right.addWidget(self.waterfall)
        pair.right.addWidget(create_button_row(look, *self.buttons.values()))
        pair.right.addStretch(1)
        self.numbers_heading = create_label("", "heading", wrap=True)
        self.column.addWidget(self.numbers_heading)
        self.numbers = FittedTableView(
            look, tr("Numbers of each channel"),
            (tr("Channel"), "RMS", tr("Noise"), tr("of range"), "Theil", tr("In 3 floors")),
            stretch=0, widths={1: 140, 2: 68, 3: 104, 4: 120, 5: 112},
            right=frozenset({1, 2, 3, 4, 5}), least=5, most=12,
        )  # fmt: skip
        self.column.addWidget(self.numbers)
        self.maneuver.box.currentIndexChanged.connect(
            lambda _index: self.selection_requested.emit(
                replace(self.selection, maneuver=self.maneuver.current_key)
            )
        )
        self.channel.box.currentIndexChanged.connect(
            lambda _index: self.selection_requested.emit(
                replace(self.selection, channel=self.channel.current_key)
            )
        )

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        narrow = self.width() < self.look.px(_ALL_COLUMNS_WIDTH)
        self.numbers.setColumnHidden(_NOISE_COLUMN, narrow)

    def begin(self) -> None:
        self.maneuver.box.setFocus()

    def refresh(self) -> None:
        result, selection = self.result, self.selection
        if result is None:
            return
        found = result.discrepancy
        self.maneuver.set_choices(
            [(view.id, maneuver_text(result, view)) for view in found.maneuvers], selection.maneuver
        )
        self.channel.set_choices(
            [(name, channel_text(name)) for name in found.channels], selection.channel
        )
        self._draw_overlay()
        gap = found.gap
        self.closed.setText(f"{gap_closed_text(gap.closed, gap.closed_std)}.")
        kept = tr("No held-out maneuver: fly one more of each kind.")
        if gap.on:
            kept = tr("Validated on maneuvers {names}, held out of the search.").format(
                names=join_with_and(gap.on)
            )
        self.on.setText(tr("From the baseline to the last effect. {kept}").format(kept=kept))
        self.bars.show_pairs(channel_gaps(found, selection.step))
        self.waterfall.show_steps(waterfall_steps(found), list_model_names(result), selection.step)
        lines = build_gap_rows(result, self.look.units)
        self.numbers.setMaximumWidth(self.look.px(760))
        self.numbers.show_rows(lines)
        self.numbers.setVisible(bool(lines))
        self.numbers_heading.setText(tr("Baseline → last effect, held-out maneuvers"))
        self.numbers_heading.setVisible(bool(lines))

    def _draw_overlay(self) -> None:
        result, selection = self.result, self.selection
        view = find_maneuver_view(result, selection.maneuver) if result else None
        shown = view is not None and selection.channel in view.channels
        for chart in (self.overlay, self.rest):
            chart.setVisible(shown)
        if result is None or view is None or not shown:
            return
        picture = channel_overlay(view, selection.channel, self.look.units, selection.step)
        name = list_model_names(result)[selection.step]
        axis, unit = channel_text(selection.channel), axis_unit(selection.channel, self.look.units)
        left = f"{axis.split(', ')[0]}{f', {unit}' if unit else ''}"
        kept = tr("held out") if view.held_out else tr("used in the search")
        color = trace_color(selection.channel)
        curves = [
            PlotCurve(x=picture.times, y=picture.before, color="previous", name=tr("baseline"),
                  dashed=True),
            PlotCurve(x=picture.times, y=picture.measured, color=color, name=tr("measured")),
        ]  # fmt: skip
        rests = [
            PlotCurve(x=picture.times, y=picture.measured - picture.before, color="previous",
                  name=tr("baseline"), dashed=True)
        ]  # fmt: skip
        if picture.after is not None:
            curves.append(
                PlotCurve(x=picture.times, y=picture.after, color="text", name=name, dashed=True)
            )
            rests.append(
                PlotCurve(x=picture.times, y=picture.measured - picture.after, color=color,
                      name=name)
            )  # fmt: skip
        title = tr("Maneuver {id}, {kept}").format(id=view.id, kept=kept)
        self.overlay.draw(curves, title=title, bottom=FLIGHT_TIME_LABEL, left=left)
        self.rest.draw(
            rests,
            [PlotBand(low=-picture.floor, high=picture.floor, name=tr("noise floor"))],
            title=tr("Residual: {axis}").format(axis=axis),
            bottom=FLIGHT_TIME_LABEL,
            left=left,
        )
