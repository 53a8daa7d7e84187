"""What a run was asked for as JSON, exactly: the same request comes back."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any, Final

from pydantic import TypeAdapter, ValidationError

from gsapp.foundation import FlightError
from gsapp.identification.runs.request import RunRequest

_RELATIVE_PREFIX: Final = "./"
"""Begins a path that lies in the folder of the catalog: both may be moved together."""

_FILE_KEYS: Final = ("aircraft", "calibration", "channel_map", "weights", "model")
"""What may be the path of a file or the name of a shipped one."""


def request_json(request: RunRequest, folder: Path) -> dict[str, Any]:
    """Return a request as JSON can hold it; the model by its content.

    Parameters
    ----------
    request : RunRequest
        With whole paths.
    folder : Path
        Of the file it is kept in; paths within it are kept from there.
    """
    plain = replace(request, maneuvers=tuple(replace(one, found=None) for one in request.maneuvers))
    content = _request_adapter().dump_python(plain, mode="json")
    return _map_paths(content, lambda path: _to_relative(path, folder.absolute()))


def request_from_json(content: Mapping[str, Any], folder: Path) -> RunRequest:
    """Return the request that `request_json` made.

    Raises
    ------
    FlightError
        If this program cannot read it, or would leave out a part of it.
    """
    try:
        content = _map_paths(dict(content), lambda path: _to_absolute(path, folder.absolute()))
        request = _request_adapter().validate_python(content)
    except (ValidationError, KeyError, TypeError, AttributeError) as error:
        reason = str(error).partition("\n")[0]
        if isinstance(error, ValidationError):
            first = error.errors()[0]
            words = str(first["msg"]).removeprefix("Value error, ")
            reason = f"{'.'.join(str(one) for one in first['loc'])}: {words}"
        raise FlightError(
            f"what a kept run was asked for cannot be read ({reason}); repeat it with the version "
            "of the program that made it"
        ) from error
    lost = _missing_key(content, _request_adapter().dump_python(request, mode="json"))
    if lost:
        raise FlightError(
            f"a kept run was asked for with '{lost}', which this program does not know; repeat it "
            "with the version of the program that made it"
        )
    return request


@cache
def _request_adapter() -> TypeAdapter[RunRequest]:
    return TypeAdapter(RunRequest)


def _missing_key(before: Any, after: Any, where: str = "") -> str:
    """Return the first key that is in one and not in the other; empty for none."""
    if isinstance(before, Mapping) and isinstance(after, Mapping):
        for key, value in before.items():
            inner = f"{where}.{key}" if where else str(key)
            lost = _missing_key(value, after[key], inner) if key in after else inner
            if lost:
                return lost
    if isinstance(before, list) and isinstance(after, list):
        for one, other in zip(before, after, strict=False):
            lost = _missing_key(one, other, where)
            if lost:
                return lost
    return ""


def _to_relative(path: str, folder: Path) -> str:
    found = Path(path)
    if not found.is_absolute() or not found.is_relative_to(folder):
        return path
    return _RELATIVE_PREFIX + found.relative_to(folder).as_posix()


def _to_absolute(path: str, folder: Path) -> str:
    return str(folder / path) if path.startswith(_RELATIVE_PREFIX) else path


def _map_paths(content: dict[str, Any], move: Callable[[str], str]) -> dict[str, Any]:
    """Return a request as JSON with its paths and names of files moved."""
    return {
        **content,
        "flights": [move(path) for path in content["flights"]],
        "maneuvers": [{**one, "flight": move(one["flight"])} for one in content["maneuvers"]],
        **{name: move(content[name]) for name in _FILE_KEYS},
    }
