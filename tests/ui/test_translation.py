"""The window in a made-up language: every text of `ui` that it shows comes from a translation.

The language is what ``pyside6-lupdate`` finds, each text in brackets ⟦⟧ and each field in ⟪⟫: the
value of a field must be translated, too. Exempt are unmarked texts of `gsapp` and `calibration`,
digits, units, names of channels, derivatives, keys and files.
"""

import ast
import re
import string
import subprocess
import sysconfig
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from pathlib import Path

import pytest
from PySide6.QtCore import QLocale
from PySide6.QtGui import QKeySequence
from PySide6.QtWidgets import QApplication, QCheckBox, QLabel, QWidget
from pytestqt.qtbot import QtBot

import calibration
import gsapp
import ui
from calibration.settings import FIT_ORDER_TITLES
from gsapp.foundation.settings import setting_info
from gsapp.identification.estimate_settings import EstimateSettings
from gsapp.identification.methods import estimation_methods
from gsapp.quantities import CHANNELS
from gsapp.telemetry.recording_settings import RecordingSettings
from tests.ui import pilot_kit
from tests.ui.shown_text import PaintedText
from tests.ui.window_walk import Walk, filled_window
from ui import translation
from ui.dialogs.connect import ConnectDialog, connection_options
from ui.dialogs.flight_requests import VirtualFlightRequest
from ui.dialogs.virtual_flight import VirtualFlightDialog, VirtualFlightOptions
from ui.display_style import DisplayStyle
from ui.gap.search_jobs import GapRequest
from ui.gap.search_setup_page import SearchSetupPage
from ui.settings import Settings, SettingsStore
from ui.translation import install_translator, tr

SCRIPTS = Path(sysconfig.get_path("scripts"))
FOLDER = Path(ui.__file__).parent
PACKAGES = [Path(one.__file__).parent for one in (ui, gsapp, calibration)]
LANGUAGE = QLocale("eo")
MARKS = {"tr", "QT_TR_NOOP"}
SETTERS = {
    "setAccessibleDescription", "setAccessibleName", "setInformativeText", "setPlaceholderText",
    "setStatusTip", "setText", "setTitle", "setToolTip", "setWhatsThis", "setWindowTitle",
    "addAction", "addButton", "addItem", "addItems", "addMenu", "addRow", "addTab", "setTabText",
    "add_row", "add_button", "add_command", "set_message", "show_banner", "show_message",
    "QAction", "QCheckBox", "QGroupBox", "QLabel", "QMenu", "QPushButton", "ActionButton",
    "create_label", "getOpenFileName", "getOpenFileNames", "getSaveFileName", "getText",
    "getExistingDirectory", "BackgroundJob", "UndoCommand",
}  # fmt: skip
"""What shows the texts that it is given."""
NAMES = {"Python", "Python: ", "Qt", "Qt: ", "LINK", "RMS", "Theil", "US", "SI", "GB", *CHANNELS}
"""The same in every language."""
SILENT_CALLS = {
    "info", "warning", "error", "compile", "startswith", "setStyleSheet", "send_line", "_command",
    "acknowledge", "count_text", "Thread", "ValueError", "IndexError",
}  # fmt: skip
"""What writes a log, asks for a pattern, tells a programmer, or translates."""
SILENT_MODULES = {
    "app.py", "display_check.py", "display_style.py", "style_sheet.py", "practice_bench.py",
    "sound_output.py", "screen_saver_inhibitor.py", "search_jobs.py", "onboard_log_worker.py",
}  # fmt: skip
"""Of terminals, of other programs, and of processes that have no language."""
SILENT_TEXTS = {
    " model gap.html", " report.html", "test cards.toml", " trial ", "next flight", " min",
    ", | and ", "the run is not saved", "wrong side", "no data", "no aircraft", "not read",
    "catching up", "Sans Serif", "roll rate", "yaw rate",
}  # fmt: skip
"""Names of files, units, and words of `gsapp`."""
_WORDS = re.compile(r"[A-Za-z]{2,}[,:;.]? [A-Za-z]|^ [a-z]{3}")
_FIELD = re.compile(r"\{[^{}]*(?:\{[^{}]*\}[^{}]*)*\}")
_TRANSLATED = re.compile(r"⟦([^⟦⟧]*)⟧")
_BREAKS = re.compile(r"[\x00⟪⟫\n]|[:;,.] | · | \(| {2,}")
_EDGES = string.whitespace + string.digits + "·:;,.()…–&"
_WORD = re.compile(r"[^\W\d_]{2,}")


def modules(*packages: Path) -> Iterator[tuple[Path, ast.Module]]:
    for package in packages:
        for path in sorted(package.rglob("*.py")) or [package]:
            yield path, ast.parse(path.read_text(encoding="utf-8"))


def name_of(call: ast.Call) -> str:
    function = call.func
    if isinstance(function, ast.Attribute):
        return function.attr
    return function.id if isinstance(function, ast.Name) else ""


def calls(tree: ast.AST, names: set[str]) -> Iterator[ast.Call]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and name_of(node) in names:
            yield node


def shown_strings(tree: ast.AST, other: frozenset[ast.AST] = frozenset()) -> Iterator[str]:
    """Yield the literals that are neither documentation, nor dictionary keys, nor in `other`."""
    other = other | {node.value for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    other |= {key for node in ast.walk(tree) if isinstance(node, ast.Dict) for key in node.keys}
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and node not in other:
            yield node.value


def bare_texts(node: ast.expr) -> Iterator[str]:
    """Yield the texts of an argument that no translation can replace."""
    if isinstance(node, ast.IfExp):
        yield from bare_texts(node.body)
        yield from bare_texts(node.orelse)
    elif isinstance(node, ast.BoolOp | ast.Tuple | ast.List):
        for value in node.values if isinstance(node, ast.BoolOp) else node.elts:
            yield from bare_texts(value)
    elif isinstance(node, ast.BinOp):
        yield from bare_texts(node.left)
        yield from bare_texts(node.right)
    elif isinstance(node, ast.JoinedStr):
        for part in node.values:
            yield from bare_texts(part)
    elif isinstance(node, ast.Constant) and isinstance(node.value, str):
        yield node.value


def test_no_literal_goes_straight_to_the_screen() -> None:
    found = [
        f"{path.relative_to(FOLDER)}:{call.lineno} {text!r}"
        for path, tree in modules(FOLDER)
        for call in calls(tree, SETTERS)
        for argument in call.args
        for text in bare_texts(argument)
        if _WORD.search(text) and (" " in text or text[0].isupper()) and text not in NAMES
    ]
    assert not found, "\n".join(found)


def test_every_text_of_several_words_is_marked() -> None:
    found = []
    for path, tree in modules(FOLDER):
        silent = frozenset(
            part for call in calls(tree, SILENT_CALLS | MARKS) for part in ast.walk(call)
        )
        if path.name not in SILENT_MODULES:
            found += [
                f"{path.relative_to(FOLDER)} {text!r}"
                for text in shown_strings(tree, silent)
                if _WORDS.search(text) and text not in SILENT_TEXTS
            ]
    assert not found, "\n".join(found)


def test_every_mark_holds_a_literal_that_lupdate_reads(sources: set[str]) -> None:
    """Of an expression it would take nothing, or the half; nothing within an f-string."""
    unread = []
    for path, tree in modules(FOLDER):
        for call in calls(tree, MARKS):
            (text,) = call.args
            marked = {text.value} if isinstance(text, ast.Constant) else set()
            if marked - sources or set(bare_texts(text)) - marked:
                unread.append(f"{path.relative_to(FOLDER)}:{call.lineno} {ast.unparse(text)}")
    assert not unread, "\n".join(unread)


@pytest.fixture(scope="module")
def language(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with the made-up language."""
    folder = tmp_path_factory.mktemp("language")
    file = folder / "gsapp_eo.ts"
    update = [SCRIPTS / "pyside6-lupdate", "-silent", "-locations", "none", "-extensions", "py"]
    subprocess.run([*update, *PACKAGES, "-ts", file], check=True, timeout=120.0)
    tree = ET.parse(file)  # noqa: S314 - our own
    for message in tree.iter("message"):
        target = message.find("translation")
        assert target is not None
        text = _FIELD.sub(r"⟪\g<0>⟫", message.findtext("source") or "")
        target.text = f"⟦{text}⟧"
        del target.attrib["type"]
    tree.write(file, encoding="utf-8")
    release = [SCRIPTS / "pyside6-lrelease", "-silent", file, "-qm", folder / "gsapp_eo.qm"]
    subprocess.run(release, check=True, timeout=120.0)
    return folder


@pytest.fixture(scope="module")
def sources(language: Path) -> set[str]:
    tree = ET.parse(language / "gsapp_eo.ts")  # noqa: S314 - our own
    assert {name.text for name in tree.iter("name")} == {None}, "a text has a context"
    return {message.findtext("source") or "" for message in tree.iter("message")}


@pytest.fixture
def translated(language: Path, qapp: QApplication, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(translation, "_translator", None)
    install_translator(qapp, LANGUAGE, language)


def test_a_language_without_a_file_leaves_the_window_in_english(
    qapp: QApplication, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(translation, "_translator", None)
    install_translator(qapp, LANGUAGE, tmp_path)
    assert tr("Open a flight") == "Open a flight"


def test_a_text_is_translated_and_its_fields_are_filled(translated: None) -> None:
    assert tr("Reading {name}").format(name="a.csv") == "⟦Reading ⟪a.csv⟫⟧"
    assert tr("nothing that the window says") == "nothing that the window says"
    assert tr("") == ""


FORM_SETTINGS = (EstimateSettings, GapRequest, RecordingSettings, VirtualFlightRequest)


def test_every_declared_setting_can_be_translated(sources: set[str]) -> None:
    """Command line and form share a declaration; only the form has a language."""
    shown = set(FIT_ORDER_TITLES.values())
    for one in estimation_methods().values():
        shown |= {one.title, one.short_title, one.help_text}
    for settings in FORM_SETTINGS:
        for name, field in settings.model_fields.items():
            shown |= {title for _, title in setting_info(field).choices}
            if field.title:
                shown |= {settings.title_of(name), settings.help_of(name)}
    assert len(shown) > 100
    assert shown <= sources, shown - sources


def test_forms_show_declared_settings_in_the_language(
    translated: None, qtbot: QtBot, tmp_path: Path
) -> None:
    settings, style = Settings(), DisplayStyle()
    options = VirtualFlightOptions(plans=("default",), effects=lambda: ())
    connect = ConnectDialog(settings, style, connection_options(), tmp_path)
    virtual = VirtualFlightDialog(style, options, tmp_path)
    gap = SearchSetupPage(style, SettingsStore(tmp_path / "settings.json"))
    shown = set()
    for form in (connect, virtual, gap):
        qtbot.addWidget(form)
        shown |= {label.text() for label in form.findChildren(QLabel)}
        shown |= {box.text() for box in form.findChildren(QCheckBox)}
        shown |= {widget.toolTip() for widget in form.findChildren(QWidget)}
    shown |= {connect.fields["calibration"].itemText(0)}
    assert {"⟦from the channel map⟧", f"⟦{VirtualFlightRequest.help_of('seed')}⟧"} <= shown
    for declared, name in (
        *((RecordingSettings, name) for name in ("aircraft", "channel_map", "calibration")),
        *((VirtualFlightRequest, name) for name in ("plan", "seed", "thin", "hide")),
        *((GapRequest, name) for name in ("aircraft", "model")),
    ):
        assert f"⟦{declared.title_of(name)}⟧" in shown


def _values(translated: re.Match[str]) -> str:
    """Return what the fields of a translated text hold."""
    return "\x00".join(["", *re.findall(r"⟪([^⟪⟫]*)⟫", translated[1]), ""])


def _is_key(text: str) -> bool:
    return text.startswith(("Ctrl+", "Alt+", "Shift+")) or QKeySequence(text).toString() == text


def untranslated(text: str, literals: set[str], exempt: set[str]) -> str | None:
    """Return the literal of `ui` that stands in a text outside all brackets."""
    former = ""
    while text != former:
        former, text = text, _TRANSLATED.sub(_values, text)
    for piece in (one.strip(_EDGES) for one in _BREAKS.split(text)):
        if piece in literals and piece not in exempt and not _is_key(piece):
            return piece
    return None


@pytest.mark.long
def test_all_that_the_window_shows_is_translated(
    translated: None, qtbot: QtBot, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    literals = {
        text.strip(_EDGES)
        for _path, tree in modules(FOLDER)
        for text in shown_strings(tree)
        if _WORD.search(text)
    }
    core = (Path(one.__file__) for one in (gsapp, calibration))
    given = (*(path.parent for path in core), Path(pilot_kit.__file__))
    exempt = {
        piece.strip(_EDGES)
        for _path, tree in modules(*given)
        for text in shown_strings(tree)
        for piece in _BREAKS.split(text)
    }
    painted = PaintedText(monkeypatch)
    with filled_window(tmp_path, qtbot, monkeypatch) as window:
        walk = Walk(window, painted, qtbot, monkeypatch)
        walk.places()
        walk.dialogs()
        found = dict(walk.found)
        for menu in window.menuBar().actions():
            found.setdefault(menu.text(), "menu bar")
        for action in window.commands.actions.values():
            found.setdefault(action.text(), "command")
    assert sum("⟦" in text for text in found) > 1000
    wrong = {
        text: (bare, where)
        for text, where in found.items()
        if (bare := untranslated(text, literals, exempt)) is not None and bare not in NAMES
    }
    assert not wrong, "\n".join(f"{bare!r} in {text[:200]!r}: {where}"
                                for text, (bare, where) in wrong.items())  # fmt: skip
