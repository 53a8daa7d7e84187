"""The map below the ground track: tiles of a file, read and decoded beside the window."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from PySide6.QtCore import QBuffer, QByteArray, QObject, Signal
from PySide6.QtGui import QImage, QImageReader

from gsapp.flight.map_tiles import MapTile, MapTiles
from gsapp.flight.plot_data import GroundOrigin
from gsapp.foundation import GroundStationError
from ui.background_job import BackgroundJob, JobProgress
from ui.translation import tr
from ui.widgets.analysis_plot import PlotPicture

_MAX_PIXELS = 1024  # Of the side of a tile.
_MARGIN = 0.25  # Of the view, beyond each of its sides: the aircraft moves.


class MapBackground(QObject):
    """The tiles over what a plot of north over east shows."""

    loaded = Signal()  # Other tiles can be shown.

    def __init__(self, path: Path, parent: QObject) -> None:
        super().__init__(parent)
        self._path = path
        self._tiles: MapTiles | None = None  # Opened by the first job.
        self.note = ""  # Whom the map is by, or why there is none.
        self._wanted: tuple[object, ...] = ()
        self._loaded: Sequence[tuple[MapTile, QImage]] = ()
        self._job: BackgroundJob | None = None

    def request(
        self, origin: GroundOrigin, edges: tuple[float, float, float, float], pixel: float
    ) -> None:
        """Read the tiles of a view: its edges from the origin and the width of a pixel, m.

        `edges`: west, south, east and north.
        """
        wanted = (origin, edges)
        if wanted == self._wanted or (self._job is not None and self._job.is_running):
            return
        self._wanted = wanted
        west, south, east, north = edges
        across, along = _MARGIN * (east - west), _MARGIN * (north - south)
        area = origin.area(west - across, south - along, east + across, north + along)
        known = {(one.zoom, one.column, one.row): image for one, image in self._loaded}

        def work(_progress: JobProgress) -> tuple[MapTiles, list[tuple[MapTile, QImage]]]:
            tiles = self._tiles or MapTiles(self._path)
            decoded = [
                (one, known.get((one.zoom, one.column, one.row)) or decode_tile(one, tiles))
                for one in tiles.tiles_over(area, pixel)
            ]
            return tiles, [(tile, image) for tile, image in decoded if not image.isNull()]

        self._job = BackgroundJob(tr("Map tiles"), work, self, may_hang=True)
        self._job.done.connect(self._take)
        self._job.failed.connect(self._fail)
        self._job.start()

    def _take(self, read: tuple[MapTiles, Sequence[tuple[MapTile, QImage]]]) -> None:
        self._tiles, self._loaded = read
        self.note = self._tiles.attribution
        self.loaded.emit()

    def _fail(self, error: Exception) -> None:
        if not isinstance(error, (GroundStationError, OSError)):
            raise error
        self._loaded, self.note = (), str(error)
        self.loaded.emit()

    def pictures(self, origin: GroundOrigin, unit: float) -> list[PlotPicture]:
        """Return the tiles read last, in a plot whose unit is so many meters."""
        found = []
        for tile, image in self._loaded:
            west, south, east, north = (one / unit for one in origin.rectangle(tile.area))
            found.append(PlotPicture(image=image, west=west, south=south, east=east, north=north))
        return found


def decode_tile(tile: MapTile, tiles: MapTiles) -> QImage:
    """Return the picture of a tile; a null one if it is damaged or larger than a tile."""
    buffer = QBuffer()
    buffer.setData(QByteArray(tile.picture))
    reader = QImageReader(buffer, QByteArray(tiles.picture_format.encode()))
    size = reader.size()
    if not size.isValid() or max(size.width(), size.height()) > _MAX_PIXELS:
        return QImage()
    return reader.read()
