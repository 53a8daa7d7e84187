"""Map tiles: their places on the ground, the zoom level of a view, files that are damaged."""

import os
import sqlite3
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from gsapp.flight.map_tiles import GroundArea, MapTiles
from gsapp.flight.plot_data import GroundOrigin
from gsapp.foundation.errors import FileProblemsError

PICTURE = b"\x89PNG and so on"
# 52.52° N, 13.405° E lies in tile 14/8802/5373, as tile servers count: rows from the north.
ZOOM, COLUMN, ROW = 14, 8802, 2**14 - 1 - 5373
PLACE = (np.radians(52.52), np.radians(13.405))


def write_tiles(path: Path, tiles: list[tuple[int, int, int, object]], **metadata: str) -> Path:
    with closing(sqlite3.connect(path)) as connection:
        connection.execute("CREATE TABLE metadata (name text, value text)")
        connection.execute(
            "CREATE TABLE tiles (zoom_level integer, tile_column integer, tile_row integer,"
            " tile_data blob)"
        )
        connection.executemany("INSERT INTO metadata VALUES (?, ?)", metadata.items())
        connection.executemany("INSERT INTO tiles VALUES (?, ?, ?, ?)", tiles)
        connection.commit()
    return path


def square(side: float) -> GroundArea:
    """Return an area about the place: its side, m."""
    half = side / 2.0
    return GroundOrigin(latitude=PLACE[0], longitude=PLACE[1]).area(-half, -half, half, half)


def test_a_tile_lies_where_servers_of_tiles_have_it(tmp_path: Path) -> None:
    path = write_tiles(
        tmp_path / "map.mbtiles",
        [(ZOOM, COLUMN, ROW, PICTURE), (ZOOM, COLUMN + 2, ROW, PICTURE)],
        format="png",
        attribution='<a href="https://x">© Mappers</a>',
    )
    tiles = MapTiles(path)
    assert tiles.attribution == "© Mappers"
    (found,) = tiles.tiles_over(square(10.0), pixel=5.0)
    assert (found.zoom, found.column, found.row, found.picture) == (ZOOM, COLUMN, ROW, PICTURE)
    area = found.area
    assert area.south < PLACE[0] < area.north
    assert area.west < PLACE[1] < area.east
    # The projection is conformal: a tile is as high as it is wide.
    west, south, east, north = GroundOrigin(latitude=PLACE[0], longitude=PLACE[1]).rectangle(area)
    assert east - west == pytest.approx(40_030_174.0 / 2**ZOOM * np.cos(PLACE[0]), rel=1e-3)
    assert north - south == pytest.approx(east - west, rel=1e-3)


@pytest.mark.parametrize(
    ("side", "pixel", "zoom"),
    [
        (400.0, 0.75, 17),  # 0.73 m a pixel at zoom 17 here
        (400.0, 1.5, 16),
        (400.0, 0.01, 18),  # no finer level is there
        (2000.0, 0.75, 16),  # at 17 there would be more tiles than a view takes
        (400.0, 1e5, 10),  # no coarser level is there
    ],
)
def test_the_level_of_a_view(tmp_path: Path, side: float, pixel: float, zoom: int) -> None:
    every = [
        (level, COLUMN * 2**level // 2**ZOOM + right, ROW * 2**level // 2**ZOOM + up, PICTURE)
        for level in (10, 16, 17, 18)
        for right in range(-20, 21)
        for up in range(-20, 21)
    ]
    tiles = MapTiles(write_tiles(tmp_path / "map.mbtiles", every))
    found = tiles.tiles_over(square(side), pixel)
    assert {one.zoom for one in found} == {zoom}
    assert len(found) <= 64


def test_a_tile_that_is_no_picture_is_left_out(tmp_path: Path) -> None:
    path = write_tiles(
        tmp_path / "map.mbtiles",
        [
            (ZOOM, COLUMN, ROW, "text"),
            (ZOOM, COLUMN, ROW, None),
            (ZOOM, COLUMN, ROW, bytes(1_000_001)),
        ],
    )
    assert MapTiles(path).tiles_over(square(10.0), pixel=5.0) == ()


@pytest.mark.parametrize(
    ("tiles", "metadata", "where"),
    [
        ([], {}, "tiles"),
        ([(ZOOM, COLUMN, ROW, PICTURE)], {"format": "pbf"}, "metadata.format"),
        ([(99, COLUMN, ROW, PICTURE)], {}, "tiles"),
    ],
)
def test_a_file_without_pictures_is_refused(
    tmp_path: Path, tiles: list[tuple[int, int, int, object]], metadata: dict[str, str], where: str
) -> None:
    path = write_tiles(tmp_path / "map.mbtiles", tiles, **metadata)
    with pytest.raises(FileProblemsError) as caught:
        MapTiles(path)
    assert caught.value.path == path
    assert [one.where for one in caught.value.problems] == [where]


def test_a_view_that_never_ends_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "map.mbtiles"
    with closing(sqlite3.connect(path)) as connection:
        connection.execute("CREATE TABLE metadata (name text, value text)")
        connection.execute(
            "CREATE VIEW tiles AS WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n)"
            " SELECT i AS zoom_level, i AS tile_column, i AS tile_row, x'00' AS tile_data FROM n"
        )
    with pytest.raises(FileProblemsError):
        MapTiles(path)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="elsewhere there are no pipes in folders")
def test_a_pipe_is_no_map(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "map.mbtiles")
    with pytest.raises(FileProblemsError):
        MapTiles(tmp_path / "map.mbtiles")


def test_no_file_at_all(tmp_path: Path) -> None:
    with pytest.raises(FileProblemsError):
        MapTiles(tmp_path / "none.mbtiles")
    assert not (tmp_path / "none.mbtiles").exists()


@given(place=st.integers(0, 12_287), value=st.integers(0, 255))
@settings(
    max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
def test_a_damaged_file_is_refused_or_gives_pictures(
    tmp_path: Path, place: int, value: int
) -> None:
    whole = tmp_path / "whole.mbtiles"
    if not whole.exists():
        write_tiles(whole, [(ZOOM, COLUMN, ROW, PICTURE)], format="png")
    content = bytearray(whole.read_bytes())
    content[place % len(content)] = value
    damaged = tmp_path / "damaged.mbtiles"
    damaged.write_bytes(content)
    try:
        found = MapTiles(damaged).tiles_over(square(10.0), pixel=5.0)
    except FileProblemsError:
        return
    assert all(isinstance(one.picture, bytes) for one in found)
