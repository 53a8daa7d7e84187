"""Readers in Python under mutation that follows which lines were reached; needs atheris.

    pip install atheris
    python -m tests.bench.fuzz_coverage READER SECONDS

READER is one of `tests.bench.fuzz`. It stops at the first find, and keeps its input in the folder
that is printed.
"""

import contextlib
import shutil
import sys
import tempfile
import warnings
from pathlib import Path
from random import Random

import atheris  # type: ignore[import-not-found]

with atheris.instrument_imports(include=["gsapp", "calibration"]):
    import gsapp.flight.flight_loader
    import gsapp.flight.summary
    import gsapp.session.checklist.items  # noqa: F401

from gsapp.foundation import GroundStationError
from tests.bench.fuzz import MEMORY, READERS, TIMEOUT, make_inputs, mutated


def main(reader: str, seconds: str) -> None:
    """Fuzz one reader for so many seconds."""
    name, read, kinds = READERS[reader]
    folder = Path(tempfile.mkdtemp(prefix="fuzz-"))
    make_inputs(folder)
    corpus, place = folder / "corpus", folder / "mutant"
    for made in (corpus, place):
        made.mkdir()
    shutil.copy(folder / "map.toml", place)
    (corpus / "good").write_bytes((folder / name).read_bytes()[:60_000])
    warnings.simplefilter("ignore")

    def read_one(data: bytes) -> None:
        (place / name).write_bytes(data)
        with contextlib.suppress(GroundStationError):
            read(place / name)

    def mutate(data: bytes, size: int, seed: int) -> bytes:
        chance = Random(seed)
        if chance.random() < 0.5 and data:
            return mutated(chance, data, kinds)[:size]
        return bytes(atheris.Mutate(data, size))

    options = [
        f"-max_total_time={seconds}", f"-timeout={TIMEOUT:g}", f"-rss_limit_mb={MEMORY >> 20}",
        "-max_len=100000", f"-artifact_prefix={folder}/", str(corpus),
    ]  # fmt: skip
    print(f"inputs of finds: {folder}", flush=True)
    atheris.Setup([sys.argv[0], *options], read_one, custom_mutator=mutate)
    atheris.Fuzz()


if __name__ == "__main__":
    main(*sys.argv[1:])
