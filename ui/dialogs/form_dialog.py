"""What the dialogs share: labeled rows, a sentence below a field, folder and file buttons."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QEvent, QObject, Qt, Signal
from PySide6.QtGui import QIntValidator, QShowEvent
from PySide6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QFileDialog,
    QFrame,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QPushButton,
    QScrollArea,
    QVBoxLayout,
    QWidget,
)

from ui.disk_checks import nearest_folder
from ui.display_style import DisplayStyle
from ui.translation import tr
from ui.widgets.flow_layout import arrange
from ui.widgets.labels import create_label, plain_tooltip


def repolish(widget: QWidget) -> None:
    """Apply the style sheet again after a property changed."""
    widget.style().unpolish(widget)
    widget.style().polish(widget)


class FieldMessage(QLabel):
    """A sentence below a field that says whether what stands there will do."""

    def __init__(self) -> None:
        super().__init__()
        self.setWordWrap(True)
        self.setProperty("role", "hint")

    def set_message(self, text: str, state: str = "") -> None:
        """Say something; `state` is ``good``, ``caution``, ``warning`` or empty."""
        signs = {"good": "✓ ", "caution": "▲ ", "warning": "■ "}
        self.setText(f"{signs.get(state, '')}{text}")
        if self.property("state") != state:
            self.setProperty("state", state)
            repolish(self)


class IntegerField(QLineEdit):
    """A whole number within limits."""

    value_changed = Signal()  # Another number stands there, and it is within the limits.

    def __init__(self, lowest: int, highest: int, value: int) -> None:
        super().__init__(str(value))
        self._last = value
        self.setValidator(QIntValidator(lowest, highest, self))
        self.textChanged.connect(self._changed)

    def _changed(self) -> None:
        if self.hasAcceptableInput() and int(self.text()) != self._last:
            self._last = int(self.text())
            self.value_changed.emit()

    @property
    def value(self) -> int:
        """Return the number; the last good one while something else is being typed."""
        return self._last

    def set_value(self, value: int) -> None:
        self.setText(str(value))


class PathField(QWidget):
    """A path to write to, typed or chosen."""

    def __init__(self, name: str, style: DisplayStyle, *, folder: bool = True) -> None:
        super().__init__()
        self._name, self._folder = name, folder
        row = arrange(QHBoxLayout(self), style.px(8))
        self.edit = QLineEdit()
        self.edit.setAccessibleName(name)
        row.addWidget(self.edit, 1)
        button = QPushButton(tr("Choose…"))
        button.setAccessibleName(tr("Choose {name}").format(name=name.lower()))
        button.clicked.connect(self._choose)
        row.addWidget(button)
        self.setFocusProxy(self.edit)

    @property
    def path(self) -> Path:
        return Path(self.edit.text().strip()).expanduser()

    def _choose(self) -> None:
        wanted = self.path if self.edit.text().strip() else Path.home()
        if self._folder:
            start = str(nearest_folder(wanted))
            chosen = QFileDialog.getExistingDirectory(self, self._name, start)
        else:
            start = str(nearest_folder(wanted.parent) / wanted.name)
            chosen, _kind = QFileDialog.getSaveFileName(self, self._name, start)
        if chosen:
            self.edit.setText(chosen)


class SelfDeletingDialog(QDialog):
    """A dialog that is gone once whoever opened it has taken the answer.

    Where one of its signals leads to a function that knows it, its parent would keep it, hidden,
    for as long as the window lives.
    """

    def exec(self) -> int:
        """Show it and wait for the answer."""
        answer = super().exec()
        self.deleteLater()
        return answer


class FormDialog(SelfDeletingDialog):
    """A dialog of labeled rows with one button that does it and one that does not."""

    def __init__(
        self,
        title: str,
        purpose: str,
        does: str,
        style: DisplayStyle,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        self.display_style = style
        self.setWindowTitle(title)
        outer = arrange(QVBoxLayout(self), 0)
        area = QScrollArea()
        area.setFrameShape(QFrame.Shape.NoFrame)
        area.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        area.setWidgetResizable(True)
        # Names above the fields where the screen is narrow for the scale.
        screen = self.screen()
        self._stacked = screen is not None and screen.availableSize().width() < style.px(720)
        self._body = QWidget()
        self._body.setObjectName("page")
        self._area = area
        column = arrange(
            QVBoxLayout(self._body),
            style.px(16),
            style.px(24),
            style.px(24),
            style.px(24),
            style.px(16),
        )
        column.addWidget(create_label(title, "title"))
        column.addWidget(create_label(purpose, "muted", wrap=True))
        self.grid = QGridLayout()
        self.grid.setHorizontalSpacing(style.px(16))
        self.grid.setVerticalSpacing(style.px(4))
        self.grid.setColumnStretch(1, 1)
        column.addLayout(self.grid)
        column.addStretch(1)
        area.setWidget(self._body)
        outer.addWidget(area, 1)
        foot = QWidget()
        foot.setObjectName("controls")
        foot.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        row = QHBoxLayout(foot)
        row.setContentsMargins(style.px(24), style.px(12), style.px(24), style.px(12))
        self.buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Cancel)
        self.button = self.buttons.addButton(does, QDialogButtonBox.ButtonRole.AcceptRole)
        self.button.installEventFilter(self)
        self.buttons.accepted.connect(self.accept)
        self.buttons.rejected.connect(self.reject)
        row.addWidget(self.buttons)
        outer.addWidget(foot)

    def add_row(self, name: str, field: QWidget, below: QWidget | None = None) -> None:
        """Add a labeled field with something below it."""
        row = self.grid.rowCount()
        if row > 1:
            self.grid.setRowMinimumHeight(row, self.display_style.px(4))
            row += 1
        title = create_label(name, "strong")
        title.setMinimumHeight(self.display_style.px(30))
        title.setBuddy(field)
        if not field.accessibleName():
            field.setAccessibleName(name)
        if self._stacked:
            self.grid.addWidget(title, row, 0, 1, 2)
            row += 1
            self.grid.addWidget(field, row, 0, 1, 2)
        else:
            self.grid.addWidget(title, row, 0, Qt.AlignmentFlag.AlignTop)
            self.grid.addWidget(field, row, 1)
        if below is not None:
            self.grid.addWidget(below, row + 1, 0 if self._stacked else 1, 1, -1)

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        for button in self.findChildren(QPushButton):
            # Enter does what the dialog is for, not what the nearest button would do.
            button.setAutoDefault(False)
        self.button.setDefault(True)
        chain = self.tab_chain()
        if chain and not self._body.isAncestorOf(self.focusWidget() or self):
            chain[0].setFocus(Qt.FocusReason.TabFocusReason)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        if watched is self.button and event.type() == QEvent.Type.ToolTip:
            complaints = [
                sentence.text()
                for sentence in self._body.findChildren(FieldMessage)
                if sentence.isVisible() and sentence.property("state") == "warning"
            ]
            self.button.setToolTip(
                plain_tooltip("" if self.button.isEnabled() else "\n".join(complaints))
            )
        return super().eventFilter(watched, event)

    def focusNextPrevChild(self, forward: bool) -> bool:
        """Let Tab go as one reads; what was hidden until now has its place only now.

        `QWidget.setTabOrder` fails here: with focus proxies it made rings that left out fields.
        """
        chain = [field for field in self.tab_chain() if field.isVisible() and field.isEnabled()]
        focus = self.focusWidget()
        if focus not in chain:
            return super().focusNextPrevChild(forward)
        step = 1 if forward else -1
        reasons = Qt.FocusReason
        chain[(chain.index(focus) + step) % len(chain)].setFocus(
            reasons.TabFocusReason if forward else reasons.BacktabFocusReason
        )
        return True

    def tab_chain(self) -> list[QWidget]:
        """Return what Tab goes through: the fields from top to bottom, then the buttons."""

        def place(field: QWidget) -> tuple[int, int]:
            center = field.mapTo(self._body, field.rect().center())
            return center.y() // self.display_style.px(16), center.x()

        fields = [
            field
            for field in self._body.findChildren(QWidget)
            if field.focusPolicy() & Qt.FocusPolicy.TabFocus
            and field.focusProxy() is None
            # Not what pops up from a field.
            and field.window() is self
        ]
        return [*sorted(fields, key=place), *self.buttons.buttons()]

    def fit_to_content(self, width: int = 640) -> None:
        """Take the size of the content, within the screen."""
        wide = self.display_style.px(width)
        high = self._body.heightForWidth(wide)
        if high <= 0:
            high = self._body.sizeHint().height()
        high += self.display_style.px(64)
        screen = self.screen().availableSize() if self.screen() else None
        if screen is not None:
            wide, high = min(wide, screen.width() - 32), min(high, screen.height() - 64)
        self.resize(wide, high)
