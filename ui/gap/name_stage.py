"""Name: which effect is missing, how sure that is, and what would tell it from the others."""

from __future__ import annotations

from PySide6.QtWidgets import QCheckBox

from ui.display_style import DisplayStyle
from ui.gap.gap_tables import RankingView
from ui.gap.gap_view_models import (
    build_alternative_rows,
    build_observability_rows,
    build_ranking_rows,
    describe_effect,
    describe_ranking,
    describe_runner_up,
    find_step_effect,
)
from ui.gap.stage_view import StageView
from ui.translation import tr
from ui.widgets.labels import create_label
from ui.widgets.layout_widgets import HeadedParagraphs, StackingColumns
from ui.widgets.table_view import FittedTableView


class NameStage(StageView):
    """Competition, alternatives, and what these flights could show."""

    def __init__(self, look: DisplayStyle) -> None:
        super().__init__(look)
        pair = StackingColumns(look, (6, 5))
        self.column.addWidget(pair, 1)
        pair.left.addWidget(create_label(tr("Candidate effects"), "heading"))
        self.winner = create_label("", "strong", wrap=True)
        pair.left.addWidget(self.winner)
        self.margin = create_label("", "muted", wrap=True)
        pair.left.addWidget(self.margin)
        self.ranking = RankingView(look)
        pair.left.addWidget(self.ranking, 30)
        pair.left.addWidget(create_label(tr("Observability"), "heading"))
        self.hidden_only = QCheckBox(tr("Unobservable only"))
        self.hidden_only.setAccessibleName(tr("Only effects that these flights cannot show"))
        pair.left.addWidget(self.hidden_only)
        self.observability = FittedTableView(
            look, tr("Observability of each effect"),
            (tr("Effect"), tr("A plausible size shows"), tr("To see it, fly")),
            stretch=2, widths={0: 190, 1: 150}, least=3,
        )  # fmt: skip
        pair.left.addWidget(self.observability, 30)
        pair.left.addStretch(1)
        self.effect = create_label("", "heading", wrap=True)
        pair.right.addWidget(self.effect)
        self.equation = create_label("", "muted", wrap=True)
        pair.right.addWidget(self.equation)
        self.about = HeadedParagraphs(look)
        pair.right.addWidget(self.about)
        self.same = create_label(tr("Indistinguishable"), "heading")
        pair.right.addWidget(self.same)
        self.alternatives = HeadedParagraphs(look)
        pair.right.addWidget(self.alternatives)
        pair.right.addStretch(1)
        self._candidate = ""
        self.ranking.row_changed.connect(self._show_effect)
        self.observability.selectionModel().currentChanged.connect(self._seen)
        self.hidden_only.toggled.connect(lambda _on: self._show_observability())

    def begin(self) -> None:
        self.ranking.setFocus()

    @property
    def candidate(self) -> str:
        return self._candidate

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
        same = build_alternative_rows(result, self.look.units)
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
        self._candidate = effect
        if self.result is None or not effect:
            for part in (self.effect, self.equation):
                part.hide()
            self.about.show_paragraphs(())
            return
        picture = describe_effect(self.result, effect)
        self.effect.setText(picture.title)
        self.effect.show()
        self.equation.setText(picture.equation)
        self.equation.setVisible(bool(picture.equation))
        self.about.show_paragraphs(picture.paragraphs)
