"""A virtual flight as a flight folder, as if it had been recorded."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

from gsapp.aircraft.aircraft_loader import with_accuracy
from gsapp.flight.atomic_files import atomic_flight_folder
from gsapp.flight.folder_setup import prepare_flight_folder
from gsapp.flight.writers import write_flight_csv
from gsapp.foundation import FlightError, write_atomically
from gsapp.foundation.files import format_json, list_files
from gsapp.virtual.downlink.downlink_transmitter import TransmitProgress
from gsapp.virtual.downlink.flight_downlink import FlightDownlink, write_record
from gsapp.virtual.downlink.flight_settings import FlightSettings


def record_virtual_flight(
    settings: FlightSettings,
    out: Path,
    *,
    truth: Path | None = None,
    progress: Callable[[TransmitProgress], None] = lambda _: None,
) -> FlightDownlink:
    """Write a flight folder as if the flight had been recorded, as fast as it goes.

    Nothing stands at `out` before all of it does.

    Parameters
    ----------
    truth : Path, optional
        Flight CSV for the true motion.
    progress : callable, optional
        Told how far the flight is.

    Returns
    -------
    FlightDownlink
        Finished; it knows the true motion, and whether the aircraft crashed.

    Raises
    ------
    FlightError
        If something is there already, or cannot be written.
    """
    if out.exists() and (not out.is_dir() or list_files(out)):
        raise FlightError(f"{out} exists already; choose another name for the new flight")
    downlink = settings.create_downlink(time.time_ns() // 1000)
    with atomic_flight_folder(out) as part:
        _fill(settings, downlink, part, out.name, progress)
        if truth is not None:
            write_flight_csv(truth, downlink.truth(), "us")
    return downlink


def _fill(
    settings: FlightSettings,
    downlink: FlightDownlink,
    folder: Path,
    name: str,
    progress: Callable[[TransmitProgress], None],
) -> None:
    """Write the record and the copies."""
    flight = prepare_flight_folder(
        folder,
        name=name,
        aircraft=settings.aircraft,
        channel_map="b777-thin" if settings.thin else "b777",
        calibration=settings.certificates,
        source="virtual",
        notes=f"Virtual flight: plan {settings.plan}, seed {settings.seed}.",
    )
    kept = folder / "onboard.tlog" if settings.thin else None
    write_record(downlink, flight.tlog_file, kept, seed=settings.seed, progress=progress)
    if settings.dirt:
        dirt = settings.draw_dirt()
        write_atomically(folder / "dirt.json", format_json(dirt.as_dict()))
        # A crew knows what it does not know.
        own = flight.aircraft_file
        own.write_text(with_accuracy(own.read_text(encoding="utf-8"), dirt.accuracy), "utf-8")
    if kept is not None:
        flight.update_info(onboard_log=kept.name)
