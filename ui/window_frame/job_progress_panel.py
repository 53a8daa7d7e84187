"""A work that runs: how far it is, what it is doing, how long it still takes, and Stop."""

from __future__ import annotations

from PySide6.QtGui import QAction
from PySide6.QtWidgets import QFrame, QHBoxLayout, QProgressBar, QSizePolicy

from ui.display_style import DisplayStyle
from ui.translation import tr
from ui.widgets.action_button import ActionButton
from ui.widgets.labels import create_label


class JobProgressPanel(QFrame):
    """Across the top of a place while something runs there."""

    def __init__(self, look: DisplayStyle, cancel: QAction, name: str) -> None:
        super().__init__()
        self._look = look
        self.setObjectName("banner")
        self.setAccessibleName(tr("{name} that runs").format(name=name.capitalize()))
        row = QHBoxLayout(self)
        row.setContentsMargins(look.px(16), look.px(6), look.px(8), look.px(6))
        row.setSpacing(look.px(12))
        self.title = ""
        self.text_label = create_label("", wrap=True)
        self.text_label.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Preferred)
        row.addWidget(self.text_label, 1)
        self.progress_bar = QProgressBar()
        self.progress_bar.setTextVisible(False)
        self.progress_bar.setAccessibleName(tr("Progress of the {name}").format(name=name))
        row.addWidget(self.progress_bar)
        self.stop_button = ActionButton(cancel, tr("Stop"), look)
        row.addWidget(self.stop_button)
        look.changed.connect(self._rescale)
        self._rescale()
        self.hide()

    def _rescale(self) -> None:
        self.progress_bar.setFixedSize(self._look.px(160), self._look.px(8))

    def begin(self, title: str) -> None:
        self.title = title
        self.text_label.setText(tr("{title}: starting").format(title=title))
        self.progress_bar.setRange(0, 0)
        self.show()

    def set_progress(self, share: float | None, words: str) -> None:
        if share is None:
            self.progress_bar.setRange(0, 0)
        else:
            self.progress_bar.setRange(0, 1000)
            self.progress_bar.setValue(round(1000 * share))
        self.text_label.setText(f"{self.title}: {words}")
