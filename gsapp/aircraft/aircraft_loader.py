"""Finding and reading aircraft files."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import tomlkit

from gsapp.aircraft.config import Aircraft
from gsapp.foundation import FlightError, read_toml
from gsapp.foundation.files import ShippedFiles, write_atomically
from gsapp.quantities.constants import DEGREE

SHIPPED_AIRCRAFT = ShippedFiles(folder=Path(__file__).parent / "files", kind="aircraft")


def shipped_aircraft() -> tuple[str, ...]:
    """Return the names of the aircraft that come with the program."""
    return SHIPPED_AIRCRAFT.names()


def load_aircraft(name_or_path: str | Path) -> Aircraft:
    """Read an aircraft file: a path, or the name of a shipped aircraft such as ``b777``.

    Raise FileProblemsError if the file holds mistakes; all are named. Raise UnknownNameError if
    there is neither such a file nor such a shipped aircraft.
    """
    return read_toml(SHIPPED_AIRCRAFT.find(name_or_path), Aircraft)


def file_warnings(aircraft: Aircraft) -> tuple[str, ...]:
    """Return the warnings about an aircraft file; none about a shipped one.

    The values of a shipped aircraft are those of its source, which no user can measure again.
    """
    shipped = any(aircraft == load_aircraft(name) for name in shipped_aircraft())
    return () if shipped else aircraft.warnings()


def write_sensor_values(path: Path, values: Mapping[str, Mapping[str, float]]) -> None:
    """Write what is known of instruments into an aircraft file; all else is kept.

    Parameters
    ----------
    path : Path
        Of the user's own aircraft.
    values : mapping of str to mapping of str to float
        By the name of the instrument, such as ``alpha_vane``: ``x`` and ``y`` (position from the
        CG, m, body axes), ``bias`` (rad), ``upwash``.

    Raises
    ------
    FlightError
        If the file came with the program.
    FileProblemsError
        If the file holds mistakes.
    """
    if path.resolve().is_relative_to(SHIPPED_AIRCRAFT.folder.resolve()):
        raise FlightError(
            f"the aircraft file {path.name} ships with the program and is not changed: copy it to "
            "your own folder, and name the copy with --aircraft FILE"
        )
    aircraft = read_toml(path, Aircraft)
    document = tomlkit.parse(path.read_text(encoding="utf-8"))
    sensors = document.setdefault("sensors", tomlkit.table(is_super_table=True))
    for name, entries in values.items():
        sensor = sensors.setdefault(name, tomlkit.table())
        place = [f"{one:g} m" for one in getattr(aircraft.sensors, name).position]
        stated = [str(one) for one in sensor.get("position", place)]
        moved = {axis: f"{entries[axis]:.4g} m" for axis in "xy" if axis in entries}
        if moved:
            sensor["position"] = [
                moved.get(axis, text) for axis, text in zip("xyz", stated, strict=True)
            ]
        if (bias := entries.get("bias")) is not None:
            sensor["bias"] = f"{bias / DEGREE:.3g} deg"
        if (upwash := entries.get("upwash")) is not None:
            sensor["upwash"] = float(f"{upwash:.4g}")
    write_atomically(path, tomlkit.dumps(document))


def with_accuracy(text: str, accuracy: Mapping[str, str]) -> str:
    """Return the text of an aircraft file with another section ``[accuracy]``.

    `accuracy`: standard deviations with their units, by field of `Accuracy`; empty for no section.
    """
    document = tomlkit.parse(text)
    document.pop("accuracy", None)
    if accuracy:
        document["accuracy"] = dict(accuracy)
    return tomlkit.dumps(document)
