"""What an estimation is asked for: exactly, as JSON, and in words."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from pydantic import ConfigDict, Field

from gsapp.dynamics.buildup import derivative_names
from gsapp.dynamics.model import Model
from gsapp.flight.maneuvers.detected_maneuver import DetectedManeuver
from gsapp.foundation import FlightError, UnknownNameError
from gsapp.foundation.name_suggestions import did_you_mean
from gsapp.foundation.settings import setting_info
from gsapp.identification.campaign import CampaignSettings
from gsapp.identification.estimate_settings import EstimateSettings
from gsapp.identification.methods import estimation_method
from gsapp.quantities import channel


@dataclass(frozen=True, slots=True, kw_only=True)
class SelectedManeuver:
    """A maneuver to estimate from, with its edges as they are now."""

    __pydantic_config__ = ConfigDict(extra="forbid")

    flight: Path  # One of the request's flights.
    id: str  # Within its flight.
    t_start: float
    t_end: float
    """First and last sample, s of flight time."""
    inputs: tuple[str, ...]  # Surfaces moved, of ``de``, ``da``, ``dr``.
    kind: str = ""  # ``doublet`` ...
    found: DetectedManeuver | None = field(default=None, compare=False, repr=False)
    """All that is known of it, where it is at hand: for the catalog, which wants its grade. It
    changes no number, and is not kept with a run."""


class RunRequest(CampaignSettings):
    """One estimation: the settings, flights and maneuvers.

    `maneuver_windows`, `every_grade` and `as_found` choose among the maneuvers that stand in the
    flights; where `maneuvers` are named, they only tell where those came from. So do `weights`
    and `model` where the content of these files is given.
    """

    flights: tuple[Path, ...] = Field(
        description="Flight folders or files, in the order in which they are numbered."
    )
    maneuvers: tuple[SelectedManeuver, ...] = Field(
        (), description="Those to be used, in order. Empty: all in the flights that are not unfit."
    )
    without: tuple[str, ...] = Field(
        (),
        description="Maneuvers excluded from the means, as the outcome calls them: M4, of several "
        "flights 2:M4. They are fitted all the same.",
    )


def check_names(request: RunRequest, model: Model | None) -> None:
    """Raise `UnknownNameError` for what is no channel, derivative or parameter of the model."""
    for name in request.stand_ins:
        channel(name)
    known = list(derivative_names())
    for name in (*request.held, *(request.free or ()), *request.priors, *request.start):
        if name in known or (model is not None and "." in name):
            continue
        hint = did_you_mean(name, known, f"known are {', '.join(known)}", most=2)
        raise UnknownNameError(f"there is no derivative '{name}'; {hint}")


_RELATIVE_PREFIX: Final = "./"
"""Begins a path that lies in the folder of the catalog: both may be moved together."""

_FILE_KEYS: Final = ("aircraft", "calibration", "channel_map", "weights", "model")
"""What may be the path of a file or the name of a shipped one."""


def request_json(request: RunRequest, folder: Path) -> dict[str, Any]:
    """Return a request as JSON can hold it; the model by its content.

    `request`: with whole paths.
    `folder`: of the file it is kept in; paths within it are kept from there.
    """
    content = request.model_dump(mode="json", exclude={"maneuvers": {"__all__": {"found"}}})
    return _map_paths(content, lambda path: _to_relative(path, folder.absolute()))


def request_from_json(content: Mapping[str, Any], folder: Path) -> RunRequest:
    """Return the request that `request_json` made.

    Raises `FlightError` if this program cannot read all of it.
    """
    try:
        content = _map_paths(_flat(content), lambda path: _to_absolute(path, folder.absolute()))
        # A run stored before instruments were compared repeats without.
        instruments = content.pop("vane_positions", "file")
        return RunRequest(**{"instruments": instruments, **content})
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


_DIGITS: Final = 6
"""Enough for people; all of them tell settings apart that look alike."""
_ORIGINS: Final = frozenset({"label", "maneuver_windows", "every_grade", "as_found"})
"""They name the run, or tell where its maneuvers came from."""


def setting_title(name: str) -> str:
    """Return the title of a setting within a sentence."""
    return EstimateSettings.title_of(name).lower()


def describe_settings(request: RunRequest, *, digits: int = _DIGITS) -> dict[str, str]:
    """Return every setting of a run in words, by its title; maneuvers and flights are none.

    `digits`: significant digits of numbers.
    """
    model, weights = request.known_model, request.response_weights
    values = {name: getattr(request, name) for name in EstimateSettings.model_fields}
    values |= {
        "method": estimation_method(request.method).title,
        "model": "" if model is None else model.name,
        "weights": "; ".join(
            f"{flight or 'others'}: {_text(found, digits) or 'from the residuals'}"
            for flight, found in (weights or {}).items()
        ),
    }
    described = {}
    for name, known in EstimateSettings.model_fields.items():
        if name in _ORIGINS:
            continue
        info = setting_info(known)
        text = dict(info.choices).get(values[name]) if info.choices else None
        text = text or _text(values[name], digits)
        described[setting_title(name)] = (
            f"{text} {info.unit}".strip() if text else info.default_text
        )
    return {**described, "left out of the means": ", ".join(request.without) or "none"}


def _text(value: Any, digits: int) -> str:
    """Return a value in words; empty for none."""
    match value:
        case bool():
            return "yes" if value else "no"
        case float():
            return f"{value:.{digits}g}"
        case Mapping():
            return ", ".join(f"{name} {_text(one, digits)}" for name, one in value.items())
        case (float() as number, float() as std):
            return f"{_text(number, digits)} ± {_text(std, digits)}"
        case tuple():
            return ", ".join(value)
    return "" if value is None else str(value)


def setting_differences(one: RunRequest, other: RunRequest) -> tuple[tuple[str, str, str], ...]:
    """Return the settings in which two runs differ: title, the one's, the other's in words."""
    exact = describe_settings(one, digits=17), describe_settings(other, digits=17)
    short = describe_settings(one), describe_settings(other)
    found = []
    for name in exact[0]:
        if exact[0][name] != exact[1][name]:
            words = short if short[0][name] != short[1][name] else exact
            found.append((name, words[0][name], words[1][name]))
    if one.known_model != other.known_model and not any(row[0] == "model" for row in found):
        found.append(("model", "its values", "other values of the same name"))
    return tuple(found)
