"""One question in a line above the actions: a reason, a number, or yes and no."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import Qt
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QFrame, QHBoxLayout, QLineEdit, QPushButton, QSizePolicy, QWidget

from ui.display_style import DisplayStyle
from ui.translation import QT_TR_NOOP, tr
from ui.widgets.labels import create_label


def _accept_any(_text: str) -> str:
    return ""


class QuestionBar(QFrame):
    """Asks, and gives the answer to whoever asked; Enter answers, Esc takes the question back.

    Parameters
    ----------
    look : DisplayStyle
        Sizes.
    leave : callable
        Called when the question is gone: the keyboard goes back to the page.
    behind : QWidget
        Hidden while something is asked: its keys do nothing then.
    """

    def __init__(self, look: DisplayStyle, leave: Callable[[], object], behind: QWidget) -> None:
        super().__init__()
        self._look = look
        self._leave = leave
        self._behind = behind
        self._answer: Callable[[str], object] | None = None
        self._asked = ""
        self._wrong: Callable[[str], str] = _accept_any
        self.setObjectName("banner")
        self._row = QHBoxLayout(self)
        self.question = create_label("", "strong", wrap=True)
        self._row.addWidget(self.question, 1)
        self.field = QLineEdit()
        self._row.addWidget(self.field, 1)
        high = QSizePolicy.Policy.Expanding
        self.field.setSizePolicy(high, high)
        self.yes = QPushButton()
        self.yes.setProperty("role", "primary")
        self.no = QPushButton(tr("No   Esc"))
        for button, act in ((self.yes, self.accept), (self.no, self.cancel)):
            button.clicked.connect(act)
            button.setSizePolicy(QSizePolicy.Policy.Preferred, high)
            self._row.addWidget(button)
        look.changed.connect(self._restyle)
        self._restyle()
        self.hide()

    def _restyle(self) -> None:
        px = self._look.px
        self._row.setContentsMargins(px(16), px(6), px(16), px(6))
        self._row.setSpacing(px(8))
        self.setMinimumHeight(self._look.sizes.control + px(12))

    @property
    def is_open(self) -> bool:
        """Return whether a question waits."""
        return self._answer is not None

    def ask(
        self,
        question: str,
        answer: Callable[[str], object],
        *,
        typed: bool,
        yes: str = QT_TR_NOOP("Yes"),
        text: str = "",
        wrong: Callable[[str], str] = _accept_any,
    ) -> None:
        """Ask a question.

        Parameters
        ----------
        question : str
            One sentence.
        answer : callable
            Takes what was typed; not called if the question is taken back.
        typed : bool
            Whether something is to be typed.
        yes : str
            On the button that answers.
        text : str
            In the field to begin with.
        wrong : callable
            Says in a sentence why what was typed is no answer, else nothing; the question stays.
            By default anything is one.
        """
        self._answer = answer
        self._asked = question
        self._wrong = wrong
        self.question.setText(question)
        self.field.setVisible(typed)
        self.field.setText(text)
        self.field.setAccessibleName(question)
        self.yes.setText(tr("{yes}   Enter").format(yes=yes))
        self._behind.hide()
        self.show()
        if typed:
            self.field.setFocus(Qt.FocusReason.OtherFocusReason)
            self.field.selectAll()
        else:
            self.yes.setFocus(Qt.FocusReason.OtherFocusReason)

    def accept(self) -> None:
        """Give the answer."""
        answer, text = self._answer, self.field.text().strip()
        if answer is not None and (problem := self._wrong(text)):
            self.question.setText(f"{problem} {self._asked}")
            self.field.setFocus(Qt.FocusReason.OtherFocusReason)
            self.field.selectAll()
            return
        self.cancel()
        if answer is not None:
            answer(text)

    def cancel(self) -> None:
        """Take the question back."""
        self._answer = None
        self.hide()
        self._behind.show()
        self._leave()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            self.accept()
        elif event.key() == Qt.Key.Key_Escape:
            self.cancel()
        event.accept()
