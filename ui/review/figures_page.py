"""Figures of a run: the report's own, to be looked into, with points that can be chosen."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QVBoxLayout

from gsapp.foundation import FlightError
from gsapp.quantities import typeset
from ui.commands import CommandRequirement
from ui.number_format import sanitize_file_name
from ui.review.figure_data import (
    JOINT_PREFIX,
    FigureData,
    FigureOption,
    derivative_group_option,
    derivatives_in_group,
    describe_point,
    find_result,
    format_run_name,
    selected_choice,
)
from ui.review.figure_kinds import FIGURE_KINDS, FigureKind
from ui.review.figure_renderer import FigureSize, RenderedFigure
from ui.review.figures_layout import FiguresLayout
from ui.review.job_queue import FigureComputations
from ui.review.review_steps import PREVIOUS_RUN_COUNT, ReviewContext, ReviewStepPage, no_run_text
from ui.settings import initial_dialog_folder
from ui.translation import tr
from ui.undo import UndoCommand, UndoHistory, UndoStack
from ui.widgets.figure_menu import ContentFunction, FigureMenu
from ui.window_frame.page_steps import StepStatus

if TYPE_CHECKING:
    from gsapp.identification.runs.run_execution import RunOutcome

log = logging.getLogger(__name__)


class FiguresPage(ReviewStepPage):
    """Lists the figures at the left and shows one."""

    exclusion_changed = Signal(object)
    """The `RunOutcome` with other maneuvers left out of its means."""

    def __init__(self, context: ReviewContext) -> None:
        super().__init__(context, tr("Figures"))
        actions, style, selection = context.actions, context.style, context.selection
        self._data: FigureData | None = None
        self._chosen: dict[str, str] = {}
        self._undo_stack = UndoStack(self)
        self._excluded: frozenset[str] = frozenset()
        self._computations = FigureComputations(context.begin_job, self)
        self.kind: FigureKind = FIGURE_KINDS[0]
        self._column = QVBoxLayout(self)
        self.frame = FiguresLayout(actions, style, self._describe)
        self._column.addWidget(self.frame)
        self.frame.kind_chosen.connect(self.show_kind)
        self.frame.option_chosen.connect(self._choose)
        self.view = self.frame.view
        self.view.drawn.connect(self._drawn)
        self.view.failed.connect(_log_failure)
        canvas = self.view.canvas
        self.menu = FigureMenu(canvas, self._file, self._content, canvas.reset_views)
        self.menu.message_posted.connect(self.frame.show_message)
        canvas.addActions([actions["review_open_fit"], actions["review_exclude"]])
        self.view.canvas.point_selected.connect(self._point_chosen)
        self.view.canvas.fit_requested.connect(self.open_fit)
        self.view.canvas.subplot_opened.connect(self._open_subplot)
        self._computations.changed.connect(self._computations_changed)
        selection.maneuver_changed.connect(self._maneuver_chosen)
        selection.derivative_changed.connect(self._derivative_chosen)
        style.changed.connect(self._restyle)
        self._restyle()
        self.show_outcome(None)

    # Commands

    @property
    def handlers(self) -> Mapping[str, Callable[[], object]]:
        return {
            "review_previous_figure": lambda: self._next_figure(-1),
            "review_next_figure": lambda: self._next_figure(1),
            "review_figure_previous_maneuver": lambda: self._next_maneuver(-1),
            "review_figure_next_maneuver": lambda: self._next_maneuver(1),
            "review_open_fit": lambda: self.open_fit(self._selection.maneuver),
            "review_exclude": self.exclude,
            "review_figure_copy": self.menu.copy_figure,
            "review_figure_copy_numbers": self.menu.copy_numbers,
            "review_figure_save": self.menu.save_as,
        }

    @property
    def present(self) -> tuple[CommandRequirement, ...]:
        if self._data is None:
            return ()
        needs: list[CommandRequirement] = ["review_figure"]
        if self._is_drawn:
            needs.append("review_picture")
        if find_result(self._data.outcome, self._selection.maneuver) is not None:
            needs.append("review_point")
        return tuple(needs)

    @property
    def _is_drawn(self) -> bool:
        """Return whether a figure is on screen, not a sentence why there is none."""
        drawing = self.view.rendered_figure
        return drawing is not None and drawing.figure is not None

    @property
    def state(self) -> StepStatus:
        if self._data is None:
            return StepStatus(state="unknown")
        outcome = self._data.outcome
        out = len(outcome.summary.excluded_maneuvers)
        text = (
            tr("{run_name}, {out} excluded").format(run_name=format_run_name(outcome), out=out)
            if out
            else format_run_name(outcome)
        )
        return StepStatus(state="plain", text=text)

    def set_initial_focus(self) -> None:
        (self.view if self._data is not None else self.frame.list).setFocus()

    # The run

    def show_outcome(self, outcome: RunOutcome | None) -> None:
        former = self._data
        if outcome is None:
            self._data = None
            self._refresh()
            return
        if former is not None and former.outcome.result is outcome.result:
            if former.outcome is not outcome:
                self._excluded = frozenset(outcome.summary.excluded_maneuvers)
                self._show_data(replace(former, outcome=outcome), same=True)
            return
        before = () if former is None else (former.outcome, *former.others)
        others = tuple(one for one in before if one.result is not outcome.result)
        self._undo_stack.clear()
        self._excluded = frozenset(outcome.summary.excluded_maneuvers)
        self._computations.reset(outcome)
        self._follow_flight(outcome, self._selection.maneuver)
        self._show_data(
            FigureData(
                outcome=outcome, others=others[:PREVIOUS_RUN_COUNT], units=self.display_style.units,
                maneuver=self._selection.maneuver, ftr_histories=self._computations.ftr_histories,
                selected_options=self._chosen,
            )
        )  # fmt: skip

    def _show_data(self, data: FigureData, *, same: bool = False) -> None:
        self._data = data
        self._refresh(same=same)
        self.changed.emit()

    def _computations_changed(self) -> None:
        if self._data is not None:
            self._show_data(
                replace(
                    self._data,
                    ftr_histories=self._computations.ftr_histories,
                    comparison=self._computations.comparison,
                )
            )

    # What is shown

    def show_kind(self, name: str) -> None:
        self.kind = next(one for one in FIGURE_KINDS if one.id == name)
        self._computations.allow_retry()
        self._refresh()
        self.changed.emit()

    def _next_figure(self, steps: int) -> None:
        index = FIGURE_KINDS.index(self.kind) + steps
        self.show_kind(FIGURE_KINDS[min(max(index, 0), len(FIGURE_KINDS) - 1)].id)

    def _refresh(self, *, same: bool = False) -> None:
        data, kind, frame = self._data, self.kind, self.frame
        frame.show_message("")
        frame.show_kind(kind)
        options = () if data is None else kind.options(data)
        frame.show_options([(one, self._key(one)) for one in options])
        if data is None:
            self.view.show_figure(
                lambda _palette, _room: no_run_text(tr("the figures of the run appear here."))
            )
            return
        if kind.needs and getattr(data, kind.needs) is None:
            text = self._computations.request(kind.needs, data.outcome)
            if getattr(self._data, kind.needs) is None:
                self.view.show_figure(lambda _palette, _room: text)
            return
        self.view.canvas.select_maneuver(self._selection.maneuver)
        self.view.show_figure(lambda palette, room: kind.build(data, palette, room), same=same)

    def _key(self, option: FigureOption) -> str:
        """Return what is chosen in a list; the maneuver is the one that all pages look at."""
        if self._data is None:
            return ""
        key = selected_choice(self._data, option)
        if option.id == "maneuver" and not key.startswith(JOINT_PREFIX):
            return self._data.current_maneuver.maneuver.id
        return key

    def _choose(self, name: str, value: str) -> None:
        self._chosen[name] = value
        if self._data is None:
            return
        if name == "maneuver" and not value.startswith(JOINT_PREFIX):
            self._selection.select_maneuver(value)
        self._show_data(replace(self._data, selected_options=dict(self._chosen)))

    def _file(self) -> Path:
        return (
            initial_dialog_folder(self._store.current)
            / f"{sanitize_file_name(self.kind.title)}.png"
        )

    def _content(self, ending: str) -> ContentFunction:
        """Return the figure as the report prints it, or its numbers, as the content of a file."""
        kind, data = self.kind, self._data

        def content() -> bytes:
            from gsapp.report.document import FIGURE_WIDTH
            from gsapp.report.document_writer import export_figure
            from gsapp.report.palette import PRINT_PALETTE

            if data is None:
                raise FlightError(no_run_text(tr("the figures of the run appear here.")))
            picture = kind.build(data, PRINT_PALETTE, FigureSize(width=FIGURE_WIDTH, height=0.0))
            if isinstance(picture, str):
                raise FlightError(picture)
            return export_figure(picture, ending)

        return content

    def _drawn(self, drawing: RenderedFigure) -> None:
        picture, build_table, data = drawing.figure, self.kind.table, self._data
        self.menu.enable(picture is not None)
        self.changed.emit()
        self.frame.show_caption("" if picture is None else typeset(picture.caption))
        if picture is None or build_table is None or data is None:
            self.frame.table.show_table(None)
        else:
            self.frame.table.show_table(build_table(data))
        self._show_detail()

    def _describe(self, pane: str, maneuver: str) -> str:
        if self._data is None:
            return ""
        return describe_point(self._data, pane.partition(":")[2], maneuver)

    def _show_detail(self) -> None:
        """Describe the chosen maneuver below the figure, if the figure has a point for it."""
        canvas, chosen_name = self.view.canvas, self._selection.maneuver
        charts = [
            canvas.subplot_at(one.subplot_index)
            for one in canvas.points
            if one.maneuver == chosen_name
        ]
        derivatives = {pane.name.partition(":")[2] for pane in charts if pane is not None}
        if self._data is None or not derivatives:
            self.frame.show_message("")
            return
        derivative = self._selection.derivative
        words = describe_point(
            self._data, derivative if derivative in derivatives else "", chosen_name
        )
        self.frame.show_message(" · ".join(words.splitlines()))

    # Choosing

    def _point_chosen(self, pane: str, maneuver: str) -> None:
        self._selection.select_derivative(pane.partition(":")[2] or self._selection.derivative)
        self._selection.select_maneuver(maneuver)
        self._show_detail()

    def _maneuver_chosen(self, maneuver: str) -> None:
        self.view.canvas.select_maneuver(maneuver)
        data = self._data
        if data is None:
            return
        self._chosen.pop("maneuver", None)
        self._follow_flight(data.outcome, maneuver)
        self._data = replace(data, maneuver=maneuver, selected_options=dict(self._chosen))
        if self._follows(data):
            self._refresh()
        self._show_detail()
        self.changed.emit()

    def _follow_flight(self, outcome: RunOutcome, maneuver: str) -> None:
        result = find_result(outcome, maneuver)
        if result is not None:
            self._chosen["flight"] = result.maneuver.flight

    def _follows(self, former: FigureData) -> bool:
        """Return whether the figure is another for another maneuver."""
        options = self.kind.options(former)
        if any(one.id == "maneuver" for one in options):
            return True
        flights = [selected_choice(former, one) for one in options if one.id == "flight"]
        return bool(flights) and flights != [self._chosen.get("flight")]

    def _derivative_chosen(self, derivative: str) -> None:
        data = self._data
        if data is None or derivative not in data.outcome.summary.derivatives:
            return
        group = selected_choice(data, derivative_group_option(data))
        if derivative not in derivatives_in_group(data, group) and not derivative.endswith("_0"):
            self._chosen["group"] = derivative
            self._show_data(replace(data, selected_options=dict(self._chosen)))
        self._show_detail()

    def _open_subplot(self, pane: str) -> None:
        """Show one derivative large, or all of its kind again; of a maneuver, its fit."""
        data, (what, _, name) = self._data, pane.partition(":")
        if what == "maneuver":
            self.open_fit(name)
            return
        if data is None or self.kind.id != "values":
            return
        alone = selected_choice(data, derivative_group_option(data)) == name
        self._chosen["group"] = name.partition("_")[0] if alone else name
        self._show_data(replace(data, selected_options=dict(self._chosen)))

    def open_fit(self, maneuver: str) -> None:
        self._selection.select_maneuver(maneuver)
        self.show_kind("fit")
        self.view.setFocus()

    def _next_maneuver(self, steps: int) -> None:
        if self._data is None:
            return
        ids = [one.maneuver.id for one in self._data.outcome.result.results]
        place = ids.index(self._data.current_maneuver.maneuver.id)
        if self._selection.maneuver in ids:
            place = min(max(place + steps, 0), len(ids) - 1)
        self._selection.select_maneuver(ids[place])

    # Maneuvers left out by hand

    @property
    def undo_history(self) -> UndoHistory:
        return self._undo_stack

    def exclude(self) -> None:
        """Leave the chosen maneuver out of the means, or take it in again."""
        if self._data is not None and self._selection.maneuver:
            former, name = self._excluded, self._selection.maneuver
            now = former ^ {name}
            self._exclude(now)
            text = tr("include {name}") if name in former else tr("exclude {name}")
            self._undo_stack.push(
                UndoCommand(
                    text.format(name=name),
                    lambda: self._exclude(former),
                    lambda: self._exclude(now),
                )
            )
            self.changed.emit()

    def _exclude(self, without: frozenset[str]) -> None:
        if self._data is None:
            return
        from gsapp.identification.runs.run_execution import exclude_maneuvers

        former, self._excluded = self._data.outcome, without
        outcome = exclude_maneuvers(former, without)
        # A derivative that no other maneuver gave comes and goes with it, and so does its chart.
        same = outcome.summary.derivatives.keys() == former.summary.derivatives.keys()
        self._show_data(replace(self._data, outcome=outcome), same=same)
        self.exclusion_changed.emit(outcome)

    def _restyle(self) -> None:
        margin = self.display_style.px(12)
        self._column.setContentsMargins(margin, margin, margin, margin)
        if self._data is not None and self._data.units != self.display_style.units:
            self._show_data(replace(self._data, units=self.display_style.units))


def _log_failure(error: BaseException) -> None:
    log.error("a figure could not be drawn", exc_info=error)
