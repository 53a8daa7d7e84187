"""One line below the page while training: who has the aircraft, and which keys do what."""

from __future__ import annotations

from PySide6.QtWidgets import QLabel

from ui.commands import shortcut_text
from ui.display_style import DisplayStyle
from ui.pilot.training_flight import TrainingFlight
from ui.translation import tr

_CONTROL_KEY_TEXT = shortcut_text("Ctrl+Up").removesuffix(shortcut_text("Up"))


class TrainingStatusLine(QLabel):
    """Says it; hidden without training."""

    def __init__(self, look: DisplayStyle) -> None:
        super().__init__()
        self._look = look
        self.setWordWrap(True)
        self.setAccessibleName(tr("Training"))
        self.hide()
        look.changed.connect(self._restyle)
        self._restyle()

    def _restyle(self) -> None:
        px = self._look.px
        self.setContentsMargins(px(16), px(4), px(16), px(4))

    def show_status(self, training: TrainingFlight) -> None:
        if training.trainee_has_control:
            self.setText(
                tr(
                    "You have control ({settings}) · arrows: stick (Down pulls) · A D: rudder · "
                    "W S: throttle · 1 2 3 4 5: quarter, third, half, two thirds, full · "
                    "9 0: low, high rate · {control}arrows: trim · {sound}: sound · H: give it back"
                ).format(
                    settings=training.settings_text,
                    control=_CONTROL_KEY_TEXT,
                    sound=shortcut_text("Ctrl+M"),
                )
            )
        else:
            self.setText(tr("The built-in pilot flies the pattern · H: take control"))
        self.setVisible(training.running)
