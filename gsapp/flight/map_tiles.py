"""Map tiles of an MBTiles file: pictures of the ground that need no internet.

The format is version 1.3 of the MBTiles specification: an SQLite file with square pictures of the
spherical Mercator projection (EPSG:3857), rows counted from the south.
"""

from __future__ import annotations

import math
import re
import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from gsapp.foundation.errors import FileProblem, FileProblemsError
from gsapp.quantities.constants import EARTH_RADIUS

_TILE_PIXELS = 256
_MAX_TILES = 64  # For one view.
_MAX_BYTES = 1_000_000  # Of a picture; those of 512 pixels take up to 300,000.
_MAX_ZOOM = 24
_STEPS = 1000  # Steps of SQLite between two looks at what a query has cost.
_MAX_LOOKS = 5000  # A file may hold a view that never ends in place of its table.
PICTURE_FORMATS: Final = ("png", "jpg", "jpeg", "webp")


@dataclass(frozen=True, slots=True, kw_only=True)
class GroundArea:
    """A rectangle of the ground: latitude and longitude, rad."""

    south: float
    west: float
    north: float
    east: float


@dataclass(frozen=True, slots=True, kw_only=True)
class MapTile:
    """A picture of the ground, its north up."""

    zoom: int
    column: int  # From the date line eastward.
    row: int  # From the south northward.
    picture: bytes

    @property
    def area(self) -> GroundArea:
        """The ground that the picture shows."""
        south, north = (_latitude(self.zoom, row) for row in (self.row, self.row + 1))
        west, east = (_longitude(self.zoom, column) for column in (self.column, self.column + 1))
        return GroundArea(south=south, west=west, north=north, east=east)


class MapTiles:
    """An MBTiles file with pictures.

    Raises
    ------
    FileProblemsError
        If the file is none, cannot be read, or holds no pictures.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        if not path.is_file():
            raise self._problem("file", "is missing, or is no file", "choose another map")
        with self._query() as connection:
            content = dict(connection.execute("SELECT name, value FROM metadata LIMIT 1000"))
            # One by one: the index that tiles have finds the first of a level without the others.
            self._zooms = [
                zoom
                for zoom in range(_MAX_ZOOM + 1)
                if connection.execute(
                    "SELECT 1 FROM tiles WHERE zoom_level = ? LIMIT 1", (zoom,)
                ).fetchone()
            ]
        self.picture_format = str(content.get("format", "png")).lower()
        self.attribution = re.sub(r"<[^>]*>", "", str(content.get("attribution", "")))[:200]
        """Whom the map is by: to be shown with it."""
        if self.picture_format not in PICTURE_FORMATS:
            raise self._problem(
                "metadata.format",
                f"'{self.picture_format}' is no picture",
                "export raster tiles (PNG or JPEG)",
            )
        if not self._zooms:
            raise self._problem("tiles", "there are none", "export the map again")

    def tiles_over(self, area: GroundArea, pixel: float) -> tuple[MapTile, ...]:
        """Return the tiles over an area, detailed enough for the pixels of a view.

        Parameters
        ----------
        area : GroundArea
            What the view shows.
        pixel : float
            Distance on the ground that a pixel of the view covers, m.

        Returns
        -------
        tuple of MapTile
            At most 64, of one zoom level.
        """
        middle = math.cos(0.5 * (area.south + area.north))
        across = 2.0 * math.pi * EARTH_RADIUS * middle / _TILE_PIXELS  # m of a pixel at zoom 0
        wanted = math.ceil(math.log2(max(across / pixel, 1.0)))
        usable = [zoom for zoom in self._zooms if zoom <= wanted] or self._zooms[:1]
        for zoom in reversed(usable):
            columns = sorted(_place(zoom, one) for one in (area.west, area.east))
            rows = sorted(_row(zoom, one) for one in (area.south, area.north))
            if (columns[1] - columns[0] + 1) * (rows[1] - rows[0] + 1) <= _MAX_TILES:
                return self._read(zoom, columns, rows)
        return ()

    def _read(self, zoom: int, columns: list[int], rows: list[int]) -> tuple[MapTile, ...]:
        with self._query() as connection:
            found = connection.execute(
                "SELECT tile_column, tile_row, tile_data FROM tiles WHERE zoom_level = ?"
                " AND tile_column BETWEEN ? AND ? AND tile_row BETWEEN ? AND ?"
                " AND typeof(tile_data) = 'blob' AND length(tile_data) <= ? LIMIT ?",
                (zoom, *columns, *rows, _MAX_BYTES, _MAX_TILES),
            ).fetchall()
        return tuple(
            MapTile(zoom=zoom, column=int(column), row=int(row), picture=picture)
            for column, row, picture in found
        )

    @contextmanager
    def _query(self) -> Iterator[sqlite3.Connection]:
        """Open the file for a moment: another thread may ask the next time."""
        looks = iter(range(_MAX_LOOKS))
        try:
            address = f"{self._path.absolute().as_uri()}?mode=ro"
            with closing(sqlite3.connect(address, uri=True)) as connection:
                connection.set_progress_handler(lambda: next(looks, None) is None, _STEPS)
                connection.execute("PRAGMA trusted_schema = OFF")
                yield connection
        except (sqlite3.Error, OverflowError, TypeError, ValueError) as error:
            raise self._problem(
                "file", f"cannot be read as MBTiles ({error})", "export the map as raster MBTiles"
            ) from error

    def _problem(self, where: str, what: str, remedy: str) -> FileProblemsError:
        return FileProblemsError(self._path, [FileProblem(where=where, what=what, remedy=remedy)])


def _longitude(zoom: int, column: float) -> float:
    return 2.0 * math.pi * column / 2.0**zoom - math.pi


def _latitude(zoom: int, row: float) -> float:
    """Return the inverse of the spherical Mercator projection; row 0 is its southern edge."""
    return math.atan(math.sinh(2.0 * math.pi * row / 2.0**zoom - math.pi))


def _row(zoom: int, latitude: float) -> int:
    return _place(zoom, math.asinh(math.tan(latitude)))


def _place(zoom: int, projected: float) -> int:
    """Return the number of the tile at a projected coordinate of -pi to pi."""
    count = 1 << zoom
    return min(max(math.floor((projected + math.pi) / (2.0 * math.pi) * count), 0), count - 1)
