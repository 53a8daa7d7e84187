"""Find, where simulation and flight disagree, and Name, which effect is missing."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QCheckBox, QVBoxLayout, QWidget

from gsapp.quantities import symbol_markup, trace_color
from gsapp.report.discrepancy_pictures import missing_history
from ui.display_style import DisplayStyle
from ui.gap.gap_selection import GapSelection, find_maneuver_view, list_plot_variables
from ui.gap.gap_text import channel_text, coefficient_text, noise_ratio_text
from ui.gap.gap_view_models import (
    build_alternative_rows,
    build_disagreement_rows,
    build_map_rows,
    build_missing_scatter,
    build_observability_rows,
    build_ranking_rows,
    describe_effect,
    describe_ranking,
    describe_runner_up,
    find_step_effect,
    list_instrument_texts,
)
from ui.gap.gap_widgets import DisagreementMapLegend, DisagreementMapView, RankingView
from ui.gap.search_jobs import SearchResult
from ui.translation import tr
from ui.widgets.analysis_plot import FLIGHT_TIME_LABEL, AnalysisPlot, PlotBand, PlotCurve
from ui.widgets.labels import create_label
from ui.widgets.layout_widgets import (
    HeadedParagraphs,
    LabeledComboBox,
    StackingColumns,
    add_widgets,
)
from ui.widgets.table_view import FittedTableView


class StageView(QWidget):
    """One step of the story."""

    selection_requested = Signal(object)
    """What to look at instead, a `GapSelection`."""

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__()
        self._style = style
        self.result: SearchResult | None = None
        self.selection = GapSelection()
        self.column = QVBoxLayout(self)
        self.column.setContentsMargins(0, 0, 0, 0)

    def show_result(self, result: SearchResult, selection: GapSelection) -> None:
        """Show a result, or another part of it."""
        self.result, self.selection = result, selection
        self.refresh()

    def connect_choice(self, choice: LabeledComboBox, field: str) -> None:
        """Ask for another selection when something is chosen in a list."""

        def choose() -> None:
            change: dict[str, Any] = {field: choice.current_key}
            self.selection_requested.emit(replace(self.selection, **change))

        choice.box.currentIndexChanged.connect(choose)

    def refresh(self) -> None:
        raise NotImplementedError

    def set_initial_focus(self) -> None:
        raise NotImplementedError


class FindStage(StageView):
    """Map, disagreements in words, and the histories behind the chosen cell."""

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__(style)
        pair = StackingColumns(style, (5, 6))
        self.column.addWidget(pair, 1)
        self.map = DisagreementMapView(style)
        self.heading = create_label(tr("Disagreements"), "heading")
        self.lines = FittedTableView(
            style, tr("Disagreements, most significant first"),
            (tr("Maneuver"), tr("What and where")), stretch=1, widths={0: 76}, least=3,
        )  # fmt: skip
        self.empty_label = create_label("", "muted", wrap=True)
        self.detail = create_label("", "hint", wrap=True)
        add_widgets(
            pair.left,
            create_label(tr("Times the noise floor"), "heading"),
            (self.map, 30),
            DisagreementMapLegend(style),
            create_label(tr("A corner marks significant cells."), "hint", wrap=True),
            self.heading,
            (self.lines, 20),
            self.empty_label,
            self.detail,
        )
        pair.left.addStretch(1)
        self.trace = AnalysisPlot(style, tr("Coefficient residual over time"))
        pair.right.addWidget(self.trace, 1)
        self.variable = LabeledComboBox(style, tr("Against"), letters=18)
        pair.right.addWidget(self.variable, 0, Qt.AlignmentFlag.AlignLeft)
        self.cloud = AnalysisPlot(style, tr("Coefficient residual over the region"))
        pair.right.addWidget(self.cloud, 1)
        self.map.cell_selected.connect(self._cell)
        self.lines.opened.connect(self._open)
        self.lines.selectionModel().currentChanged.connect(self._line)
        self.connect_choice(self.variable, "variable")

    def set_initial_focus(self) -> None:
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
        lines = build_disagreement_rows(result, self._style.units)
        self.lines.show_rows(lines)
        self.lines.setVisible(bool(lines))
        self._show_detail()
        instruments = list_instrument_texts(result)
        sentences = (
            [] if lines else [tr("None: residuals are at the noise floor in all maneuvers.")]
        )
        sentences += [tr("Instruments: {words}").format(words=text) for text in instruments]
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
            PlotBand(low=low, high=high, name="" if index else tr("proven"), is_horizontal=False)
            for index, (low, high) in enumerate(picture.spans)
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
        picture = build_missing_scatter(self.result, self.selection, self._style.units)
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
        if self.result is None or not isinstance(key, int):
            return
        one = self.result.discrepancy.disagreements[key]
        wish = replace(self.selection, maneuver=one.maneuver, channel=one.channel)
        if one.coefficient:
            wish = replace(wish, coefficient=one.coefficient)
        if one.region is not None:
            wish = replace(wish, variable=one.region.variable)
        self.selection_requested.emit(wish)


class NameStage(StageView):
    """Competition, alternatives, and what these flights could show."""

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__(style)
        pair = StackingColumns(style, (6, 5))
        self.column.addWidget(pair, 1)
        self.winner = create_label("", "strong", wrap=True)
        self.margin = create_label("", "muted", wrap=True)
        self.ranking = RankingView(style)
        self.hidden_only = QCheckBox(tr("Unobservable only"))
        self.hidden_only.setAccessibleName(tr("Only effects that these flights cannot show"))
        self.observability = FittedTableView(
            style, tr("Observability of each effect"),
            (tr("Effect"), tr("A plausible size shows"), tr("To see it, fly")),
            stretch=2, widths={0: 190, 1: 150}, least=3,
        )  # fmt: skip
        add_widgets(
            pair.left,
            create_label(tr("Candidate effects"), "heading"),
            self.winner,
            self.margin,
            (self.ranking, 30),
            create_label(tr("Observability"), "heading"),
            self.hidden_only,
            (self.observability, 30),
        )
        pair.left.addStretch(1)
        self.effect = create_label("", "heading", wrap=True)
        self.equation = create_label("", "muted", wrap=True)
        self.about, self.alternatives = HeadedParagraphs(style), HeadedParagraphs(style)
        self.same = create_label(tr("Indistinguishable"), "heading")
        add_widgets(
            pair.right, self.effect, self.equation, self.about, self.same, self.alternatives
        )
        pair.right.addStretch(1)
        self.candidate = ""
        self.ranking.row_changed.connect(self._show_effect)
        self.observability.selectionModel().currentChanged.connect(self._seen)
        self.hidden_only.toggled.connect(lambda _on: self._show_observability())

    def set_initial_focus(self) -> None:
        self.ranking.setFocus()

    def refresh(self) -> None:
        result, step = self.result, self.selection.step
        if result is None:
            return
        self.winner.setText(describe_ranking(result, step))
        found = find_step_effect(result, step + 1)
        self.margin.setText(describe_runner_up(result, found) if found is not None else "")
        self.margin.setVisible(found is not None)
        rows = build_ranking_rows(result, step)
        self.ranking.show_rows(rows)
        self.ranking.setVisible(bool(rows))
        self._show_observability()
        current = self.ranking.current_key() or (found.effect if found is not None else "")
        self._show_effect(str(current))
        same = build_alternative_rows(result, self._style.units)
        self.same.setVisible(bool(same))
        self.alternatives.show_paragraphs(
            [(title, " ".join((why, tr("To tell: {fly}.").format(fly=fly))) if fly else why)
             for title, why, fly in same]
        )  # fmt: skip

    def _show_observability(self) -> None:
        if self.result is not None:
            self.observability.show_rows(
                build_observability_rows(self.result, hidden_only=self.hidden_only.isChecked())
            )

    def _seen(self) -> None:
        key = self.observability.current_key()
        if self.observability.hasFocus() and key is not None:
            self._show_effect(str(key))

    def _show_effect(self, effect: str) -> None:
        self.candidate = effect
        if self.result is None or not effect:
            for part in (self.effect, self.equation):
                part.hide()
            self.about.show_paragraphs(())
            return
        equation, paragraphs = describe_effect(self.result, effect)
        self.effect.setText(self.result.title(effect))
        self.effect.show()
        self.equation.setText(equation)
        self.equation.setVisible(bool(equation))
        self.about.show_paragraphs(paragraphs)
