"""The line of every key of a TOML text."""

import re
import tomllib
from pathlib import Path

import pytest

import gsapp
from gsapp.foundation.toml_lines import key_lines, walk_values

TEXT = """\
# first
name = '''a
[b]'''
items = [
  1, # ]
]
[[cards]]
id = "a"

[[cards]] # second
"id" = [
  1,
]
[cards.speed]
"""


def test_each_key_has_the_line_where_its_statement_begins() -> None:
    assert key_lines(TEXT) == {
        "name": 2, "items": 4, "items[0]": 4, "cards": 7, "cards[0]": 7, "cards[0].id": 8,
        "cards[1]": 10, "cards[1].id": 11, "cards[1].id[0]": 11, "cards[1].speed": 14,
    }  # fmt: skip


@pytest.mark.parametrize(
    "text",
    ["''''''", "'''#'''", "'''\n[x]\n'''", "'''a''''", "'''a'''''", "'''\"\"\"'''", '"a#\\"["',
     '""""""', '"""a""""', '"""a"""""', '"""a\\""""', '"""\\\n["""', '"""\'\'\'"""', "'\\'"],
)  # fmt: skip
def test_a_string_ends_where_its_quotes_do(text: str) -> None:
    whole = f"a = [{text}, 1]\nb = 1"
    assert tomllib.loads(whole)["b"] == 1
    assert key_lines(whole)["b"] == whole.count("\n") + 1


@pytest.mark.parametrize(
    "path", sorted(Path(gsapp.__file__).parent.rglob("*.toml")), ids=lambda path: path.name
)
def test_every_key_of_the_shipped_files_has_its_line(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    lines = key_lines(text)
    assert set(lines) == {key for key, _ in walk_values(tomllib.loads(text))}
    rows = text.split("\n")
    for key, line in lines.items():
        name = re.sub(r"(\[\d+\])+$", "", key).rpartition(".")[2]
        assert name in rows[line - 1]
