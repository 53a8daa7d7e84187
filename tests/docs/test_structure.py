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


METHOD_PACKAGES = (
    "calibration", "gsapp/identification", "gsapp/excitation", "gsapp/discrepancy", "gsapp/flight",
    "gsapp/decoding", "gsapp/session", "gsapp/telemetry",
)  # fmt: skip
FIXED_NUMBERS = {
    "_CUTOFF_TIMES_WIDTH", "_MEDIAN_OF_NORMAL", "_PER_MILLION", "ADC_FULL_SCALE",
    "DEFAULT_GRID_RATE",
}  # fmt: skip
"""Numbers of mathematics and of hardware, and the default of a field that a user sets."""


def module_numbers(source: str) -> set[str]:
    """Return the names of module constants that are a number times constants, and no integer."""
    return {
        target.id
        for node in ast.parse(source).body
        if isinstance(node, ast.Assign | ast.AnnAssign)
        for target in (node.targets if isinstance(node, ast.Assign) else [node.target])
        if isinstance(target, ast.Name)
        if isinstance(value := node.value, ast.BinOp | ast.Constant | ast.UnaryOp)
        if all(not isinstance(part, ast.Call | ast.Attribute) for part in ast.walk(value))
        if any(isinstance(getattr(part, "value", 0), float) for part in ast.walk(value))
    }


def test_numbers_of_a_method_are_in_its_settings() -> None:
    strays = {
        name
        for package in METHOD_PACKAGES
        for path in (ROOT / package).rglob("*.py")
        for name in module_numbers(path.read_text(encoding="utf-8"))
    }
    assert strays == FIXED_NUMBERS


def test_a_number_of_a_module_is_found() -> None:
    source = "A = 1.5\n_B: Final = 0.1 * DEGREE\nC = 3\nD = f(1.0)\nE = 2.0 * math.pi\n"
    assert module_numbers(source) == {"A", "_B"}


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
