"""Flights in a notebook."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from gsapp.flight.flight import Flight
from gsapp.flight.flight_loader import load_flight


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
    return load_flight(
        path,
        channel_map=channel_map or None,
        certificates=calibration or None,
        aircraft=aircraft or None,
        raw=raw,
        native=native,
    )
