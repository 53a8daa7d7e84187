"""Every reader of a file under mutation: what is neither read nor refused in a sentence is a find.

    bench fuzz [SECONDS] [READER,READER] [FIRST SEED]

The program makes the inputs: a virtual flight, its exports, and the examples of the reference
pages. Each is mutated by bits, numbers, lengths, pieces and, for text, by tokens; frames of MAVLink
get a checksum that fits, members of archives stay packed. An input may take 10 s and 1 GB. A find
is printed with its reader and seed, which give the same input again. `tests.bench.fuzz_coverage`
follows which lines an input reaches.
"""

import contextlib
import importlib
import io
import json
import logging
import multiprocessing
import random
import re
import shutil
import struct
import sys
import tempfile
import time
import traceback
import warnings
import zipfile
import zlib
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from multiprocessing.connection import Connection
from pathlib import Path
from struct import pack

import numpy as np

from gsapp.foundation import GroundStationError

SECONDS = 600.0
TIMEOUT = 10.0
MEMORY = 1 << 30
TOO_LONG = ("find", f"no end within {TIMEOUT:g} s")
FRAMES = 3000
ROWS = 300
REFERENCE = Path(__file__).parents[2] / "docs" / "reference" / "files.md"
BYTES = (0, 1, 2, 14, 15, 16, 127, 128, 254, 255)
WORDS = (0, 1, 8, 255, 65535, 1 << 20, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF)
TOKENS = (
    "1e9", "-1e9", "1e300", "1e999", "nan", "inf", "-inf", "-0.0", "1e-300", "0", "9" * 400,
    "9" * 5000, "", "true", '"x"', '"nan ft"', '"1e400 deg"', '"-1 s"', "[]", "{}", "[[1]]",
    "1979-05-27", "[" * 4000, "{a=" * 2000, '"' + "k" * 70000 + '"', "\ufffd", "\x00", "=1+1",
    '"0 lb"', "-1", "99999999999999999999", '"1e-320 s"', "0x7fffffffffffffff",
)  # fmt: skip
MAPS = ("map.toml", "mat-map.toml")
Mutation = Callable[[random.Random, bytes], bytes]


LETTERS = {
    bytes((letter,)): size
    for size, letters in (
        (1, b"bBM"), (2, b"ghHcC"), (4, b"iIfneEL"), (8, b"dqQ"), (16, b"N"), (64, b"Za"),
    )
    for letter in letters
}  # fmt: skip
TYPES = {
    name: size
    for size, names in (
        (1, (b"int8_t", b"uint8_t", b"bool", b"char", b"char[1]")),
        (2, (b"int16_t", b"uint16_t", b"char[2]", b"uint8_t[2]")),
        (4, (b"int32_t", b"uint32_t", b"float", b"char[4]", b"int16_t[2]")),
        (8, (b"int64_t", b"uint64_t", b"double", b"float[2]", b"char[8]")),
    )
    for name in names
}
_LETTERS = re.compile(rb"\xa3\x95\x80.{6}(.{16})", re.DOTALL)
_TYPES = re.compile(rb"(u?int\d+_t|float|double|bool|char)(?= )")

# Mutations


def flip(chance: random.Random, data: bytes) -> bytes:
    changed = bytearray(data)
    for _ in range(chance.choice((1, 1, 2, 8))):
        place = chance.randrange(len(changed))
        if chance.random() < 0.5:
            changed[place] ^= 1 << chance.randrange(8)
        else:
            changed[place] = chance.choice(BYTES)
    return bytes(changed)


def overwrite(chance: random.Random, data: bytes) -> bytes:
    """Write a length that is wrong, or a number that is none."""
    form = chance.choice(("<I", ">I", "<H", "<d", "<f", "<Q"))
    value = chance.choice((float("nan"), float("inf"), 1e300, -1e9)) if form in ("<d", "<f") else (
        chance.choice(WORDS)
    )  # fmt: skip
    with contextlib.suppress(OverflowError, struct.error):
        part = pack(form, value)
        place = chance.randrange(max(len(data) - len(part), 1))
        return data[:place] + part + data[place + len(part) :]
    return flip(chance, data)


def rearrange(chance: random.Random, data: bytes) -> bytes:
    """Drop, repeat or move a piece."""
    start = chance.randrange(len(data))
    size = 1 + int(len(data) ** chance.random())
    piece, to = data[start : start + size], chance.randrange(len(data))
    kind = chance.randrange(4)
    if kind == 0:
        return data[:start] + data[start + size :] or b"x"
    if kind == 1:
        return data[:start] or b"x"
    if kind == 2:
        return data[:to] + piece * chance.choice((1, 2, 50)) + data[to:]
    return data[:to] + piece + data[to + size :]


def near_end(chance: random.Random, data: bytes) -> bytes:
    """Change what stands in the last kilobytes, as the directory of a Parquet file."""
    tail = min(len(data) - 1, 6000)
    return data[:-tail] + chance.choice((flip, overwrite))(chance, data[-tail:])


def near_start(chance: random.Random, data: bytes) -> bytes:
    head = min(len(data), 1500)
    return chance.choice((flip, overwrite))(chance, data[:head]) + data[head:]


def tokens(chance: random.Random, data: bytes) -> bytes:
    """Replace numbers, texts or names; repeat, drop or swap lines."""
    text = data.decode("utf-8", "surrogateescape")
    for _ in range(chance.choice((1, 1, 2, 3))):
        found = list(re.finditer(r'"[^"\n]*"|-?\d[\d.e+-]*|\w+', text))
        if not found or chance.random() < 0.2:
            lines = text.split("\n")
            place = chance.randrange(len(lines))
            lines[place : place + 1] = chance.choice(([], [lines[place]] * 2, lines[:2]))
            text = "\n".join(lines)
            continue
        one = chance.choice(found)
        token = chance.choice(TOKENS)
        if token.isascii() and chance.random() < 0.3:
            token = chance.choice(found).group()
        text = text[: one.start()] + token + text[one.end() :]
    return text.encode("utf-8", "surrogateescape") or b"x"


def frames(chance: random.Random, data: bytes) -> bytes:
    """Change payloads of MAVLink frames, and give them the checksum that fits."""
    from fastcrc.crc16 import mcrf4xx

    from gsapp.decoding.dialect import dialect

    changed, known = bytearray(data), dialect().mavlink_map
    place, stops = 0, []
    while place + 20 < len(changed) and changed[place + 8] == 0xFD:
        end = place + 8 + 12 + changed[place + 9]
        if end <= len(changed):  # A mutation before this one may have cut the last.
            stops.append(place)
        place = end
    for place in chance.sample(stops, min(len(stops), chance.choice((1, 5, 200)))):
        start, length = place + 8, changed[place + 9]
        message = int.from_bytes(changed[start + 7 : start + 10], "little")
        if message not in known or not length:
            continue
        for _ in range(chance.choice((1, 4))):
            changed[start + 10 + chance.randrange(length)] = chance.choice(BYTES)
        body = bytes(changed[start + 1 : start + 10 + length])
        crc = mcrf4xx(body + bytes([known[message].crc_extra]))
        changed[start + 10 + length : start + 12 + length] = pack("<H", crc)
        if chance.random() < 0.2:
            changed[place : place + 8] = pack(">Q", chance.choice((0, 1 << 63, 1 << 40)))
    return bytes(changed)


def members(chance: random.Random, data: bytes) -> bytes:
    """Change a member of an archive before it is packed."""
    target = io.BytesIO()
    try:
        old = zipfile.ZipFile(io.BytesIO(data))
        contents = {name: old.read(name) for name in old.namelist()}
    except Exception:  # damaged before
        return flip(chance, data)
    with zipfile.ZipFile(target, "w", 8) as new:
        chosen = chance.choice(list(contents))
        for name, content in contents.items():
            new.writestr(name, mutated(chance, content, BINARY) if name == chosen else content)
    return target.getvalue()


def retype(chance: random.Random, data: bytes) -> bytes:
    """Give a field in the formats of a log another type of the same size."""
    kind, sizes = chance.choice(((_LETTERS, LETTERS), (_TYPES, TYPES)))
    found = list(kind.finditer(data))
    if not found:
        return flip(chance, data)
    one = chance.choice(found)
    start = one.start(1)
    if sizes is LETTERS:
        start += chance.randrange(max(len(one[1].rstrip(b"\0")), 1))
        old = data[start : start + 1]
    else:
        old = one[1]
    alike = [name for name, size in sizes.items() if size == sizes.get(old)] or [b"?"]
    return data[:start] + chance.choice(alike) + data[start + len(old) :]


def repack(chance: random.Random, data: bytes) -> bytes:
    """Change the variables of a MAT file of version 5 before they are packed."""
    place, parts = 128, [data[:128]]
    while place + 8 <= len(data):
        kind, size = struct.unpack_from("<II", data, place)
        content = data[place + 8 : place + 8 + size]
        with contextlib.suppress(zlib.error):
            if kind == 15 and chance.random() < 0.3:
                content = zlib.compress(mutated(chance, zlib.decompress(content), BINARY))
        parts.append(struct.pack("<II", kind, len(content)) + content)
        place += 8 + size
    return b"".join(parts)


BINARY: tuple[Mutation, ...] = (flip, overwrite, rearrange, near_end, near_start)
TEXT: tuple[Mutation, ...] = (tokens, tokens, tokens, flip, rearrange)


def mutated(chance: random.Random, data: bytes, kinds: tuple[Mutation, ...]) -> bytes:
    for _ in range(chance.choice((1, 1, 1, 2, 3))):
        data = chance.choice(kinds)(chance, data)
    return data


# Readers


def flight(path: Path, **options: object) -> None:
    from gsapp.flight import load_flight
    from gsapp.flight.summary import summarize_flight

    summarize_flight(load_flight(path, **options))  # type: ignore[arg-type]


def mapped(path: Path) -> None:
    flight(path, channel_map=path.parent / "map.toml")


def several(path: Path) -> None:
    from gsapp.flight.flight_import import import_flights

    import_flights(path, path.parent / "made", channel_map=path.parent / "mat-map.toml")


def onboard(path: Path) -> None:
    from gsapp.flight.flight_loader import read_onboard_log

    log = read_onboard_log(path)
    for table in () if log is None else log.tables.values():
        for values in table.fields.values():
            values.sum()


def card(path: Path) -> None:
    from gsapp.flight.folder import FlightFolder

    FlightFolder.open(path.parent).update_info(notes="windy")


def swings(path: Path) -> None:
    from gsapp.aircraft.swings import compute_inertia, load_swings

    compute_inertia(load_swings(path))


def linear(path: Path) -> None:
    from gsapp.identification.linear_models.linear_model_files import load_linear_model

    np.linalg.eigvals(load_linear_model(path).model().A)


def catalog(path: Path) -> None:
    from gsapp.flight.catalog import Catalog, list_flights, search_maneuvers
    from gsapp.flight.catalog.campaign_runs import list_campaign_runs
    from gsapp.flight.catalog.queries import search_runs
    from gsapp.flight.catalog.verdicts import search_verdicts

    with Catalog(path) as opened:
        list_flights(opened)
        search_maneuvers(opened)
        search_runs(opened)
        list_campaign_runs(opened)
        search_verdicts(opened)


def map_tiles(path: Path) -> None:
    from gsapp.flight.map_tiles import GroundArea, MapTiles
    from ui.flight.map_background import decode_tile

    opened = MapTiles(path)
    for tile in opened.tiles_over(GroundArea(south=0.0, west=0.0, north=0.01, east=0.01), 300.0):
        decode_tile(tile, opened)


def events(path: Path) -> None:
    from gsapp.flight.events import read_events, sort_events

    sort_events(read_events(path).events)


def journal(path: Path) -> None:
    from calibration.wizard.journal import Journal

    Journal(path).read()


def points(path: Path) -> None:
    from calibration.points_file import load_points

    load_points(path, "rudder")


def settings(path: Path) -> None:
    from ui.settings import SettingsStore

    SettingsStore(path).change(folder="x")


def cached(path: Path) -> None:
    from gsapp.flight.cache import load_cached

    load_cached(path.parent, "key")


def loader(module: str, name: str) -> Callable[[Path], None]:
    def load(path: Path) -> None:
        getattr(importlib.import_module(module), name)(path)

    return load


READERS: dict[str, tuple[str, Callable[[Path], None], tuple[Mutation, ...]]] = {
    "mat": ("f.mat", flight, (*BINARY, repack, repack, repack)),
    "mat with cells": ("cells.mat", flight, BINARY),
    "mat of flights": ("other.mat", several, BINARY),
    "mat 7.3": ("hdf5.mat", flight, BINARY),
    "parquet": ("f.parquet", flight, BINARY),
    "csv": ("f.csv", flight, TEXT),
    "csv with map": ("table.csv", mapped, TEXT),
    "tlog": ("raw.tlog", flight, (*BINARY, frames, frames, frames)),
    "bin": ("f.bin", flight, (*BINARY, retype)),
    "bin whole": ("g.bin", onboard, (*BINARY, retype)),
    "log": ("f.log", onboard, TEXT),
    "ulg": ("f.ulg", flight, (*BINARY, retype)),
    "ulg whole": ("g.ulg", onboard, (*BINARY, retype)),
    "flight card": ("flight.toml", card, TEXT),
    "aircraft": ("aircraft.toml", loader("gsapp.aircraft", "load_aircraft"), TEXT),
    "channel map": (
        "channel-map.toml", loader("gsapp.decoding.channel_map", "load_channel_map"), TEXT,
    ),
    "certificate": (
        "certificate.toml", loader("calibration.certificate_toml", "load_certificate"), TEXT,
    ),
    "calibration plan": (
        "calibration-plan.toml", loader("calibration.plan", "load_calibration_plan"), TEXT,
    ),
    "points": ("points.csv", points, TEXT),
    "limits": ("limits.toml", loader("gsapp.session.limits", "load_limits"), TEXT),
    "cards": ("cards.toml", loader("gsapp.flight.cards", "load_cards"), TEXT),
    "fence": ("fence.toml", loader("gsapp.excitation.alerts.geofence", "load_geofence"), TEXT),
    "checklist": (
        "checklist.toml", loader("gsapp.session.checklist.items", "load_checklist"), TEXT,
    ),
    "plan": ("plan.toml", loader("gsapp.virtual.flight_plan", "load_flight_plan"), TEXT),
    "model": ("model.toml", loader("gsapp.dynamics.model", "load_model"), TEXT),
    "layout": ("layout.toml", loader("ui.strips.strip_layout", "load_layout"), TEXT),
    "weights": ("weights.toml", loader("gsapp.identification.weights", "load_weights"), TEXT),
    "swings": ("swings.toml", swings, TEXT),
    "linear model": ("linear-model.toml", linear, TEXT),
    "settings": ("settings.toml", settings, TEXT),
    "events": ("events.jsonl", events, TEXT),
    "journal": ("journal.jsonl", journal, TEXT),
    "catalog": ("campaign.sqlite", catalog, (*BINARY, near_start, tokens)),
    "map tiles": ("map.mbtiles", map_tiles, (*BINARY, near_start, tokens)),
    "cache": ("engineering.npz", cached, (*BINARY, members, members)),
}  # fmt: skip


# Inputs


def make_inputs(folder: Path) -> None:
    """Write one good file for each reader, as the program writes it."""
    from PySide6.QtCore import QBuffer
    from PySide6.QtGui import QImage
    from scipy.io import savemat

    from gsapp.aircraft import load_aircraft
    from gsapp.cli.fly import fly
    from gsapp.flight import load_flight
    from gsapp.flight.cache import store_cached
    from gsapp.flight.catalog import Catalog, store_maneuvers
    from gsapp.flight.maneuvers import detect_maneuvers
    from gsapp.flight.writers import write_block
    from tests.flight.test_dataflash import as_text, flight_log
    from tests.flight.test_map_tiles import write_tiles
    from tests.flight.test_ulog import short_log
    from ui.settings import SettingsStore

    flown = folder / "flown"
    with contextlib.redirect_stdout(io.StringIO()):
        fly(out=flown, plan="short", seed=1)
    whole = load_flight(flown)
    record = (flown / "raw.tlog").read_bytes()
    place = 0
    for _ in range(FRAMES):
        place += 8 + (12 if record[place + 8] == 0xFD else 8) + record[place + 9]
    (folder / "raw.tlog").write_bytes(record[:place])
    block = whole.block
    middle = slice(len(block) // 2, len(block) // 2 + ROWS)
    block = replace(
        block, channels=block.channels[:6], times=block.times[middle],
        values=block.values[middle, :6],
    )  # fmt: skip
    for kind in ("csv", "mat", "parquet"):
        write_block(folder / f"f.{kind}", block, kind)
    cells = np.empty(3, object)
    cells[:] = ["ab", np.arange(3.0), {"x": 1.0}]
    columns = {"time": block.times[:, None], "q": block.values[:, 0:1]}
    savemat(folder / "cells.mat", {**columns, "units": {"time": "s", "q": "rad/s"}, "c": cells})
    runs = {f"run{k}": {"T": block.times, "gyro": block.values[:, :3]} for k in range(2)}
    savemat(folder / "other.mat", runs)
    (folder / "mat-map.toml").write_text(
        'name = "runs"\nformat = "table"\ntime = "T"\n'
        '[[channels]]\nid = "q"\nsource = "gyro[1]"\nunit = "rad/s"\n'
    )
    write_hdf5(folder / "hdf5.mat", block.times, block.values)
    log = flight_log(count=60)[0]
    for name in ("f.bin", "g.bin"):
        (folder / name).write_bytes(log)
    (folder / "f.log").write_text(as_text(folder / "f.bin"), encoding="utf-8", newline="")
    for name in ("f.ulg", "g.ulg"):
        (folder / name).write_bytes(short_log(instances=2, dropouts=1))
    text = REFERENCE.read_text(encoding="utf-8")
    examples = re.findall(r"^```(toml|csv|json\w*) ([\w-]+)\n(.*?)^```", text, re.M | re.S)
    for kind, name, content in examples:
        (folder / f"{name}.{kind}").write_text(content, encoding="utf-8")
    (folder / "map.toml").write_bytes((folder / "table-map.toml").read_bytes())
    for name in ("aircraft", "events"):
        ending = "toml" if name == "aircraft" else "jsonl"
        if not (folder / f"{name}.{ending}").exists() and (flown / f"{name}.{ending}").exists():
            shutil.copy(flown / f"{name}.{ending}", folder)
    lines = [
        {"kind": "mark", "text": "doublet", "time": 12.5, "stamp": "2026-05-12T08:31:00+00:00"},
        {"kind": "maneuver", "text": "", "time": 1.0, "data": {"id": "M1", "grade": 2}},
    ]
    (folder / "events.jsonl").write_text("".join(json.dumps(one) + "\n" for one in lines))
    step = {"step": "begin", "channel": "rudder", "stamp": "2026-05-12T08:31:00+00:00"}
    (folder / "journal.jsonl").write_text(f"{json.dumps({**step, 'who': 'B. Jones'})}\n" * 3)
    SettingsStore(folder / "settings.toml").change(folder="flights", scale=120)
    with Catalog(folder / "campaign.sqlite") as opened:
        store_maneuvers(opened, whole, detect_maneuvers(whole, load_aircraft("b777")))
    store_cached(folder, "key", _decoded(whole, block))
    picture, buffer = QImage(32, 32, QImage.Format.Format_RGB32), QBuffer()
    picture.fill(0)
    picture.save(buffer, "PNG")
    data = bytes(buffer.data().data())
    write_tiles(
        folder / "map.mbtiles",
        [(8, column, row, data) for column in (128, 129) for row in (128, 129)],
        format="png",
    )
    missing = [name for name, _, _ in READERS.values() if not (folder / name).is_file()]
    if missing:
        raise FileNotFoundError(f"no input was made for {', '.join(missing)}")


def _decoded(whole: object, block: object) -> object:
    from gsapp.flight.cache import DecodedFlight

    return DecodedFlight(block=block, sources={}, remarks=("x",))  # type: ignore[arg-type]


def write_hdf5(path: Path, times: np.ndarray, values: np.ndarray) -> None:
    """Write a file as MATLAB writes version 7.3."""
    import h5py

    with h5py.File(path, "w", userblock_size=512) as file:
        file.create_dataset("time", data=times[None, :], compression="gzip")
        file.create_dataset("q", data=values[None, :, 0])
        for name, text in (("time", "s"), ("q", "rad/s")):
            item = file.create_dataset(f"units/{name}", data=np.array([[*map(ord, text)]], "u2").T)
            item.attrs["MATLAB_class"] = np.bytes_("char")
    head = b"MATLAB 7.3 MAT-file".ljust(512)
    path.write_bytes(head + path.read_bytes()[512:])


# The process that reads, and the one that watches it


def serve(connection: Connection) -> None:
    """Read what is named until nobody asks any more; report how each ended."""
    warnings.simplefilter("ignore")
    logging.disable()
    # What the libraries take themselves counts as well.
    if sys.platform != "win32":
        import resource

        resource.setrlimit(resource.RLIMIT_DATA, (MEMORY, MEMORY))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    with contextlib.suppress(EOFError):
        while True:
            reader, path = connection.recv()
            try:
                READERS[reader][1](path)
                told = "read", ""
            except GroundStationError as error:
                told = "refused", str(error)
            except Exception as error:
                frame = traceback.extract_tb(error.__traceback__)[-1]
                own = [
                    one for one in traceback.extract_tb(error.__traceback__)
                    if "/tests/bench/" not in one.filename and "site-packages" not in one.filename
                ]  # fmt: skip
                last = own[-1] if own else frame
                where = f"{Path(last.filename).name}:{last.lineno}"
                told = "find", f"{type(error).__name__} at {where}: {str(error)[:120]}"
            connection.send(told)


class Watched:
    """A process that reads; begun anew when it died or hung."""

    def __init__(self) -> None:
        self._context = multiprocessing.get_context("spawn")
        self._begin()

    def _begin(self) -> None:
        self._pipe, theirs = self._context.Pipe()
        # By the name under which another process can import it.
        target = importlib.import_module("tests.bench.fuzz").serve
        self._process = self._context.Process(target=target, args=(theirs,), daemon=True)
        self._process.start()
        theirs.close()
        self._warm = False

    def read(self, reader: str, path: Path) -> tuple[str, str]:
        """Return how an input ended; one that takes too long is tried twice, on a busy machine."""
        told = self._read(reader, path)
        return self._read(reader, path) if told == TOO_LONG else told

    def _read(self, reader: str, path: Path) -> tuple[str, str]:
        self._pipe.send((reader, path))
        # The first imports what is needed.
        limit = TIMEOUT if self._warm else 6.0 * TIMEOUT
        try:
            told: tuple[str, str] = self._pipe.recv() if self._pipe.poll(limit) else ("", "")
        except (EOFError, OSError):
            self._process.join(5.0)
            told = "find", f"death with code {self._process.exitcode}"
            self._begin()
            return told
        self._warm = True
        if not told[0]:
            self._process.kill()
            self._begin()
            return TOO_LONG
        return told

    def close(self) -> None:
        self._pipe.close()
        self._process.kill()


def make_mutant(reader: str, seed: int, folder: Path, place: Path) -> Path:
    """Write the input of a seed into a folder of its own, with what it needs beside it."""
    name, _, kinds = READERS[reader]
    shutil.rmtree(place, ignore_errors=True)
    place.mkdir()
    for extra in MAPS:
        shutil.copy(folder / extra, place)
    chance = random.Random(f"{reader} {seed}")
    data = mutated(chance, (folder / name).read_bytes(), kinds)
    path = place / name
    path.write_bytes(data)
    return path


def main(*options: str) -> dict[str, int]:
    """Fuzz and print; return counts."""
    given = [one for one in options if not one.startswith("-")]
    seconds = float(given[0]) if given else (20.0 if "--quick" in options else SECONDS)
    names = given[1].split(",") if len(given) > 1 else list(READERS)
    first = int(given[2]) if len(given) > 2 else 0
    counts: Counter[str] = Counter()
    finds: dict[str, str] = {}
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        make_inputs(folder)
        watched = Watched()
        for name in names:
            path = folder / "good" / READERS[name][0]
            path.parent.mkdir(exist_ok=True)
            shutil.copy(folder / READERS[name][0], path)
            for extra in MAPS:
                shutil.copy(folder / extra, path.parent)
            kind, text = watched.read(name, path)
            if kind != "read":
                print(f"{name}: the good file was not read: {kind} {text}")
        end, seed = time.monotonic() + seconds, first
        per_reader: dict[str, Counter[str]] = {name: Counter() for name in names}
        while time.monotonic() < end:
            for name in names:
                path = make_mutant(name, seed, folder, folder / "mutant")
                kind, text = watched.read(name, path)
                per_reader[name][kind] += 1
                key = f"{name}: {re.sub(r'[0-9]+(?=$)|0x[0-9a-f]+', '', text.split(': ')[0])}"
                if kind == "find" and key not in finds:
                    finds[key] = text
                    print(f"FIND {name} seed {seed}: {text}", flush=True)
                if time.monotonic() > end:
                    break
            seed += 1
        watched.close()
    print(f"{'reader':18} {'read':>7} {'refused':>8} {'finds':>6}   seeds {first} to {seed - 1}")
    for name, found in per_reader.items():
        print(f"{name:18} {found['read']:7} {found['refused']:8} {found['find']:6}")
        counts += found
    print(f"{sum(counts.values())} inputs, {counts['find']} finds of {len(finds)} kinds")
    return dict(counts)


if __name__ == "__main__":
    main(*sys.argv[1:])
