"""Ground station for flight-testing remotely piloted research aircraft.

The names in `__all__` are the Python API: the requests and results of the commands, for notebooks
and scripts. Each is imported when it is first used.
"""

from __future__ import annotations

import os
import sys
from importlib import import_module
from types import ModuleType

TYPE_CHECKING = False  # as in `typing`, whose import takes as long as all the rest
if TYPE_CHECKING:
    from typing import Any

    from gsapp.api.estimation import discrepancy, estimate, report
    from gsapp.api.fleet import changes, trend
    from gsapp.api.flights import export, fly, maneuvers, open  # noqa: A004  as PIL.Image.open
    from gsapp.api.instruments import calibrate, compatibility

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

__all__ = [
    "__version__",
    "calibrate",
    "changes",
    "compatibility",
    "discrepancy",
    "estimate",
    "export",
    "fly",
    "maneuvers",
    "open",
    "report",
    "trend",
]
_MODULES = {
    "calibrate": "gsapp.api.instruments",
    "changes": "gsapp.api.fleet",
    "compatibility": "gsapp.api.instruments",
    "discrepancy": "gsapp.api.estimation",
    "estimate": "gsapp.api.estimation",
    "export": "gsapp.api.flights",
    "fly": "gsapp.api.flights",
    "maneuvers": "gsapp.api.flights",
    "open": "gsapp.api.flights",
    "report": "gsapp.api.estimation",
    "trend": "gsapp.api.fleet",
}
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


class _CallablePackage(ModuleType):
    """A package of the program that is also the function of its name."""

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        name = self.__name__.rpartition(".")[2]
        return getattr(import_module(_MODULES[name]), name)(*args, **kwargs)


class _Package(ModuleType):
    """Makes subpackages callable that have the name of a function, when they are imported."""

    def __setattr__(self, name: str, value: Any) -> None:
        if name in _MODULES and isinstance(value, ModuleType):
            value.__class__ = _CallablePackage
        super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Package
