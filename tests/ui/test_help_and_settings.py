"""Settings, About, user guide, themes by name, and the flights opened last."""

import os
import platform
import re
import shutil
import tomllib
from pathlib import Path

import pytest
from PySide6.QtCore import QEvent, QPoint, QUrl
from PySide6.QtGui import QGuiApplication, QHelpEvent, QImage
from PySide6.QtWidgets import QApplication, QPushButton
from pytestqt.qtbot import QtBot

from tests.ui.window_kit import answer_dialog, until, write_flight
from ui.appearance_controller import SettingsDialog
from ui.dialogs.flight_dialogs import GoToDialog
from ui.display_style import DisplayStyle
from ui.help_menu import AboutDialog, GuideWindow, guide_folder, guide_pages
from ui.main_window import MainWindow
from ui.settings import Settings, SettingsStore
from ui.theme import THEMES, contrast


def test_settings_are_put_in_force_and_kept(window: MainWindow, tmp_path: Path) -> None:
    def answer(dialog: SettingsDialog) -> None:
        assert dialog.flights.path == tmp_path / "flights"
        for box, value in (
            (dialog.theme, "dark"), (dialog.scale, 125), (dialog.units, "SI"),
            (dialog.speech, "always"),
        ):  # fmt: skip
            box.setCurrentIndex(box.findData(value))
        dialog.sound.setChecked(True)
        dialog.flights.edit.setText(str(tmp_path / "other"))
        dialog.accept()

    answer_dialog(SettingsDialog, answer)
    window.commands.actions["settings"].trigger()
    assert (
        window.display_style.theme.name,
        window.display_style.scale,
        window.display_style.units,
    ) == ("dark", 125, "SI")
    kept = SettingsStore(window.store.path).current
    assert (kept.theme, kept.scale, kept.units, kept.muted) == ("dark", 125, "SI", False)
    assert kept.flights == str(tmp_path / "other")
    assert kept.flight_speech == "always"
    assert window.commands.actions["pilot_speak"].isChecked()
    assert window.commands.actions["theme_dark"].isChecked()


def test_defaults_come_back_once_saved(window: MainWindow) -> None:
    window.store.change(links=("udpin:127.0.0.1:14550",))
    window.display_style.set_theme("dark")

    def answer(dialog: SettingsDialog) -> None:
        next(one for one in dialog.buttons.buttons() if "Restore" in one.text()).click()
        assert window.display_style.theme.name == "dark"
        dialog.accept()

    answer_dialog(SettingsDialog, answer)
    window.commands.actions["settings"].trigger()
    usual, kept = Settings(), window.store.current
    for name in ("theme", "scale", "units", "muted", "flights", "aircraft", "calibration",
                 "flight_speech"):  # fmt: skip
        assert getattr(kept, name) == getattr(usual, name), name
    assert kept.links == ("udpin:127.0.0.1:14550",)


def test_the_layout_is_reset_once_asked_for(
    window: MainWindow, qtbot: QtBot, tmp_path: Path
) -> None:
    """Also the width of the side panel, and that it is open."""
    window.resize(1440, 900)
    window.appearance.layout_reset.emit()  # without a flight, too
    window.flight_controller.flight_opener.open_flight(
        write_flight(tmp_path / "flights"), playing=False
    )
    until(
        qtbot, lambda: window.flight_controller.is_loaded and window.flight_controller.is_up_to_date
    )
    view = window.view
    view.show_panel(0)
    before = view.tabs.width()
    view.layouts.show_layout("Lateral")
    view._split.moveSplitter(view._split.width() - before - 150, 1)
    assert view.tabs.width() >= before + 100
    view.toggle_panel()
    for reset in (False, True):

        def answer(dialog: SettingsDialog, reset: bool = reset) -> None:
            dialog.reset_layout.setChecked(reset)
            dialog.accept()

        answer_dialog(SettingsDialog, answer)
        window.commands.actions["settings"].trigger()
        kept = window.store.current
        assert (kept.layout, kept.side_panel) == (
            ("Overview", True) if reset else ("Lateral", False)
        )
        assert view.panel_shown[0] == reset
    qtbot.wait(400)  # a width drawn before must not be written down now
    assert window.store.current.panel_width == 0
    assert view.tabs.width() == before


def test_a_theme_is_named_and_checked(window: MainWindow) -> None:
    actions = window.commands.actions
    for name in (*list(THEMES)[1:], "daylight"):
        actions["next_theme"].trigger()
        assert window.display_style.theme.name == name
        assert [one for one in THEMES if actions[f"theme_{one}"].isChecked()] == [name]
        texts = [banner.label.text().lower().replace(" ", "-") for banner in window.banners.banners]
        assert len(texts) == 1
        assert texts[0].startswith(name)
    actions["theme_daylight"].trigger()
    assert actions["theme_daylight"].isChecked()
    actions["theme_high-contrast"].trigger()
    assert window.display_style.theme.name == "high-contrast"


def test_about_is_copied_whole(window: MainWindow) -> None:
    def answer(dialog: AboutDialog) -> None:
        dialog.copy.click()

    answer_dialog(AboutDialog, answer)
    window.commands.actions["about"].trigger()
    copied = QGuiApplication.clipboard().text()
    for fact in (platform.python_version(), "Qt: 6", str(window.store.path), "window.log"):
        assert fact in copied


def test_every_page_of_the_guide_opens_without_a_network(window: MainWindow) -> None:
    folder = guide_folder()
    window.commands.actions["guide"].trigger()
    (guide,) = window.findChildren(GuideWindow)
    assert guide.isVisible()
    kinds = ("how-to", "reference", "explanation")
    pages = [*folder.glob("*.md"), *(one for kind in kinds for one in folder.glob(f"{kind}/*.md"))]
    assert guide.pages.count() == len(guide_pages(folder)) == len(pages)
    for row in range(guide.pages.count()):
        guide.pages.setCurrentRow(row)
        assert len(guide.browser.toPlainText()) > 500
    guide.close()


@pytest.mark.parametrize("installed", [False, True])
def test_the_license_opens_from_its_page(qtbot: QtBot, tmp_path: Path, installed: bool) -> None:
    folder = guide_folder()
    assert folder is not None
    if installed:
        pages = [folder / "licenses.md", folder / "tutorial.md", folder.parent / "LICENSE"]
        folder = tmp_path / "gsapp"
        folder.mkdir()
        for page in pages:
            shutil.copy(page, folder)
    guide = GuideWindow(DisplayStyle(), folder)
    qtbot.addWidget(guide)
    guide.show_page(folder / "licenses.md")
    guide.browser.anchorClicked.emit(QUrl("../LICENSE"))
    assert "Redistribution and use" in guide.browser.toPlainText()


def test_an_installed_guide_holds_what_its_pages_show_and_link_to() -> None:
    root = Path(__file__).parents[2]
    project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))
    data: dict[str, list[str]] = project["tool"]["setuptools"]["data-files"]
    installed = {
        Path("docs", folder.removeprefix("share/doc/gsapp").lstrip("/"), path.name)
        for folder, patterns in data.items()
        for pattern in patterns
        for path in root.glob(pattern)
    }
    assert Path("docs", "LICENSE") in installed
    for page in sorted(path for path in installed if path.suffix == ".md"):
        text = (root / page).read_text(encoding="utf-8")
        links = re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", text)
        meant = {Path(os.path.normpath(page.parent / link)) for link in links}
        assert {link for link in meant if link.parts[0] == "docs"} <= installed, page
        assert not any(link.suffix == ".png" and link.parts[0] != "docs" for link in meant), page


def test_flights_opened_last_are_offered_and_those_gone_can_be_removed(
    window: MainWindow, qtbot: QtBot, tmp_path: Path
) -> None:
    controller = window.flight_controller
    path = write_flight(tmp_path)
    controller.flight_opener.open_flight(path, playing=False)
    until(qtbot, lambda: controller.is_loaded)
    until(qtbot, lambda: window.store.current.recent_flights[0].date != "")
    controller.close_flight()
    (kept,) = SettingsStore(window.store.path).current.recent_flights
    assert kept.path == str(path)
    assert kept.duration == pytest.approx(19.98)
    start = window.flight_page.start

    def is_listed() -> bool:
        return start.findChildren(QPushButton)[-1].isVisible()

    def button(words: str) -> QPushButton:
        found = [one for one in start.findChildren(QPushButton) if one.isVisible()]
        (one,) = (one for one in found if one.accessibleName().startswith(words))
        return one

    until(qtbot, is_listed)
    assert "00:19" in button("Open small").text()
    button("Open small").click()
    until(qtbot, lambda: controller.is_open)
    path.unlink()
    controller.close_flight()
    until(qtbot, is_listed)
    assert not button("Open small").isEnabled()
    assert str(path) in button("Open small").toolTip()
    button("Remove small").click()
    assert not window.store.current.recent_flights


def test_a_gray_command_says_why(window: MainWindow) -> None:
    for name, action in window.commands.actions.items():
        assert action.isEnabled() or action.toolTip() != action.text(), name
    assert "flight" in window.commands.actions["export"].toolTip()


def test_a_gray_button_of_a_dialog_says_why(qtbot: QtBot) -> None:
    dialog = GoToDialog(DisplayStyle(), 0.0, 60.0, 10.0)
    qtbot.addWidget(dialog)
    dialog.show()
    dialog.edit.setText("soon")
    assert not dialog.button.isEnabled()
    place = QPoint(2, 2)
    QApplication.sendEvent(dialog.button, QHelpEvent(QEvent.Type.ToolTip, place, place))
    assert dialog.button.toolTip() == dialog.message.text()


def text_contrast(image: QImage) -> float:
    ground = image.pixelColor(8, image.height() // 2).name()
    rows = range(6, image.height() - 6)
    return max(
        contrast(image.pixelColor(x, y).name(), ground)
        for x in range(8, image.width() - 8)
        for y in rows
    )


@pytest.mark.parametrize("theme", THEMES)
def test_a_gray_button_looks_other_than_one_that_can_be_pressed(
    window: MainWindow, qtbot: QtBot, theme: str
) -> None:
    window.display_style.set_theme(theme)
    for role in ("", "primary", "quiet"):
        holder = QPushButton("Open", window)
        holder.setProperty("role", role)
        holder.show()
        pixels = []
        for is_enabled in (True, False):
            holder.setEnabled(is_enabled)
            qtbot.wait(1)
            image = QImage(holder.size(), QImage.Format.Format_RGB32)
            image.fill(window.display_style.color("panel"))
            holder.render(image)
            pixels.append(image)
        strongest = [text_contrast(image) for image in pixels]
        assert strongest[1] < 0.6 * strongest[0], role
        holder.deleteLater()
