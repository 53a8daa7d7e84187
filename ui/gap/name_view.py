"""Name: which effect is missing, how sure that is, and what would tell it from the others."""

from __future__ import annotations

from PySide6.QtWidgets import QCheckBox

from ui.gap.chapters import ChapterView
from ui.gap.parts import Lines, Pair, Paragraphs
from ui.gap.pictures import (
    alternative_lines,
    competition_text,
    effect_of_step,
    effect_picture,
    observability_lines,
    ranking,
    runner_up_text,
)
from ui.gap.tables import RankingView
from ui.look import Look
from ui.pages import label


class NameView(ChapterView):
    """Competition, alternatives, and what these flights could show."""

    def __init__(self, look: Look) -> None:
        super().__init__(look)
        pair = Pair(look, (6, 5))
        self.column.addWidget(pair, 1)
        pair.left.addWidget(label("What competes", "heading"))
        self.winner = label("", "strong", wrap=True)
        pair.left.addWidget(self.winner)
        self.margin = label("", "muted", wrap=True)
        pair.left.addWidget(self.margin)
        self.ranking = RankingView(look)
        pair.left.addWidget(self.ranking, 30)
        pair.left.addWidget(label("What these flights could show", "heading"))
        self.hidden_only = QCheckBox("Only what they could not show")
        self.hidden_only.setAccessibleName("Only the effects that these flights could not show")
        pair.left.addWidget(self.hidden_only)
        self.observability = Lines(
            look, "What these flights could show of each effect",
            ("Effect", "A plausible size shows", "To see it, fly"),
            stretch=2, widths={0: 190, 1: 150}, least=3,
        )  # fmt: skip
        pair.left.addWidget(self.observability, 30)
        pair.left.addStretch(1)
        self.effect = label("", "heading", wrap=True)
        pair.right.addWidget(self.effect)
        self.equation = label("", "muted", wrap=True)
        pair.right.addWidget(self.equation)
        self.about = Paragraphs(look)
        pair.right.addWidget(self.about)
        self.same = label("What would look the same", "heading")
        pair.right.addWidget(self.same)
        self.alternatives = Paragraphs(look)
        pair.right.addWidget(self.alternatives)
        pair.right.addStretch(1)
        self._candidate = ""
        self.ranking.chosen.connect(self._show_effect)
        self.observability.selectionModel().currentChanged.connect(self._seen)
        self.hidden_only.toggled.connect(lambda _on: self._show_observability())

    def begin(self) -> None:
        """Begin on the competition."""
        self.ranking.setFocus()

    @property
    def candidate(self) -> str:
        """Return the effect that is looked at."""
        return self._candidate

    def refresh(self) -> None:
        """Show the competition of the chosen model."""
        answer, step = self.answer, self.selection.step
        if answer is None:
            return
        self.winner.setText(competition_text(answer, step))
        found = effect_of_step(answer, step + 1)
        self.margin.setText(runner_up_text(answer, found) if found is not None else "")
        self.margin.setVisible(found is not None)
        rows = ranking(answer, step)
        self.ranking.show_rows(rows)
        self.ranking.setVisible(bool(rows))
        self._show_observability()
        self._show_effect(self.ranking.current or (found.effect if found is not None else ""))
        same = alternative_lines(answer, self.look.units)
        self.same.setVisible(bool(same))
        self.alternatives.show_paragraphs(
            [(title, f"{why} {f'To tell: {fly}.' if fly else ''}".strip())
             for title, why, fly in same]
        )  # fmt: skip

    def _show_observability(self) -> None:
        if self.answer is not None:
            self.observability.show_lines(
                observability_lines(self.answer, hidden_only=self.hidden_only.isChecked())
            )

    def _seen(self) -> None:
        key = self.observability.current_key()
        if self.observability.hasFocus() and key is not None:
            self._show_effect(str(key))

    def _show_effect(self, effect: str) -> None:
        self._candidate = effect
        if self.answer is None or not effect:
            for part in (self.effect, self.equation):
                part.hide()
            self.about.show_paragraphs(())
            return
        picture = effect_picture(self.answer, effect)
        self.effect.setText(picture.title)
        self.effect.show()
        self.equation.setText(picture.equation)
        self.equation.setVisible(bool(picture.equation))
        self.about.show_paragraphs(picture.paragraphs)
