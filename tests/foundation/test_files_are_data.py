"""Files are data: nothing that is read from one runs."""

import ast
from pathlib import Path

ROOT = Path(__file__).parents[2]
CODE = {"eval", "exec", "compile", "__import__"}
LOADERS = {
    "pickle": {"load", "loads", "Unpickler"}, "marshal": {"load", "loads"}, "shelve": {"open"},
    "dill": {"load", "loads"}, "joblib": {"load"}, "yaml": {"load", "unsafe_load", "full_load"},
    "runpy": {"run_path", "run_module"}, "os": {"system", "popen"},
}  # fmt: skip
OWN_PROCESS = "gsapp/flight/readers/reader_process.py"
"""Reads what a process of the program writes, and takes no names but those of plain numbers."""
OWN_MEMORY = "gsapp/foundation/temporary_arrays.py"
"""Reads back at once what it pickled in memory; only the numbers of arrays go through a file."""


def found_in(source: str) -> set[str]:
    """Return what could turn data into code."""
    found = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Name) and node.id in CODE:
            found.add(node.id)
        if (
            isinstance(node, ast.Attribute)
            and isinstance(node.value, ast.Name)
            and node.attr in LOADERS.get(node.value.id, ())
        ):
            found.add(f"{node.value.id}.{node.attr}")
        if isinstance(node, ast.ImportFrom) and node.module in LOADERS:
            found |= {
                f"{node.module}.{one.name}"
                for one in node.names
                if one.name in LOADERS[node.module]
            }
        if (
            isinstance(node, ast.keyword)
            and node.arg in ("allow_pickle", "shell")
            and isinstance(node.value, ast.Constant)
            and node.value.value is True
        ):
            found.add(node.arg)
    return found


def test_no_module_turns_a_file_into_code() -> None:
    found = {
        path.relative_to(ROOT).as_posix(): calls
        for folder in ("gsapp", "ui", "calibration")
        for path in (ROOT / folder).rglob("*.py")
        if (calls := found_in(path.read_text(encoding="utf-8")))
    }
    assert found == {OWN_PROCESS: {"pickle.Unpickler"}, OWN_MEMORY: {"pickle.loads"}}


def test_what_would_be_found() -> None:
    assert found_in("import pickle\npickle.load(f)") == {"pickle.load"}
    assert found_in("from pickle import loads") == {"pickle.loads"}
    assert found_in("np.load(f, allow_pickle=True)") == {"allow_pickle"}
    assert found_in("eval(text)") == {"eval"}
    assert found_in("np.load(f, allow_pickle=False)") == set()
