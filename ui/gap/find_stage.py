"""Find: where simulation and flight disagree."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from PySide6.QtCore import Qt

from gsapp.quantities import symbol_markup, trace_color
from gsapp.report.discrepancy_pictures import missing_history
from ui.display_style import DisplayStyle
from ui.gap.gap_selection import find_maneuver_view, list_plot_variables
from ui.gap.gap_tables import DisagreementMapLegend, DisagreementMapView
from ui.gap.gap_text import channel_text, coefficient_text, noise_ratio_text
from ui.gap.gap_view_models import (
    build_disagreement_rows,
    build_map_rows,
    build_missing_scatter,
    list_instrument_texts,
)
from ui.gap.stage_view import StageView
from ui.translation import tr
from ui.widgets.analysis_plot import FLIGHT_TIME_LABEL, AnalysisPlot, PlotBand, PlotCurve
from ui.widgets.labels import create_label
from ui.widgets.layout_widgets import LabeledComboBox, StackingColumns
from ui.widgets.table_view import FittedTableView


class FindStage(StageView):
    """Map, disagreements in words, and the histories behind the chosen cell."""

    def __init__(self, look: DisplayStyle) -> None:
        super().__init__(look)
        pair = StackingColumns(look, (5, 6))
        self.column.addWidget(pair, 1)
        pair.left.addWidget(create_label(tr("Times the noise floor"), "heading"))
        self.map = DisagreementMapView(look)
        pair.left.addWidget(self.map, 30)
        pair.left.addWidget(DisagreementMapLegend(look))
        pair.left.addWidget(
            create_label(tr("A corner marks significant cells."), "hint", wrap=True)
        )
        self.heading = create_label(tr("Disagreements"), "heading")
        pair.left.addWidget(self.heading)
        self.lines = FittedTableView(
            look, tr("Disagreements, most significant first"),
            (tr("Maneuver"), tr("What and where")), stretch=1, widths={0: 76}, least=3,
        )  # fmt: skip
        pair.left.addWidget(self.lines, 20)
        self.empty_label = create_label("", "muted", wrap=True)
        pair.left.addWidget(self.empty_label)
        self.detail = create_label("", "hint", wrap=True)
        pair.left.addWidget(self.detail)
        pair.left.addStretch(1)
        self.trace = AnalysisPlot(look, tr("Coefficient residual over time"))
        pair.right.addWidget(self.trace, 1)
        self.variable = LabeledComboBox(look, tr("Against"), letters=18)
        pair.right.addWidget(self.variable, 0, Qt.AlignmentFlag.AlignLeft)
        self.cloud = AnalysisPlot(look, tr("Coefficient residual over the region"))
        pair.right.addWidget(self.cloud, 1)
        self.map.cell_selected.connect(self._cell)
        self.lines.opened.connect(self._open)
        self.lines.selectionModel().currentChanged.connect(self._line)
        self.variable.box.currentIndexChanged.connect(
            lambda _index: self.selection_requested.emit(
                replace(self.selection, variable=self.variable.current_key)
            )
        )

    def begin(self) -> None:
        self.map.setFocus()

    def refresh(self) -> None:
        result, selection = self.result, self.selection
        if result is None:
            return
        self.map.show_map(
            result.discrepancy.coefficients,
            build_map_rows(result, selection.step),
            selection.maneuver,
            selection.coefficient,
        )
        lines = build_disagreement_rows(result, self.look.units)
        self.lines.show_rows(lines)
        self.lines.setVisible(bool(lines))
        self._show_detail()
        instruments = list_instrument_texts(result)
        sentences = (
            [] if lines else [tr("None: residuals are at the noise floor in all maneuvers.")]
        )
        sentences += [tr("Instruments: {words}").format(words=words) for words in instruments]
        self.empty_label.setText("\n".join(sentences))
        self.empty_label.setVisible(bool(sentences))
        view = find_maneuver_view(result, selection.maneuver)
        if view is not None:
            choices = [(name, channel_text(name)) for name in list_plot_variables(view)]
            self.variable.set_choices(choices, selection.variable)
        self._draw_trace()
        self._draw_cloud()

    def _draw_trace(self) -> None:
        if self.result is None:
            return
        found, chosen = self.result.discrepancy, self.selection
        view = find_maneuver_view(self.result, chosen.maneuver)
        if view is None or chosen.coefficient not in view.coefficients:
            return
        picture = missing_history(found, view, chosen.coefficient, chosen.step)
        title = tr("Missing {coefficient}, maneuver {id}").format(
            coefficient=coefficient_text(chosen.coefficient), id=view.id
        )
        curves = []
        missing, name = picture.before, tr("missing")
        if picture.after is not None:
            missing, name = picture.after, tr("residual")
            curves.append(
                PlotCurve(x=picture.times, y=picture.before, color="previous", name=tr("baseline"),
                      dashed=True)
            )  # fmt: skip
        curves.append(
            PlotCurve(x=picture.times, y=missing, name=name, color=trace_color(chosen.coefficient))
        )
        bands = [PlotBand(low=-picture.floor, high=picture.floor, name=tr("noise floor"))]
        bands += [
            PlotBand(low=low, high=high, name="" if place else tr("proven"), is_horizontal=False)
            for place, (low, high) in enumerate(picture.spans)
        ]
        cell = self.map.cell(self.selection.maneuver, self.selection.coefficient)
        ratio = float("nan") if cell is None else cell.ratio
        self.trace.draw(
            curves,
            bands,
            title=title,
            bottom=FLIGHT_TIME_LABEL,
            left=symbol_markup(self.selection.coefficient),
            words=tr("{title}: {ratio} times the noise floor").format(
                title=title, ratio=noise_ratio_text(ratio)
            ),
        )

    def _draw_cloud(self) -> None:
        if self.result is None:
            return
        picture = build_missing_scatter(self.result, self.selection, self.look.units)
        self.cloud.setVisible(picture is not None)
        if picture is None:
            return
        curves = []
        if picture.others:
            # As one cloud: drawn at once, and quickly.
            x, y = (np.concatenate(parts) for parts in zip(*picture.others, strict=True))
            curves.append(
                PlotCurve(x=x, y=y, color="previous", name=tr("other maneuvers"), points=True)
            )
        here = tr("maneuver {maneuver}").format(maneuver=self.selection.maneuver)
        curves.append(
            PlotCurve(
                x=picture.selected[0], y=picture.selected[1], name=here, points=True,
                color=trace_color(self.selection.coefficient),
            )
        )  # fmt: skip
        bands = [PlotBand(low=-picture.floor, high=picture.floor)]
        if picture.region is not None:
            low, high = picture.region
            bands.append(PlotBand(low=low, high=high, name=tr("largest here"), is_horizontal=False))
        unit = f", {picture.unit}" if picture.unit else ""
        self.cloud.draw(
            curves,
            bands,
            title=picture.title,
            bottom=f"{picture.axis}{unit}",
            left=symbol_markup(self.selection.coefficient),
            words=tr("{coefficient} against {axis}").format(
                coefficient=coefficient_text(self.selection.coefficient), axis=picture.axis
            ),
        )

    def _cell(self, maneuver: str, coefficient: str) -> None:
        self.selection_requested.emit(
            replace(self.selection, maneuver=maneuver, coefficient=coefficient)
        )

    def _line(self) -> None:
        self._show_detail()
        if self.lines.hasFocus():
            self._open(self.lines.current_key())

    def _show_detail(self) -> None:
        row = self.lines.currentIndex().row()
        self.detail.setText(self.lines.row_model.rows[row].detail if row >= 0 else "")

    def _open(self, key: object) -> None:
        """Look at a disagreement."""
        if self.result is None or not isinstance(key, int):
            return
        one = self.result.discrepancy.disagreements[key]
        wish = replace(self.selection, maneuver=one.maneuver, channel=one.channel)
        if one.coefficient:
            wish = replace(wish, coefficient=one.coefficient)
        if one.region is not None:
            wish = replace(wish, variable=one.region.variable)
        self.selection_requested.emit(wish)
