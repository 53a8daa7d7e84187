"""Section 7.4 of the source on virtual flights: three linear models, judged on another flight.

Two flights of the default plan, with the instruments and the noise of the aircraft file, other
hands and other air. The models are fitted on the maneuvers of the first and simulated over the
whole of the second, from its first maneuver to its last: RMS error over range, beside tables
7.4.1 and 7.4.2. Flights are kept in the folder for temporary files until something changes that
makes them.

    python linear_models.py [--quick]     --quick: the short plan
"""

import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
import zlib
from pathlib import Path

import gsapp
from gsapp.identification.linear_models.linear_model_files import published_errors

SEEDS = (1, 2)
FLOWN_BY = ("dynamics", "aircraft", "calibration", "decoding", "quantities")
MODELS = {"bls": "least squares", "subspace": "subspace", "ml": "ML"}


def gsapp_command(*arguments: str) -> float:
    started = time.monotonic()
    subprocess.run(
        [sys.executable, "-m", "gsapp.cli", *arguments],
        check=True,
        env={**os.environ, "OPENBLAS_NUM_THREADS": "1", "COLUMNS": "100"},
    )
    return time.monotonic() - started


def keep() -> Path:
    sources, state = Path(gsapp.__file__).parent, 0
    for part in FLOWN_BY:
        for file in sorted((sources / part).rglob("*")):
            if file.suffix in (".py", ".toml"):
                state = zlib.crc32(file.read_bytes(), state)
    return Path(tempfile.gettempdir()) / f"gsapp-bench-flights-{state:08x}"


def flight(folder: Path, plan: str, seed: int) -> Path:
    found = folder / f"{plan}-{seed}"
    if found.is_dir():
        print(f"{found}: kept from an earlier run")
        return found
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=folder) as scratch:
        flown = Path(scratch) / found.name
        spent = gsapp_command("fly", "--out", str(flown), "--plan", plan, "--seed", str(seed))
        flown.rename(found)
    print(f"{found}: flown in {spent:.0f} s")
    return found


def main(*options: str) -> None:
    """Fly, fit, judge; print the tables of the program, and what they come to."""
    plan = "short" if "--quick" in options else "default"
    one, other = (flight(keep(), plan, seed) for seed in SEEDS)
    with tempfile.TemporaryDirectory() as scratch:
        result = Path(scratch) / "models.json"
        spent = gsapp_command(
            "linear-models", str(one), "--validate", str(other), "--aircraft", "b777",
            "--json", str(result),
        )  # fmt: skip
        found = json.loads(result.read_text())
    published = published_errors()
    print(f"\nours over the source's, whole flight (fitted and judged in {spent:.0f} s)")
    print(f"{'':8}" + "".join(f"{title:>15}" for title in MODELS.values()))
    ratios = []
    for axis in ("lon", "lat"):
        channels = (found[axis] or {}).get("bls", {}).get("rms_over_range_pct", {})
        for channel in channels:
            row = []
            for name in MODELS:
                ours = found[axis][name]["rms_over_range_pct"][channel]
                # None: the model ran away over the whole flight.
                row.append(None if ours is None else ours / getattr(published[channel], name))
            ratios += row
            print(
                f"{channel:8}"
                + "".join(f"{'runs away' if one is None else f'{one:.2f}':>15}" for one in row)
            )
    known = [ratio for ratio in ratios if ratio is not None]
    print(
        f"{sum(ratio <= 1.0 for ratio in known)} of {len(ratios)} no larger than the source's; "
        f"median ratio {statistics.median(known):.2f}, largest {max(known):.2f}"
    )


if __name__ == "__main__":
    main(*sys.argv[1:])
