"""Files with mistakes name every mistake, its place, and the remedy."""

from pathlib import Path

import pytest

from gsapp.foundation import FileProblemsError, StrictModel, read_toml, write_toml


class Inner(StrictModel):
    size: float
    items: tuple[int, ...] = ()


class Outer(StrictModel):
    name: str
    inner: Inner
    parts: tuple[Inner, ...] = ()


def problems(tmp_path: Path, text: str | bytes) -> list[str]:
    path = tmp_path / "file.toml"
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    with pytest.raises(FileProblemsError) as caught:
        read_toml(path, Outer)
    assert str(path) in str(caught.value)
    return [str(problem) for problem in caught.value.problems]


def test_every_mistake_is_reported_at_once_with_its_key_path(tmp_path: Path) -> None:
    found = problems(tmp_path, "nam = 'x'\n[inner]\nsise = 1\n[[parts]]\nsize = 'big'\n")
    keys = [problem.split(":")[0] for problem in found]
    assert keys == ["name", "inner.size", "inner.sise", "parts[0].size", "nam"]
    assert "'size'" in found[2]
    assert "'name'" in found[4]


def test_a_syntax_error_names_line_and_column(tmp_path: Path) -> None:
    (only,) = problems(tmp_path, "name = 'x'\nsize = 3 ft\n")
    assert only.startswith("line 2, column")


def test_bytes_that_are_not_text_are_named(tmp_path: Path) -> None:
    (only,) = problems(tmp_path, b"name = '\xff\xfe'")
    assert only.startswith("byte 8: ")


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(FileProblemsError, match="cannot be read"):
        read_toml(tmp_path / "absent.toml", Outer)


def test_what_is_written_reads_back_without_none(tmp_path: Path) -> None:
    path = write_toml(tmp_path / "f.toml", {"name": "x", "inner": {"size": 1.5, "items": [1, 2]}})
    assert read_toml(path, Outer) == Outer(name="x", inner=Inner(size=1.5, items=(1, 2)))
    assert "gone" not in write_toml(path, {"gone": None}).read_text()
