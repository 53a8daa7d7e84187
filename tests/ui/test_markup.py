"""Text of a stranger's file is shown as it stands: markup in it loads nothing, forges nothing."""

from pathlib import Path

from PySide6.QtCore import QAbstractListModel, QModelIndex, Qt
from PySide6.QtGui import Qt as RichText
from PySide6.QtWidgets import QAbstractItemView, QApplication, QLabel, QMessageBox, QWidget
from pytestqt.qtbot import QtBot

from tests.ui.window_kit import until, write_flight
from ui.main_window import MainWindow
from ui.widgets.labels import create_label, plain_tooltip
from ui.widgets.message_boxes import create_message_box

PICTURE = '<img src="missing.png">'
FORGED = "<h1>All is well</h1>"


def _obeyed(widget: QLabel) -> bool:
    """Return whether a label renders its text as markup."""
    if widget.textFormat() is Qt.TextFormat.PlainText:
        return False
    return widget.textFormat() is not Qt.TextFormat.AutoText or RichText.mightBeRichText(
        widget.text()
    )


def _tooltips(widget: QWidget) -> list[str]:
    found = [widget.toolTip()]
    if isinstance(widget, QAbstractItemView) and widget.model() is not None:
        model = widget.model()
        root = QModelIndex()
        for row in range(min(model.rowCount(root), 200)):
            columns = 1 if isinstance(model, QAbstractListModel) else model.columnCount(root)
            for column in range(columns):
                given = model.index(row, column, root).data(Qt.ItemDataRole.ToolTipRole)
                found.append(str(given or ""))
    return found


def _shown(window: MainWindow) -> str:
    return "".join(one.text() for one in window.findChildren(QLabel))


def test_markup_in_names_and_notes_is_shown_on_every_page(
    window: MainWindow, qtbot: QtBot, tmp_path: Path
) -> None:
    """A column, the name of the file and a note of a flight hold pictures and headings."""
    path = write_flight(tmp_path / "flight")
    lines = path.read_text("utf-8").splitlines()
    rows = [lines[0] + f",x {PICTURE}", *(f"{line},1.0" for line in lines[1:])]
    path.with_name("columns.csv").write_text("\n".join(rows), "utf-8")
    named = path.rename(path.with_name(f"a {PICTURE}.csv"))
    opener = window.flight_controller.flight_opener
    opener.open_flight(path.with_name("columns.csv"), playing=False)  # refused, in a banner
    until(qtbot, lambda: PICTURE in _shown(window))
    opener.open_flight(named, playing=False)
    until(qtbot, lambda: window.flight_controller.is_loaded)
    assert window.flight_controller.mark(1.0, FORGED)
    seen = ""
    for name in ("preflight", "flight", "pilot", "review", "gap"):
        window.show_page(name)
        qtbot.wait(300)
        for widget in window.findChildren(QWidget):
            if isinstance(widget, QLabel):
                seen += widget.text()
                assert not _obeyed(widget), widget.text()
            for tooltip in _tooltips(widget):
                assert PICTURE not in tooltip
                assert FORGED not in tooltip
    assert PICTURE in seen
    QApplication.processEvents()


def test_labels_boxes_and_tooltips_take_text_as_it_is(qtbot: QtBot) -> None:
    label = create_label(f"{PICTURE}{FORGED}", wrap=True)
    qtbot.addWidget(label)
    assert not _obeyed(label)
    box = create_message_box(None, "Title", PICTURE, FORGED)
    qtbot.addWidget(box)
    box.addButton(QMessageBox.StandardButton.Close)
    shown = {one.text() for one in box.findChildren(QLabel)}
    assert {PICTURE, FORGED} <= shown
    assert not any(_obeyed(one) for one in box.findChildren(QLabel))
    assert "<img" not in plain_tooltip(PICTURE)
    assert plain_tooltip("a < b") == "a < b"
