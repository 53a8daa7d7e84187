"""Add, what the model becomes with effects forced or refused, and Show, what that is worth."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from PySide6.QtCore import Qt
from PySide6.QtGui import QAction, QKeyEvent, QResizeEvent
from PySide6.QtWidgets import QCheckBox, QLineEdit, QVBoxLayout, QWidget

from gsapp.discrepancy.results import DiscrepancyResult
from gsapp.quantities import trace_color
from gsapp.quantities.notation import symbol_markup
from gsapp.report.discrepancy_pictures import (
    channel_gaps,
    channel_overlay,
    structure_curves,
    variable_unit,
    waterfall_steps,
)
from ui.dialogs.form_dialog import FieldMessage, FormDialog
from ui.display_style import DisplayStyle
from ui.gap.find_and_name import StageView
from ui.gap.gap_selection import find_maneuver_view, list_model_names
from ui.gap.gap_text import (
    axis_unit,
    channel_text,
    effect_confidence_text,
    gap_closed_text,
    join_with_and,
    maneuver_text,
    signed_number_text,
)
from ui.gap.gap_view_models import (
    ForceableEffect,
    build_changed_value_rows,
    build_effect_status_rows,
    build_gap_rows,
    build_parameter_rows,
    describe_runner_up,
)
from ui.gap.gap_widgets import ChannelGapBars, MisfitWaterfall
from ui.translation import QT_TR_NOOP, tr
from ui.widgets.action_button import ActionButton
from ui.widgets.analysis_plot import FLIGHT_TIME_LABEL, AnalysisPlot, PlotBand, PlotCurve
from ui.widgets.labels import create_label
from ui.widgets.layout_widgets import (
    LabeledComboBox,
    NameValueTable,
    StackingColumns,
    add_widgets,
    create_button_row,
)
from ui.widgets.row_model import TableRow
from ui.widgets.table_view import BoxedListView, FittedTableView


class _SearchEdit(QLineEdit):
    """Typed words narrow the list; Up and Down move in it meanwhile."""

    def __init__(self, listed: QWidget) -> None:
        super().__init__()
        self._listed = listed

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() in (Qt.Key.Key_Up, Qt.Key.Key_Down):
            self._listed.keyPressEvent(event)
        else:
            super().keyPressEvent(event)


class ForceEffectDialog(FormDialog):
    """Asks which effect shall be put into the model."""

    def __init__(
        self, style: DisplayStyle, choices: Sequence[ForceableEffect], parent: QWidget | None = None
    ) -> None:
        super().__init__(
            tr("Force another effect"),
            tr(
                "Adds the effect regardless of its evidence and refits all values. Undo removes it."
            ),
            tr("Force"),
            style,
            parent,
        )
        self.listed = BoxedListView(style, tr("Effects"))
        self.search = _SearchEdit(self.listed)
        self.search.setPlaceholderText(tr("Search the effects"))
        self.search.setAccessibleName(tr("Search the effects"))
        self.search.setClearButtonEnabled(True)
        self.search.textChanged.connect(self._filter)
        self.note = FieldMessage()
        self._rows = [
            TableRow(
                key=one.effect,
                cells=(f"{one.title}   ({one.effect})",),
                detail=f"{one.title}   ({one.effect})\n{one.reason}".strip(),
                value=one,
            )
            for one in choices
        ]
        holder = QWidget()
        column = QVBoxLayout(holder)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(style.px(8))
        column.addWidget(self.search)
        column.addWidget(self.listed)
        holder.setFocusProxy(self.search)
        self.add_row(tr("Effect"), holder, self.note)
        self.listed.row_changed.connect(lambda _key: self._validate())
        self.listed.doubleClicked.connect(lambda _index: self.accept())
        self._filter("")
        # As high with few matches as with all.
        self.listed.setFixedHeight(style.px(224))
        self.fit_to_content()

    def _filter(self, text: str) -> None:
        wanted = text.lower().split()
        self.listed.show_rows(
            [row for row in self._rows if all(word in row.cells[0].lower() for word in wanted)]
        )
        if self.listed.row_model.rows and self.listed.current_key() is None:
            self.listed.selectRow(0)
        self._validate()

    def _validate(self) -> None:
        chosen = self.selected_effect
        self.button.setEnabled(chosen is not None)
        if chosen is None:
            self.note.set_message(tr("No such effect."), "warning")
        else:
            self.note.set_message(chosen.reason or tr("Not a candidate here."))

    @property
    def selected_effect(self) -> ForceableEffect | None:
        row = self.listed.currentIndex().row()
        return self.listed.row_model.rows[row].value if row >= 0 else None


_BUTTONS = (
    ("gap_accept", QT_TR_NOOP("Accept next")),
    ("gap_refuse", QT_TR_NOOP("Refuse")),
    ("gap_force", QT_TR_NOOP("Force another…")),
    ("undo", QT_TR_NOOP("Undo")),
    ("redo", QT_TR_NOOP("Redo")),
    ("gap_save", QT_TR_NOOP("Save the model…")),
)


class AddStage(StageView):
    """Effects and values of the revised model, with the buttons that decide."""

    def __init__(self, style: DisplayStyle, actions: Mapping[str, QAction]) -> None:
        super().__init__(style)
        self.buttons = {
            name: ActionButton(actions[name], tr(text), style) for name, text in _BUTTONS
        }
        self.buttons["gap_accept"].setProperty("role", "primary")
        pair = StackingColumns(style, (6, 5))
        self.column.addWidget(pair, 1)
        self.effects = FittedTableView(
            style, tr("Effects: in the model, next, rejected"),
            (tr("Step"), tr("Effect"), tr("State")), stretch=1, widths={0: 52, 2: 150}, least=3,
        )  # fmt: skip
        self.empty_label = create_label("", "muted", wrap=True)
        add_widgets(
            pair.left,
            create_label(tr("Effects"), "heading"),
            (self.effects, 30),
            self.empty_label,
            create_button_row(style, *self.buttons.values()),
        )
        pair.left.addSpacing(style.px(8))
        self.values_heading = create_label(tr("Values that moved beyond their bounds"), "heading")
        self.values = FittedTableView(
            style, tr("Values that moved"),
            (tr("Derivative"), tr("Before"), tr("After"), tr("Moved by")), stretch=2,
            widths={0: 100, 1: 100, 3: 76}, right=frozenset({1, 2, 3}), least=2,
        )  # fmt: skip
        self.settled = create_label("", "muted", wrap=True, remarks_in=style)
        add_widgets(pair.left, self.values_heading, (self.values, 30), self.settled)
        pair.left.addStretch(1)
        self.title = create_label("", "heading", wrap=True)
        self.equation = create_label("", wrap=True)
        self.parameters = NameValueTable(style)
        self.sentences = create_label("", "muted", wrap=True)
        self.remarks = create_label("", "hint", wrap=True, remarks_in=style)
        self.structure = AnalysisPlot(style, tr("Found, not understood"))
        self.as_tables = QCheckBox(tr("Save as a table"))
        self.as_tables.setToolTip(
            tr("Saves structure without a name as tables over the flown range, not as products")
        )
        add_widgets(
            pair.right,
            self.title,
            self.equation,
            self.parameters,
            self.sentences,
            (self.structure, 30),
            self.as_tables,
            self.remarks,
        )
        pair.right.addStretch(1)
        self.effects.selectionModel().currentChanged.connect(lambda *_: self._show_effect())

    def set_initial_focus(self) -> None:
        (self.effects if self.effects.row_model.rows else self.buttons["gap_force"]).setFocus()

    @property
    def selected_effect(self) -> str:
        return str(self.effects.current_key() or "")

    def refresh(self) -> None:
        result, step = self.result, self.selection.step
        if result is None:
            return
        rows = build_effect_status_rows(result, step)
        former = self.selected_effect
        self.effects.show_rows(rows)
        ids = [row.key for row in rows]
        if ids and former not in ids:
            self.effects.select_row(ids[min(step, len(ids) - 1)])
        self.effects.setVisible(bool(rows))
        count = len(result.discrepancy.steps)
        last = step == count - 1
        self.empty_label.setVisible(last)
        self.empty_label.setText(
            tr("All proven effects are in the model. Force another to see its effect.")
            if count > 1
            else tr("No effect is proven. Force one to see its effect.")
        )
        values = build_changed_value_rows(result)
        self.values.show_rows(values)
        self.values.setVisible(bool(values))
        self.values_heading.setVisible(bool(values))
        gust = result.discrepancy.disturbance.get("gust")
        sentences = [] if values else [tr("All other values stay within their bounds.")]
        if gust:
            sentences.append(
                tr("Turbulence of {gust:.2f} m/s (rms) is a disturbance, not an effect.").format(
                    gust=gust
                )
            )
        self.settled.setText(" ".join(sentences))
        self.settled.setVisible(bool(sentences))
        self.remarks.setText("\n".join((*result.discrepancy.warnings, *result.remarks)))
        self._show_effect()

    def _show_effect(self) -> None:
        result, effect = self.result, self.selected_effect
        if result is None:
            return
        found = next((one for one in result.discrepancy.effects if one.effect == effect), None)
        self._draw_structure(result.discrepancy, effect)
        note = result.effect_infos.get(effect)
        self.title.setText(result.title(effect) if effect else "")
        equation = found.equation if found else note.equation if note else ""
        self.equation.setText(equation)
        self.equation.setVisible(bool(equation))
        self.parameters.show_rows(build_parameter_rows(result, effect, self._style.units))
        if found is None:
            self.sentences.setText(tr("Rejected: excluded from the search.") if effect else "")
            return
        parts = [
            tr("Forced by the crew.")
            if found.forced
            else f"{effect_confidence_text(result, found)}."
        ]
        parts[0] = parts[0][:1].upper() + parts[0][1:]
        parts.append(describe_runner_up(result, found))
        parts.append(
            tr("Log-likelihood gain on the held-out maneuvers: {held_out}.").format(
                held_out=signed_number_text(found.held_out, 1)
            )
        )
        self.sentences.setText("\n".join(parts))

    def _draw_structure(self, found: DiscrepancyResult, effect: str) -> None:
        structure = next((one for one in found.structures if effect in one.effects), None)
        self.structure.setVisible(structure is not None)
        self.as_tables.setVisible(structure is not None)
        if structure is None:
            return
        cuts = structure_curves(structure, self._style.units)
        color = trace_color(structure.coefficient)
        colors = ("previous", color, "ink") if len(cuts) > 1 else (color,)
        name = structure.variables[0]
        unit = variable_unit(name, self._style.units)
        self.structure.draw(
            [
                PlotCurve(x=one.x, y=one.y, color=color, name=one.name)
                for one, color in zip(cuts, colors, strict=True)
            ],
            title=structure.equation,
            bottom=f"{symbol_markup(name)}{f', {unit}' if unit else ''}",
            left=symbol_markup(structure.coefficient),
        )


_ALL_COLUMNS_WIDTH = 620
_NOISE_COLUMN = 2


class ShowStage(StageView):
    """Overlay, what is left of it, bars per channel, waterfall and numbers."""

    def __init__(self, style: DisplayStyle, actions: Mapping[str, QAction]) -> None:
        super().__init__(style)
        pair = StackingColumns(style, (7, 5))
        self.column.addWidget(pair, 1)
        self.maneuver = LabeledComboBox(style, tr("Maneuver"), letters=32)
        self.channel = LabeledComboBox(style, tr("Channel"), letters=16)
        self.buttons = {
            "gap_report": ActionButton(actions["gap_report"], tr("Write the report…"), style),
            "gap_save": ActionButton(actions["gap_save"], tr("Save the model…"), style),
        }
        choices = create_button_row(style, self.maneuver, self.channel)
        self.overlay = AnalysisPlot(style, tr("Measured and simulated"))
        self.rest = AnalysisPlot(style, tr("Residual"), high=132)
        add_widgets(pair.left, choices, (self.overlay, 3), (self.rest, 2))
        self.closed = create_label("", "heading", wrap=True)
        self.on = create_label("", "muted", wrap=True)
        self.bars, self.waterfall = ChannelGapBars(style), MisfitWaterfall(style)
        add_widgets(
            pair.right,
            self.closed,
            self.on,
            create_label(tr("Gap per channel: gray before, color after"), "strong", wrap=True),
            self.bars,
            create_label(tr("All channels by step"), "strong"),
            self.waterfall,
            create_button_row(style, *self.buttons.values()),
        )
        pair.right.addStretch(1)
        self.numbers_heading = create_label("", "heading", wrap=True)
        self.numbers = FittedTableView(
            style, tr("Numbers of each channel"),
            (tr("Channel"), "RMS", tr("Noise"), tr("of range"), "Theil", tr("In 3 floors")),
            stretch=0, widths={1: 140, 2: 68, 3: 104, 4: 120, 5: 112},
            right=frozenset({1, 2, 3, 4, 5}), least=5, most=12,
        )  # fmt: skip
        add_widgets(self.column, self.numbers_heading, self.numbers)
        self.connect_choice(self.maneuver, "maneuver")
        self.connect_choice(self.channel, "channel")

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        narrow = self.width() < self._style.px(_ALL_COLUMNS_WIDTH)
        self.numbers.setColumnHidden(_NOISE_COLUMN, narrow)

    def set_initial_focus(self) -> None:
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
        closed = (
            gap_closed_text(gap.closed, gap.closed_std)
            if found.effects
            else tr("No effect was added to close a gap")
        )
        self.closed.setText(f"{closed}.")
        kept = tr("No held-out maneuver: fly one more of each kind.")
        if gap.on:
            kept = tr("Validated on maneuvers {names}, held out of the search.").format(
                names=join_with_and(gap.on)
            )
        self.on.setText(tr("From the baseline to the last effect. {kept}").format(kept=kept))
        self.bars.show_pairs(channel_gaps(found, selection.step))
        self.waterfall.show_steps(waterfall_steps(found), list_model_names(result), selection.step)
        lines = build_gap_rows(result, self._style.units)
        self.numbers.setMaximumWidth(self._style.px(760))
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
        picture = channel_overlay(view, selection.channel, self._style.units, selection.step)
        name = list_model_names(result)[selection.step]
        axis, unit = (
            channel_text(selection.channel),
            axis_unit(selection.channel, self._style.units),
        )
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
