"""The log of the window: turned over where the system lets it, and never lost."""

import logging
from pathlib import Path

import pytest

from ui.error_reporter import _RotatingLog


def turned_log(path: Path) -> _RotatingLog:
    handler = _RotatingLog(path, maxBytes=100, backupCount=3, encoding="utf-8")
    handler.setFormatter(logging.Formatter("%(message)s"))
    return handler


def write(handler: logging.Handler, text: str) -> None:
    handler.emit(logging.LogRecord("x", logging.INFO, "x", 1, text, None, None))


def test_a_log_that_another_window_has_open_grows_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "window.log"
    former = path.with_name("window.log.1")
    handler = turned_log(path)
    write(handler, "a" * 90)
    write(handler, "b" * 90)
    assert former.read_text() == f"{'a' * 90}\n"

    def refuse(self: Path, _target: object) -> None:
        raise PermissionError(13, "in use", str(self))

    with monkeypatch.context() as windows:
        windows.setattr(Path, "rename", refuse)
        for letter in "cdef":
            write(handler, letter * 90)
    assert path.read_text() == "".join(f"{letter * 90}\n" for letter in "bcdef")
    assert former.read_text() == f"{'a' * 90}\n"
    write(handler, "g" * 90)
    assert path.read_text() == f"{'g' * 90}\n"
    assert former.read_text().startswith("b" * 90)
    handler.close()
    assert capsys.readouterr().err == ""
