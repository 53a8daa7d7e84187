"""What a run was asked for as JSON, exactly: the same request comes back."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Final

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
    content = request.model_dump(mode="json", exclude={"maneuvers": {"__all__": {"found"}}})
    return _map_paths(content, lambda path: _to_relative(path, folder.absolute()))


def request_from_json(content: Mapping[str, Any], folder: Path) -> RunRequest:
    """Return the request that `request_json` made.

    Raises
    ------
    FlightError
        If this program cannot read all of it.
    """
    try:
        content = _map_paths(_flat(content), lambda path: _to_absolute(path, folder.absolute()))
        # A run stored before vanes were looked for repeats without.
        return RunRequest(**{"vane_positions": "file", **content})
    except (FlightError, KeyError, TypeError, AttributeError) as error:
        raise FlightError(
            f"the settings of a stored run cannot be read ({error}); repeat it with the program "
            "version that made it"
        ) from error


def _flat(content: Mapping[str, Any]) -> dict[str, Any]:
    """Return a request of the former format, in which settings were nested, in today's."""
    if "settings" not in content:
        return dict(content)
    rest = {key: value for key, value in content.items() if key not in ("settings", "given")}
    settings = dict(content["settings"])
    fit = dict(settings.pop("likelihood"))
    weights = settings.pop("weights")
    own_weights = fit.pop("weights")
    for key in ("axis", "free", "held", "joint_weights"):
        del fit[key]  # the settings around it decided
    return {
        **fit,
        **settings,
        **rest,
        "maneuver_windows": content["given"],
        "known_model": fit["model"],
        "response_weights": weights or (None if own_weights is None else {"": own_weights}),
    }


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
