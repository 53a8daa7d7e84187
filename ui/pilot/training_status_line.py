"""One line below the page while training: who has the aircraft, and which keys do what."""

from __future__ import annotations

from PySide6.QtWidgets import QLabel

from ui.commands import shortcut_text
from ui.display_style import DisplayStyle
from ui.pilot.training_flight import TrainingFlight

_CONTROL_KEY_TEXT = shortcut_text("Ctrl+Up").removesuffix(shortcut_text("Up"))
_KEYS_TEXT = (
    "arrows: stick (Down pulls) · A D: rudder · W S: throttle · "
    "1 2 3 4 5: quarter, third, half, two thirds, full · 9 0: low, high rate · "
    f"{_CONTROL_KEY_TEXT}arrows: trim · {shortcut_text('Ctrl+M')}: sound"
)


class TrainingStatusLine(QLabel):
    """Says it; hidden without training.

    Parameters
    ----------
    look : DisplayStyle
        Sizes.
    """

    def __init__(self, look: DisplayStyle) -> None:
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

    def show_status(self, training: TrainingFlight) -> None:
        """Say who has it, and the keys."""
        if training.trainee_has_control:
            self.setText(
                f"You have control ({training.settings_text}) · {_KEYS_TEXT} · H: give it back"
            )
        else:
            self.setText("The built-in pilot flies the pattern · H: take control")
        self.setVisible(training.running)
