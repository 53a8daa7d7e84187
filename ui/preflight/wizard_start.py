"""Before a calibration: what is in force, who calibrates, and what can be begun."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from PySide6.QtWidgets import QFrame, QGridLayout, QLineEdit, QSizePolicy, QWidget

from gsapp.foundation import UnitError
from gsapp.quantities import channel, to_si
from ui.dialogs.form import Sentence
from ui.look import Look
from ui.pages import CenteredPage, label
from ui.words import parse_number

_TEMPERATURE = channel("temperature").quantity


@dataclass(frozen=True, slots=True, kw_only=True)
class Standing:
    """How one instrument stands.

    Attributes
    ----------
    title : str
        Its name.
    words : str
        Since when it is calibrated, or that it is not.
    good : bool
        Whether it is calibrated.
    """

    title: str
    words: str
    good: bool


class StartPanel(CenteredPage):
    """Says what is there and asks who calibrates; what can be done is in the actions below.

    Parameters
    ----------
    look : Look
        Sizes.
    """

    def __init__(self, look: Look) -> None:
        super().__init__(look, 860)
        self.setAccessibleName("Calibration")
        self.column.addWidget(label("Calibration", "title"))
        self.sentence = Sentence()
        self.sentence.setProperty("role", "")
        self.column.addWidget(self.sentence)
        self.resume = Sentence()
        self.resume.setProperty("role", "strong")
        self.column.addWidget(self.resume)
        self.column.addWidget(self._fields(look))
        self._card = QFrame()
        self._card.setObjectName("card")
        self._grid = QGridLayout(self._card)
        self._grid.setColumnStretch(2, 1)
        self.column.addWidget(self._card)
        self.standings: tuple[Standing, ...] | None = None
        look.changed.connect(self._restyle)
        self._restyle()

    def _fields(self, look: Look) -> QWidget:
        holder = QWidget()
        grid = QGridLayout(holder)
        grid.setContentsMargins(0, look.px(4), 0, look.px(4))
        self.who = QLineEdit()
        self.temperature = QLineEdit()
        for column, (name, field) in enumerate(
            (("Who calibrates", self.who), ("Ground temperature [°C]", self.temperature))
        ):
            grid.addWidget(label(name, "label"), 0, column)
            field.setAccessibleName(name)
            grid.addWidget(field, 1, column)
            grid.setColumnStretch(column, 2 - column)
            high = QSizePolicy.Policy.Expanding
            field.setSizePolicy(high, high)
        self._field_grid = grid
        return holder

    def _restyle(self) -> None:
        if not hasattr(self, "_card"):
            return
        px = self._look.px
        self._grid.setContentsMargins(px(16), px(10), px(16), px(10))
        self._grid.setHorizontalSpacing(px(24))
        self._grid.setVerticalSpacing(px(5))
        self._field_grid.setHorizontalSpacing(px(16))
        # As high as its row: the style sheet knows a least height of its own.
        self._field_grid.setRowMinimumHeight(1, self._look.sizes.control)

    @property
    def kelvin(self) -> float | None:
        """Return the temperature entered, K; None where there is none.

        Raises
        ------
        UnitError
            If what was entered is no number.
        """
        text = self.temperature.text().strip()
        if not text:
            return None
        celsius = parse_number(text)
        if celsius is None:
            raise UnitError(
                f"the ground temperature '{text}' is not a number; write degrees Celsius, such as "
                "21.5, or nothing"
            )
        return float(to_si(celsius, "degC", _TEMPERATURE))

    def offer_who(self, who: str) -> None:
        """Put the one who calibrated last into the field, if nobody is there yet."""
        if not self.who.text():
            self.who.setText(who)

    def show_standings(self, standings: Sequence[Standing]) -> None:
        """Show how every instrument stands."""
        if tuple(standings) == self.standings:
            return
        self.standings = tuple(standings)
        self._card.setVisible(bool(standings))
        while (item := self._grid.takeAt(0)) is not None:
            item.widget().hide()
            item.widget().deleteLater()
        for row, standing in enumerate(standings):
            sign = label("✓" if standing.good else "▲", "strong")
            words = label(standing.words, wrap=True)
            for widget in (sign, words):
                widget.setProperty("state", "good" if standing.good else "caution")
            self._grid.addWidget(sign, row, 0)
            self._grid.addWidget(label(standing.title, "strong"), row, 1)
            self._grid.addWidget(words, row, 2)
