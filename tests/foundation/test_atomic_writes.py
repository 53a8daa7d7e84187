"""A file is replaced whole or not at all."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from gsapp.foundation import write_atomically


def test_a_failed_write_leaves_the_former_file_and_no_litter(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write_atomically(tmp_path / "a" / "file.txt", "before")

    def refuse(_: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", refuse)
    with pytest.raises(OSError, match="No space left"):
        write_atomically(path, "after")
    assert path.read_text() == "before"
    assert [entry.name for entry in path.parent.iterdir()] == ["file.txt"]


def test_text_is_utf8_with_line_feeds_on_every_system(tmp_path: Path) -> None:
    path = write_atomically(tmp_path / "file.txt", "α\nβ\n")
    assert path.read_bytes() == "α\nβ\n".encode()
