"""Opening a flight for review, and working on its time line.

The virtual aircraft flies its usual flight of eight minutes at the full rate. It is opened as when
it has just landed, and again from what was kept of it, each beside another program that reads the
same: pymavlink all messages of the record, numpy the samples as a table of text. Times are scaled
to a flight of ten minutes. Then the window: what a key, a drag and a new picture cost.
"""

import os
import shutil
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from gsapp.flight.file_names import CACHE_FOLDER, FRAMES_FILE
from gsapp.session.review import ReviewedFlight, open_reviewed_flight

TEN_MINUTES = 600.0
GOAL = 1.0


def timed(work: Callable[[], object], rounds: int) -> float:
    best = np.inf
    for _ in range(rounds):
        started = time.perf_counter()
        work()
        best = min(best, time.perf_counter() - started)
    return float(best)


def pymavlink_reads(record: Path) -> None:
    os.environ["MAVLINK20"] = "1"
    from pymavlink import mavutil

    log = mavutil.mavlink_connection(str(record))
    while log.recv_msg() is not None:
        pass


def opening(folder: Path, quick: bool) -> ReviewedFlight:
    """Print how long a flight takes to open."""
    flight = open_reviewed_flight(folder)
    first, last = flight.span
    scale = TEN_MINUTES / (last - first)
    block = flight.flight.block
    table = folder.parent / "table.txt"
    np.savetxt(table, block.values[:: 10 if quick else 1])
    text = timed(lambda: np.loadtxt(table), 1) * (10 if quick else 1)
    messages = timed(lambda: pymavlink_reads(folder / FRAMES_FILE), 1)

    def anew() -> None:
        shutil.rmtree(folder / CACHE_FOLDER)
        open_reviewed_flight(folder)

    print(f"{len(block.times)} samples of {len(block.channels)} channels, "
          f"{len(flight.maneuvers)} maneuvers")  # fmt: skip
    for words, seconds, other, program in (
        ("just landed", timed(anew, 2), messages, "pymavlink reading the messages"),
        ("opened before", timed(lambda: open_reviewed_flight(folder), 5), text, "numpy.loadtxt"),
    ):
        print(
            f"{words:14} {scale * seconds:6.2f} s for ten minutes ({seconds / other:.3f} of "
            f"{program}; {scale * seconds / GOAL:.2f} of the goal)"
        )
    return flight


def working(folder: Path) -> None:
    """Print what a key, a drag and a picture of the time line cost."""
    from PySide6.QtWidgets import QApplication

    from tests.screenshots.screenshot_taker import WindowAppearance, screenshot_window, wait_until

    with screenshot_window(WindowAppearance()) as window:
        window.store.change(review_flights=(str(folder),))
        window.show_page("review")
        window.review_page.go_to_step("maneuvers")
        page, work = window.review_page.step_page, QApplication.processEvents
        started = time.perf_counter()
        wait_until(work, lambda: bool(page.review.flights), "the flight to open")
        print(f"window: {time.perf_counter() - started:.2f} s from asking to the time line")
        actions = window.commands.actions
        one = page.editing.row.maneuver
        stops = iter(np.arange(one.t_start + 1.0, one.t_end, 0.01).tolist())
        actions: dict[str, Callable[[], object]] = {
            "an edge moved by a key, written and shown": actions["review_start_later"].trigger,
            "an edge dragged by one more pixel": lambda: page._preview_edges(
                one.id, one.t_start, next(stops)
            ),
            "the whole flight drawn": page.timeline.show_all,
            "twenty seconds drawn": lambda: page.timeline.zoom_to(150.0, 162.0),
        }
        for text, action in actions.items():

            def shown(action: Callable[[], object] = action) -> None:
                action()
                work()

            print(f"{1e3 * timed(shown, 10):6.1f} ms  {text}")


def main(*options: str) -> None:
    from tests.screenshots.virtual_flight import write_virtual_flight

    with tempfile.TemporaryDirectory() as scratch:
        quick = "--quick" in options
        folder = write_virtual_flight(Path(scratch), "short" if quick else "default")
        opening(folder, quick)
        working(folder)


if __name__ == "__main__":
    main(*sys.argv[1:])
