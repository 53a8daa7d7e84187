"""MATLAB's ``.mat`` up to version 7, read by SciPy."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from gsapp.foundation import FlightError
from gsapp.quantities import FloatArray

_HDF5 = b"\x89HDF\r\n\x1a\n"
_HDF5_AT = 512


def read_mat_columns(path: Path | str) -> tuple[dict[str, FloatArray], dict[str, str]]:
    """Read the arrays of numbers of a ``.mat`` file.

    Returns
    -------
    columns : dict of str to ndarray, shape (n,) or (n, k)
        By variable; a member of a structure is ``gyro.q``, one of the second in an array of
        structures ``gyro[1].q``. Rows stand for time.
    units : dict of str to str
        The texts of a structure called ``units``, by member.

    Raises
    ------
    FlightError
        If the file cannot be read, or is of version 7.3, which is HDF5.
    """
    file = Path(path)
    try:
        with file.open("rb") as stream:
            head = stream.read(_HDF5_AT + len(_HDF5))
    except OSError as error:
        raise FlightError(
            f"{file} cannot be read ({error.strerror}); check the path and the permissions"
        ) from error
    if head.startswith((b"MATLAB 7.3", _HDF5)) or head[_HDF5_AT:] == _HDF5:
        raise FlightError(
            f"{file} is of version 7.3, which is HDF5; in MATLAB save it with "
            "save('file.mat', '-v7')"
        )
    if not head.startswith(b"MATLAB 5.0"):
        raise FlightError(f"{file} is not a MATLAB .mat file of version 5 to 7; name another file")
    from scipy.io import loadmat  # a tenth of a second

    try:
        content = loadmat(file, simplify_cells=True)
    except Exception as error:
        # A damaged file makes SciPy's parser raise whatever it stumbles over.
        raise FlightError(
            f"{file} is damaged ({type(error).__name__}: {error}); save it again in MATLAB with "
            "save('file.mat', '-v7')"
        ) from error
    columns: dict[str, FloatArray] = {}
    stated = content.pop("units", None)
    units = (
        {str(name): text for name, text in stated.items() if isinstance(text, str)}
        | {str(name): "" for name, text in stated.items() if _is_empty(text)}
        if isinstance(stated, Mapping)
        else {}
    )
    _collect("", {k: v for k, v in content.items() if not k.startswith("__")}, columns)
    return columns, units


def _is_empty(value: Any) -> bool:
    return isinstance(value, np.ndarray) and value.size == 0


def _collect(prefix: str, content: Mapping[str, Any], columns: dict[str, FloatArray]) -> None:
    for name, value in content.items():
        if isinstance(value, Mapping):
            _collect(f"{prefix}{name}.", value, columns)
        elif isinstance(value, list) and all(isinstance(one, Mapping) for one in value):
            for place, one in enumerate(value):
                _collect(f"{prefix}{name}[{place}].", one, columns)
        elif isinstance(value, (int, float)) and not isinstance(value, bool):
            columns[prefix + name] = np.array([value], dtype=np.float64)
        elif isinstance(value, np.ndarray) and value.dtype.kind in "fiub" and 1 <= value.ndim <= 2:
            columns[prefix + name] = value.astype(np.float64)
