"""What a file is called that is asked for."""

from collections.abc import Callable
from pathlib import Path

import pytest
from PySide6.QtWidgets import QFileDialog

from ui.dialogs.file_dialogs import ask_save_file

PAGE, PAPER = "HTML (*.html)", "PDF (*.pdf)"


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Callable[..., Path | None]:
    """Return what is called what, after all that the user answers, name and kind each."""

    def ask(*answers: tuple[str, str]) -> Path | None:
        left, proposed = list(answers), ["report.html"]

        def dialog(_parent: object, _title: str, start: str, _kinds: str) -> tuple[str, str]:
            assert start == str(tmp_path / proposed[-1])
            name, kind = left.pop(0)
            proposed.append(f"{name}.html")
            return str(tmp_path / name) if name else "", kind

        monkeypatch.setattr(QFileDialog, "getSaveFileName", dialog)
        start = tmp_path / "report.html"
        path = ask_save_file(None, "Write the report", start, f"{PAGE};;{PAPER}")
        assert not left
        return path

    return ask


@pytest.mark.parametrize(
    ("name", "kind", "file"),
    [
        ("flown", PAGE, "flown.html"),
        ("flown", PAPER, "flown.pdf"),
        ("flown", "", "flown.html"),
        ("flown v1.2", PAPER, "flown v1.2.pdf"),
        ("flown.pdf", PAGE, "flown.pdf"),
        ("FLOWN.PDF", PAGE, "FLOWN.PDF"),
    ],
)
def test_a_file_gets_the_ending_of_its_kind_unless_it_has_one(
    asked: Callable[..., Path | None], tmp_path: Path, name: str, kind: str, file: str
) -> None:
    assert asked((name, kind)) == tmp_path / file


def test_nothing_chosen_is_no_file(asked: Callable[..., Path | None]) -> None:
    assert asked(("", "")) is None


def test_a_file_that_has_the_whole_name_is_not_replaced_unasked(
    asked: Callable[..., Path | None], tmp_path: Path
) -> None:
    (tmp_path / "flown.html").touch()
    assert asked(("flown", PAGE), ("", "")) is None
    assert asked(("flown", PAGE), ("flown.html", PAGE)) == tmp_path / "flown.html"
