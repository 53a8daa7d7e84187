"""One line below the page while training: who has the aircraft, and which keys do what."""

from __future__ import annotations

from PySide6.QtWidgets import QLabel

from ui.commands import key_text
from ui.look import Look
from ui.pilot.training import Training

_CONTROL = key_text("Ctrl+Up").removesuffix(key_text("Up"))
_KEYS = (
    "arrows: stick (Down pulls) · A D: rudder · W S: throttle · "
    "1 2 3 4 5: quarter, third, half, two thirds, full · 9 0: low, high rate · "
    f"{_CONTROL}arrows: trim · {key_text('Ctrl+M')}: sound"
)


class TrainingLine(QLabel):
    """Says it; hidden without training.

    Parameters
    ----------
    look : Look
        Sizes.
    """

    def __init__(self, look: Look) -> None:
        super().__init__()
        self._look = look
        self.setWordWrap(True)
        self.setAccessibleName("Training")
        self.hide()
        look.changed.connect(self._restyle)
        self._restyle()

    def _restyle(self) -> None:
        px = self._look.px
        self.setContentsMargins(px(16), px(4), px(16), px(4))

    def show_training(self, training: Training) -> None:
        """Say who has it, and the keys."""
        if training.flies:
            self.setText(f"You have it ({training.settings}) · {_KEYS} · H: give it back")
        else:
            self.setText("The built-in pilot flies the pattern · H: you have it")
        self.setVisible(training.running)
