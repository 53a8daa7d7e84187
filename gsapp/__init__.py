"""Ground station for flight-testing remotely piloted research aircraft.

The names in `__all__` are the Python API: the requests and results of the commands, for notebooks
and scripts. Each is imported when it is first used.
"""

import os
from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from gsapp.api.flights import open  # noqa: A004  as h5py.File or PIL.Image.open

# Matrices here are small: a second thread of the linear algebra only waits for the first (a fit
# took 4 to 14 times the CPU with two). NumPy reads these when it is first imported; whoever
# wants threads sets them beforehand. The third is that of macOS.
for _name in (
    "OPENBLAS_NUM_THREADS",
    "OMP_NUM_THREADS",
    "VECLIB_MAXIMUM_THREADS",
    "MKL_NUM_THREADS",
):
    os.environ.setdefault(_name, "1")

__all__ = ["__version__", "open"]
_MODULES = {"open": "gsapp.api.flights"}
"""Where each function is defined."""

__version__: str


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import version  # 20 ms

        return version("gsapp-ground-station")
    if name not in _MODULES:
        raise AttributeError(f"module 'gsapp' has no attribute '{name}'")
    return getattr(import_module(_MODULES[name]), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
