"""What is wrong with the words of a call, whatever the files hold."""

from __future__ import annotations

import contextlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

from gsapp.foundation import FlightError, GroundStationError

_WRITTEN = {
    "out": "--out",
    "json": "--json",
    "csv": "--csv",
    "truth": "--truth",
    "onboard": "--onboard",
    "report": "--report",
    "dataset": "--dataset",
    "figure": "--figure",
}
"""The parameters of all commands that name what is written, with their options."""
_SCREEN = "-"


class CommandUsageError(GroundStationError, ValueError):
    """A command cannot be called with these words."""


@contextmanager
def as_usage_error() -> Iterator[None]:
    """Let an error in reading what was typed be a wrong call."""
    try:
        yield
    except GroundStationError as error:
        raise CommandUsageError(str(error)) from error


def check_speed(speed: float | None) -> None:
    """Raise `CommandUsageError` where nothing can go at a speed, times real time."""
    if speed is not None and not speed > 0.0:
        raise CommandUsageError(f"a speed of {speed:g} is not possible; use a speed above 0")


def check_windows(texts: Sequence[str], flights: Sequence[Path]) -> None:
    """Raise `CommandUsageError` where ``--maneuver`` says no stretch of one of the flights."""
    from gsapp.flight.maneuvers.flight_maneuvers import parse_maneuver_windows

    with as_usage_error():
        parse_maneuver_windows(texts, len(flights))


def check_catalog(catalog: Path | None, calibration: str | None) -> None:
    """Raise `CommandUsageError` where results with other certificates would go into a catalog.

    A catalog keeps one set of maneuvers and estimates of a flight: those of its own certificates.
    """
    if catalog is not None and calibration is not None:
        raise CommandUsageError(
            f"{catalog} stores results with the certificates of the flights; omit --catalog or "
            "--calibration"
        )


def check_is_catalog(catalog: Path, remedy: str) -> None:
    """Raise `FlightError` where no catalog stands; what to do about it ends the sentence."""
    if catalog.is_dir():
        raise FlightError(f"{catalog} is a folder; name the file of a catalog")
    if not catalog.is_file():
        raise FlightError(f"there is no catalog {catalog}; {remedy}")


def check_output_paths(given: Mapping[str, object]) -> None:
    """Refuse a call that would overwrite its own input, or a file of a flight.

    Parameters
    ----------
    given : mapping of str to object
        The parameters of a command. Whatever is not written may be a path that is read.

    Raises
    ------
    GroundStationError
        If it would.
    CommandUsageError
        If something other than the result for programs is to go to the screen.
    """
    targets: dict[str, Path] = {}
    for name, option in _WRITTEN.items():
        target = given.get(name)
        if target is None or (name == "json" and str(target) == _SCREEN):
            continue
        if str(target) == _SCREEN:
            raise CommandUsageError(
                f"{option} {_SCREEN} names no file; only --json can go to the screen"
            )
        targets[option] = Path(str(target))
    read = [path for name, value in given.items() if name not in _WRITTEN for path in _paths(value)]
    sources = [path for path in read if _is_file(path)]
    # A recording goes on in the folder of its flight, with the copies that lie there.
    if "--out" in targets and "link" not in given:
        flights = [*_paths(given.get("flights")), *_paths(given.get("flight"))]
        _check_folder(targets["--out"], sources, flights)
    for option, target in targets.items():
        if not _is_utf8(str(target)):
            raise GroundStationError(
                f"{option} {str(target)!a} is not UTF-8, so that other programs could not "
                "read it; choose another name"
            )
        if any(is_same_path(target, source) for source in sources):
            raise GroundStationError(
                f"{option} {target} is an input of the command; choose another name"
            )
        if _belongs_to_flight(target):
            raise GroundStationError(
                f"{option} {target} is the name of a file that the flight {target.parent} is made "
                "of; choose another name"
            )
    for option, target in targets.items():
        for other, second in targets.items():
            if option < other and target.absolute() == second.absolute():
                raise GroundStationError(
                    f"{option} and {other} both name {target}; choose two names"
                )


def _check_folder(folder: Path, sources: Iterable[Path], flights: Iterable[Path]) -> None:
    """Raise `GroundStationError` where results would be written among what the command reads."""
    if not folder.is_dir():
        return
    for path in sources:
        if folder.resolve() in path.resolve().parents:
            raise GroundStationError(
                f"--out {folder} holds {path}, which the command reads and could overwrite; choose "
                "another folder"
            )
    for path in flights:
        if is_same_path(folder, path):
            raise GroundStationError(
                f"--out {folder} is an input of the command; choose another folder"
            )


def check_distinct_flights(flights: Iterable[Path | str]) -> None:
    """Raise `CommandUsageError` where a flight is given twice, and would count twice."""
    seen: list[Path] = []
    for path in map(Path, flights):
        if any(is_same_path(path, other) for other in seen):
            raise CommandUsageError(f"{path} is given twice; a flight counts once")
        seen.append(path)


def _is_utf8(text: str) -> bool:
    try:
        text.encode()
    except UnicodeEncodeError:
        return False
    return True


def _paths(value: object) -> Iterator[Path]:
    if isinstance(value, (str, Path)):
        yield Path(value)
    elif isinstance(value, (list, tuple)):
        for one in value:
            yield from _paths(one)


def _is_file(path: Path) -> bool:
    # What is no path at all, as the words of an option, may be too long for one.
    with contextlib.suppress(OSError, ValueError):
        return path.is_file()
    return False


def is_same_path(target: Path, source: Path) -> bool:
    """Return whether two paths, either of which may be missing, lead to the same thing."""
    with contextlib.suppress(OSError, ValueError):
        return target.samefile(source)
    return False


def _belongs_to_flight(target: Path) -> bool:
    from gsapp.flight.file_names import FLIGHT_FOLDER_FILES

    path = target.resolve()  # what a link leads to is written
    if path.name.casefold() in FLIGHT_FOLDER_FILES:
        from gsapp.flight.folder import is_flight_folder

        return is_flight_folder(path.parent)
    return False
