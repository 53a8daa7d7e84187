"""Write the lock files from pyproject.toml. Needs `uv` on the PATH."""

from __future__ import annotations

import re
import subprocess
import tempfile
from pathlib import Path

HERE = Path(__file__).parent
COMPILE = [
    "uv", "pip", "compile", "pyproject.toml", "-", "--universal", "--python-version", "3.11",
    "--fork-strategy", "fewest", "--generate-hashes", "--no-emit-index-url", "--no-header",
    "--no-annotate", "--quiet", "--extra", "mat73",
]  # fmt: skip


def compile_lock(target: Path, *options: str) -> None:
    """Resolve the requirements, the build backend among them, into `target`."""
    subprocess.run(
        [*COMPILE, *options, "-o", str(target)],
        cwd=HERE.parent, check=True, text=True, input="setuptools>=77\n", stdout=subprocess.DEVNULL,
    )  # fmt: skip


def requirements(lock: Path) -> list[str]:
    """Return the requirements of a lock file, each with its hashes."""
    return re.split(r"^(?=[A-Za-z0-9])", lock.read_text(), flags=re.MULTILINE)[1:]


def main() -> None:
    """Lock what runs; then what only extras, tests and builds need, at the same versions."""
    compile_lock(HERE / "run.lock")
    needed_to_run = set(requirements(HERE / "run.lock"))
    kinds = dict.fromkeys(("parquet", "notebook", "dask"), "--extra")
    kinds |= dict.fromkeys(("test", "build"), "--group")
    for name, option in kinds.items():
        with tempfile.TemporaryDirectory() as folder:
            everything = Path(folder) / "all.lock"
            compile_lock(everything, option, name, "-c", str(HERE / "run.lock"))
            only_this = [text for text in requirements(everything) if text not in needed_to_run]
        (HERE / f"{name}.lock").write_text("".join(only_this))


if __name__ == "__main__":
    main()
