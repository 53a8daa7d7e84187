"""Structure of the code: size of classes, and no import cycles."""

import ast
from pathlib import Path

import grimp
import pytest

ROOT = Path(__file__).parents[2]
PACKAGES = ("gsapp", "ui", "calibration")
MAX_CLASS_LINES = 400


def class_lengths(source: str) -> dict[str, int]:
    return {
        node.name: (node.end_lineno or node.lineno) - node.lineno + 1
        for node in ast.walk(ast.parse(source))
        if isinstance(node, ast.ClassDef)
    }


def test_no_class_is_longer_than_400_lines() -> None:
    longer = {
        name
        for package in PACKAGES
        for path in (ROOT / package).rglob("*.py")
        for name, lines in class_lengths(path.read_text(encoding="utf-8")).items()
        if lines > MAX_CLASS_LINES
    }
    assert not longer


def test_the_length_of_a_class_is_counted_with_its_docstring_and_methods() -> None:
    source = 'x = 1\nclass A:\n    """A."""\n\n    def f(self):\n        return 1\n\ny = 2\n'
    assert class_lengths(source) == {"A": 5}


def find_import_cycle(imports: dict[str, set[str]]) -> list[str]:
    """Return modules that import one another in a circle; none if there is none."""
    done: set[str] = set()

    def search(module: str, path: list[str]) -> list[str]:
        if module in path:
            return path[path.index(module) :]
        if module in done:
            return []
        for imported in sorted(imports.get(module, ())):
            if cycle := search(imported, [*path, module]):
                return cycle
        done.add(module)
        return []

    return next((cycle for module in sorted(imports) if (cycle := search(module, []))), [])


def test_no_modules_import_one_another() -> None:
    graph = grimp.build_graph(*PACKAGES, exclude_type_checking_imports=True, cache_dir=None)
    imports = {module: graph.find_modules_directly_imported_by(module) for module in graph.modules}
    assert not find_import_cycle(imports)


@pytest.mark.parametrize(
    ("imports", "cycle"),
    [
        ({"a": {"b"}, "b": {"c"}, "c": set()}, []),
        ({"a": {"b"}, "b": {"c"}, "c": {"b"}}, ["b", "c"]),
    ],
)
def test_an_import_cycle_is_found(imports: dict[str, set[str]], cycle: list[str]) -> None:
    assert find_import_cycle(imports) == cycle
