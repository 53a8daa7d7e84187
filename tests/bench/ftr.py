"""Fourier transform regression in samples per second: six regressions, ten updates a second.

The flight is a virtual one at 100 Hz, combined elevator, aileron and rudder inputs throughout,
fed in the blocks of a replay and sample by sample as a live link would.

Then errors over bounds of 200 maneuvers with known derivatives, in white and in colored noise: an
rms of 0.8 to 1.3 is asked for, derivative by derivative (levels may be surer).
"""

import sys
import time

import numpy as np

from gsapp.aircraft import load_aircraft
from gsapp.identification.ftr import FTR, FTRSettings
from gsapp.quantities import Block
from gsapp.quantities.constants import GRAVITY
from tests.identification.ftr_truth import LEVELS, errors_over_bounds

RATE = 100.0
CHANNELS = (
    "V", "qbar", "alpha", "beta", "p", "q", "r", "ax", "ay", "an", "de", "da", "dr", "throttle",
    "density",
)  # fmt: skip
BLOCK = 512
GOAL = 50_000.0


def flight(seconds: float) -> Block:
    count = int(seconds * RATE)
    rng = np.random.default_rng(8)
    means = np.array([30, 551, 0.1, 0, 0, 0, 0, 0.3, 0, GRAVITY, 0, 0, 0, 0.5, 1.225])
    sizes = np.array([0.3, 10, 0.02, 0.02, 0.3, 0.1, 0.1, 0.2, 0.5, 2, 0.03, 0.03, 0.03, 0, 0])
    smooth = np.exp(-np.arange(40) / 10.0)
    noise = rng.standard_normal((count + 39, len(CHANNELS)))
    moved = np.column_stack([np.convolve(column, smooth / 3.0, "valid") for column in noise.T])
    return Block(
        channels=CHANNELS, times=np.arange(1.0, count + 1.0) / RATE, values=means + sizes * moved
    )


def measure(block: Block, piece: int, settings: FTRSettings) -> tuple[float, int]:
    """Return samples per second of CPU, and how many updates there were."""
    ftr = FTR(load_aircraft("b777"), settings, rate=RATE)
    pieces = [
        Block(
            channels=block.channels,
            times=block.times[start : start + piece],
            values=block.values[start : start + piece],
        )
        for start in range(0, len(block), piece)
    ]
    started = time.process_time()
    for one in pieces:
        ftr.feed(one)
        ftr.process_step()
    spent = time.process_time() - started
    ftr.finish()
    return len(block) / spent, ftr.history("Cm_alpha").times.size


def print_errors(repeats: int) -> None:
    """Print the rms of errors over bounds by derivative."""
    for kind in ("lon", "lat"):
        for color in (0.0, 0.9):
            ratios = errors_over_bounds(kind, color, repeats)
            print(f"{kind}, color {color}: rms of error over bound (times earned)")
            for name, values in ratios.items():
                rms = float(np.sqrt(np.mean(values**2)))
                good = rms <= 1.3 and (rms >= 0.8 or name in LEVELS)
                print(f"  {name:9} {rms:5.2f}{' ' if good else '!'} ({values.size})")


def main(*options: str) -> None:
    """Print the speed for several ways of listening."""
    seconds = 60.0 if "--quick" in options else 300.0
    block = flight(seconds)
    kinds = {
        "always, records of 10 s": FTRSettings(),
        "always, forgetting 15 s": FTRSettings(forgetting=15.0),
    }
    measure(block.between(0.0, 10.0), BLOCK, FTRSettings())
    for title, settings in kinds.items():
        for piece in (BLOCK, 1):
            part = block if piece > 1 else block.between(0.0, seconds / 10.0)
            # The best of three: other programs on the machine only ever slow it down.
            speed, updates = max(measure(part, piece, settings) for _ in range(3))
            text = f"{piece} samples at a time" if piece > 1 else "sample by sample"
            print(
                f"{title:26} {text:22} {speed:9,.0f} samples/s, {updates} updates of six "
                f"regressions ({speed / GOAL:.2f} of the goal)"
            )
    print_errors(5 if "--quick" in options else 25)


if __name__ == "__main__":
    main(*sys.argv[1:])
