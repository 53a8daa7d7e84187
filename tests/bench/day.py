"""A whole day at the field by mouse and keys, in a real X server; see `tests/ui/day_walk.py`."""

import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from tests.ui.x_driver import left_running, missing_programs, x_server

WALK = Path(__file__).parents[1] / "ui" / "day_walk.py"


def walk(name: str, folder: Path, where: dict[str, str]) -> dict[str, object]:
    command = [sys.executable, "-P", str(WALK), name, str(folder)]
    done = subprocess.run(command, env=where, capture_output=True, text=True, timeout=600.0)
    if done.returncode:
        raise SystemExit(f"{done.stderr}\nThe last picture is in {folder / 'pictures'}")
    seen: dict[str, object] = json.loads((folder / f"{name}.json").read_text())
    return seen


def main(*_options: str) -> None:
    """Start an X server, walk through the day in it, and print what was seen."""
    if missing := missing_programs():
        raise SystemExit(f"not installed: {', '.join(missing)}")
    folder = Path(tempfile.mkdtemp(prefix="gsapp-day-"))
    begun = time.monotonic()
    with x_server(folder) as where:
        seen = walk("whole", folder, where)
        running = left_running(folder)
        again = walk("again", folder, where)
    sizes = [f"{one.name} {one.stat().st_size / 1e3:.0f} kB" for one in folder.glob("report.*")]
    print(f"a day in {time.monotonic() - begun:.0f} s; pictures in {folder / 'pictures'}")
    print(f"wrong port      {seen['wrong_port']}")
    print(f"calibrated      {seen['calibrates']} alone: {seen['calibrated']}")
    print(f"lost beside another transmitter, seen after {seen['seen_after']:.1f} s (goal 4 s)")
    print(f"after landing   recording {seen['recording']}, alarms waiting {seen['waiting']}")
    print(f"reports         {', '.join(sorted(sizes))}")
    print(f"after closing   recorders {seen['recorders']}, processes {running}")
    print(f"started again   {again['listed']}")


if __name__ == "__main__":
    main()
