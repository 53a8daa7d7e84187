"""Detection of maneuvers: seconds for a ten-minute flight, against plain loops over its samples.

The baseline takes the same figures from the samples, and no more, in plain Python: for every
channel the mean of each half second and the scatter about the straight line of each two seconds,
for every surface how far it went within 0.15 s. It judges nothing.
"""

import sys
import time
from collections.abc import Callable

from gsapp.aircraft import load_aircraft
from gsapp.flight import Flight
from gsapp.flight.maneuvers import ManeuverDetector, detect_maneuvers
from gsapp.quantities import Block
from tests.flight.maneuver_kit import Input, make_flight

LIVE_ROWS = 10


def flight_of(seconds: float) -> Flight:
    inputs = [
        Input(at=at, surface=("de", "da", "dr")[index % 3], size=(5.0, 6.0, 10.0)[index % 3])
        for index, at in enumerate(range(120, int(seconds) - 20, 30))
    ]
    return make_flight(inputs, seconds=seconds, ground=90.0, range_check=[(40.0, "de")], gusts=0.3)


def plain_figures(block: Block) -> int:
    """Take the figures of each frame and window, sample by sample; return how many."""
    columns = [block[name].tolist() for name in block.channels]
    surfaces = [block[name].tolist() for name in ("de", "da", "dr")]
    count = len(columns[0])
    figures = 0
    for column in columns:
        for low in range(0, count, 50):
            total = 0.0
            for value in column[low : low + 50]:
                total += value
            figures += 1
        for low in range(0, count, 200):
            figures += scatter(column[low : low + 200]) >= 0.0
    for samples in surfaces:
        for low in range(15, count, 50):
            most = 0.0
            for row in range(low, min(low + 50, count)):
                most = max(most, abs(samples[row] - samples[row - 15]))
            figures += 1
    return figures


def scatter(samples: list[float]) -> float:
    middle = 0.5 * (len(samples) - 1)
    mean = sum(samples) / len(samples)
    power = cross = square = 0.0
    for index, value in enumerate(samples):
        power += (index - middle) ** 2
        cross += (index - middle) * (value - mean)
        square += (value - mean) ** 2
    return max((square - cross * cross / power) / (len(samples) - 2), 0.0) ** 0.5


def live(block: Block) -> int:
    detector = ManeuverDetector(load_aircraft("b777"), 100.0)
    for low in range(0, len(block), LIVE_ROWS):
        detector.feed(
            Block.unchecked(
                block.channels,
                block.times[low : low + LIVE_ROWS],
                block.values[low : low + LIVE_ROWS],
            )
        )
        detector.process_step()
    return len(detector.finish())


def best(work: Callable[[], object], repeats: int) -> float:
    seconds = []
    for _ in range(repeats):
        start = time.process_time()
        work()
        seconds.append(time.process_time() - start)
    return min(seconds)


def main(*options: str) -> dict[str, float]:
    """Measure, print and return CPU seconds, and the ratio to the plain loop."""
    quick = "--quick" in options
    repeats = 2 if quick else 5
    flight = flight_of(300.0 if quick else 600.0)
    block = flight.block
    aircraft = load_aircraft("b777")
    found = detect_maneuvers(flight, aircraft)
    if live(block) != len(found):
        raise RuntimeError("fed piece by piece, another number of maneuvers was found")
    whole = best(lambda: detect_maneuvers(flight, aircraft), repeats)
    plain = best(lambda: plain_figures(block), repeats)
    pieces = best(lambda: live(block), 1 if quick else 2)
    results = {
        "seconds for the flight": whole,
        "plain loops, the same figures only": plain,
        "ratio, plain over whole": plain / whole,
        "samples per second": len(block) / whole,
        "live, share of a core": pieces / flight.duration,
    }
    print(f"{len(block)} samples, {len(block.channels)} channels, {len(found)} maneuvers found")
    print(f"{'detection, whole flight at once':40} {whole:9.3f} s CPU")
    print(
        f"{'plain loops, the same figures only':40} {plain:9.3f} s CPU   "
        f"{plain / whole:6.2f} x as long"
    )
    print(f"{'detection, a tenth of a second at a time':40} {pieces:9.3f} s CPU   "
          f"{100.0 * results['live, share of a core']:6.2f} % of a core")  # fmt: skip
    return results


if __name__ == "__main__":
    main(*sys.argv[1:])
