"""Flights in a notebook."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from gsapp.api.result import FlightSource, Result, request_values, table_of, unit_system
from gsapp.flight.flight import Flight
from gsapp.flight.flight_export import check_export, export_flight
from gsapp.flight.flight_loader import load_flight
from gsapp.flight.maneuver_settings import ManeuverSettings
from gsapp.flight.maneuvers import FlightManeuvers, uncalibrated_text
from gsapp.quantities import channel, from_si
from gsapp.session.graded_maneuvers import find_graded_maneuvers
from gsapp.virtual.downlink.flight_recording import record_virtual_flight
from gsapp.virtual.downlink.flight_settings import FlightSettings
from gsapp.virtual.instruments import parse_sensor_fault


def open(  # noqa: A001  as `gsapp.open` is called
    path: str | Path,
    *,
    aircraft: str | Path = "",
    channel_map: str | Path = "",
    calibration: str | Path = "",
    native: bool = False,
    raw: Sequence[str] = (),
) -> Flight:
    """Open a flight: a folder, Flight CSV, log or table.

    Parameters
    ----------
    path : str or Path
        A flight folder, ``.tlog``, ``.bin``, ``.log``, ``.ulg``, ``.csv``, ``.asc``, ``.mat`` or
        ``.parquet`` file.
    aircraft : str or Path, optional
        Aircraft: a file, or the name of a shipped one; by default that of the flight.
    channel_map : str or Path, optional
        Channel map: a file, or the name of a shipped one; by default that of the flight.
    calibration : str or Path, optional
        Certificates instead of those of the flight: a folder, or the name of a shipped set.
    native : bool, optional
        Keep every sample at its own time.
    raw : sequence of str, optional
        Fields of messages to keep beside the channels, as ``ATT.DesRoll`` or ``NKF1.*``.

    Returns
    -------
    Flight
        Its ``to_dataframe``, ``to_xarray`` and ``to_numpy`` return the samples.

    Raises
    ------
    gsapp.foundation.GroundStationError
        If it cannot be read; the message says why and what to do.
    """
    flight = load_flight(
        path,
        channel_map=channel_map or None,
        certificates=calibration or None,
        aircraft=aircraft or None,
        raw=raw,
        native=native,
    )
    given = {"aircraft": aircraft, "channel_map": channel_map, "calibration": calibration}
    return replace(flight, opened_with={name: str(one) for name, one in given.items() if one})


def export(
    flight: FlightSource,
    out: str | Path,
    *,
    to: str = "",
    units: str = "us",
    aircraft: str | Path = "",
) -> Path:
    """Write a flight for other programs, as ``gsapp export``.

    Parameters
    ----------
    flight : Flight, str or Path
        An open flight, or the path of one.
    out : str or Path
        File to write.
    to : {"csv", "mat", "parquet", "sidpac"}, optional
        Format; by default by the ending of the name. ``sidpac`` is a ``.mat`` file with the array
        ``fdata`` of SIDPAC; ``gsapp.open(file, channel_map="sidpac")`` reads one.
    units : {"us", "si", "base"}, optional
        Of the columns, as for ``Flight.to_numpy``; those of SIDPAC are fixed.
    aircraft : str or Path, optional
        For the mass, inertia and geometry in ``fdata``; by default that of the flight folder.

    Returns
    -------
    Path
        The file.
    """
    opened, place = flight if isinstance(flight, Flight) else open(flight), Path(out)
    wanted, system = to or place.suffix.lstrip(".").casefold(), units.casefold()
    check_export(place, wanted, system)
    export_flight(
        opened, place, wanted, system, aircraft or opened.opened_with.get("aircraft") or None
    )
    return place


def maneuvers(
    flight: FlightSource, *, units: str = "us", **settings: Any
) -> Result[FlightManeuvers]:
    """Find the maneuvers of a flight and grade them, as ``gsapp maneuvers``.

    Parameters
    ----------
    flight : Flight, str or Path
        An open flight, or the path of one.
    units : {"us", "si"}, optional
        Of the table.
    **settings
        aircraft, channel_map, calibration, as_found; see the table.

    Returns
    -------
    Result
        Table ``maneuvers``. The amplitude of a throttle step is a share, 0 to 1.
    """
    paths, values = request_values(flight, settings)
    graded = find_graded_maneuvers(paths[0], ManeuverSettings(**values))
    content = [one.to_json() for one in graded.found.maneuvers]
    speed, angle = channel("V").display_unit(unit_system(units)), "deg"
    count = len(content)
    return Result(
        summary=f"{graded.flight.name}: {count} maneuver{'' if count == 1 else 's'}.",
        outcome=graded.found,
        content=content,
        tables={
            "maneuvers": table_of(
                "id t_start t_end inputs kind amplitude grade V alpha reasons",
                (
                    (
                        one["id"], one["t_start"], one["t_end"], "+".join(one["inputs"]),
                        one["kind"],
                        one["amplitude"] if one["inputs"] == ["throttle"]
                        else _shown(one["amplitude"], angle, "angle"),
                        one["grade"], _shown(one["V"], speed, "speed"),
                        _shown(one["alpha"], angle, "angle"), "; ".join(one["reasons"]),
                    )
                    for one in content
                ),
                t_start="s", t_end="s", amplitude=angle, V=speed, alpha=angle,
            )
        },
        remarks=(
            *graded.flight.calibration_remarks,
            *graded.found.remarks,
            *uncalibrated_text(graded.flight),
        ),
    )  # fmt: skip


def _shown(value: float | None, unit: str, quantity: str) -> float | None:
    return None if value is None else from_si(value, unit, quantity)


def fly(out: str | Path, *, truth: str | Path = "", **settings: Any) -> Flight:
    """Fly the virtual aircraft into a flight folder, as ``gsapp fly --out``.

    Parameters
    ----------
    out : str or Path
        The folder to write; it must be new or empty.
    truth : str or Path, optional
        Flight CSV for the true motion.
    **settings
        plan, seed, hide, turbulence and so on; see the table.

    Returns
    -------
    Flight
        As recorded.
    """
    folder = Path(out)
    chosen = FlightSettings(**request_values((), settings)[1])
    for text in chosen.faults:
        parse_sensor_fault(text)
    record_virtual_flight(chosen, folder, truth=Path(truth) if truth else None)
    return load_flight(folder)
