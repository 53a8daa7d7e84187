"""What a pilot sets out to do with one input, and how well: drawn from a seed."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from gsapp.quantities.constants import DEGREE, FOOT

SURFACES = ("de", "da", "dr")
NOMINAL = {"de": 4.5 * DEGREE, "da": 6.0 * DEGREE, "dr": 10.0 * DEGREE}
"""Amplitudes that the shipped test cards ask for; drawn ones lie around them."""
WIDTHS = {"de": 0.58, "da": 0.36, "dr": 0.56}
SPEEDS = tuple(speed * FOOT for speed in (85.0, 92.0, 100.0, 108.0))


@dataclass(frozen=True, slots=True, kw_only=True)
class Meddling:
    surface: str
    size: float
    at: float
    length: float


@dataclass(frozen=True, slots=True, kw_only=True)
class InputPlan:
    """What a pilot sets out to do, and how well."""

    surfaces: tuple[str, ...] = ("de",)  # In the order in which they are moved.
    kind: str = "doublet"  # ``doublet``, ``3-2-1-1``, ``pulse``.
    speed: float = SPEEDS[2]  # Of the test point, m/s.
    amplitudes: Mapping[str, float] = field(default_factory=lambda: dict(NOMINAL))
    """Meant, rad; negative begins on the other side."""
    width: float = 0.45
    balance: float = 1.0
    stagger: float = 0.8
    """Of one step, s; first half over second half in length; of each further surface, s."""
    bank: float = 0.0
    speed_off: float = 0.0
    """With which the input begins, rad and m/s."""
    roll_rate: float = 0.0
    pitch_rate: float = 0.0
    """The pilot is still correcting with about so much, rad/s."""
    meddling: tuple[Meddling, ...] = ()  # Sticks moved that should not.
    hands_off: float = 5.5  # How long all sticks are left alone after the input, s.
    left_over: float = 0.0  # Share of the amplitude by which the moved sticks do not come back.
    turbulence: float = 0.0  # Standard deviation of the gusts, m/s.
    noise: float = 1.0  # All instruments' noise is so many times that of the aircraft file.
    attitude: bool = True
    position: bool = True
    """Whether the aircraft has sensors for them."""
    approach: float = 6.0
    still: float = 1.2
    """Seconds in which the pilot corrects, and in which the sticks are then held."""
    start: tuple[float, float, float, float, float, float] = (0.0,) * 6
    """Errors with which the approach begins: bank (rad), path (rad), speed (m/s), p, q, r
    (rad/s)."""
    ground: float = 0.0
    """Seconds on the ground with the engines running, recorded before; 0 for none."""


def draw(seed: int, surfaces: tuple[str, ...] = ()) -> InputPlan:
    """Return a plan drawn from a seed: a good part without a fault, the rest with one or two.

    Parameters
    ----------
    seed : int
    surfaces : tuple of str
        In place of those drawn.
    """
    random = np.random.default_rng((seed, 6))
    choice = int(random.choice(4, p=(0.35, 0.2, 0.2, 0.25)))
    surfaces = surfaces or (("de",), ("da",), ("dr",), ("da", "dr"))[choice]
    side = 1.0 if random.random() < 0.5 else -1.0

    def chance(share: float) -> bool:
        return bool(random.random() < share)

    size = math.exp(0.15 * random.standard_normal())
    if chance(0.3):
        size = float(np.exp(random.uniform(math.log(0.15), math.log(2.6))))
    width = math.exp(0.1 * random.standard_normal())
    if chance(0.2):
        width = float(np.exp(random.uniform(math.log(0.4), math.log(2.6))))
    sizes = {
        name: (side if index == 0 else -side) * size * NOMINAL[name] * around_one(0.08, random)
        for index, name in enumerate(surfaces)
    }
    step = WIDTHS[surfaces[-1]] * width
    rates = [0.0, 0.0]
    bank, speed_off = 1.5 * DEGREE * random.standard_normal(), 2.0 * FOOT * random.standard_normal()
    if chance(0.2):
        axis = int(random.integers(4))
        if axis < 2:
            rates[axis] = math.copysign(random.uniform(3.0, 16.0), random.uniform(-1, 1)) * DEGREE
        elif axis == 2:
            bank = math.copysign(random.uniform(4.0, 25.0), random.uniform(-1, 1)) * DEGREE
        else:
            speed_off = math.copysign(random.uniform(4.0, 18.0), random.uniform(-1, 1)) * FOOT
    meddling: tuple[Meddling, ...] = ()
    if chance(0.16):
        others = [name for name in SURFACES if name not in surfaces]
        other = others[int(random.integers(len(others)))]
        share = random.uniform(0.1, 1.1)
        meddling = (
            Meddling(
                surface=other,
                size=math.copysign(share * size * NOMINAL[other], random.uniform(-1, 1)),
                at=random.uniform(0.0, 1.5),
                length=random.uniform(0.4, 1.2),
            ),
        )
    return InputPlan(
        surfaces=surfaces,
        speed=SPEEDS[int(random.integers(len(SPEEDS)))],
        amplitudes=sizes,
        width=step,
        balance=math.exp(0.12 * random.standard_normal()),
        stagger=2.0 * step * around_one(0.1, random),
        bank=bank,
        speed_off=speed_off,
        roll_rate=rates[0],
        pitch_rate=rates[1],
        meddling=meddling,
        hands_off=random.uniform(0.2, 4.0) if chance(0.12) else random.uniform(5.4, 6.0),
        left_over=random.uniform(0.15, 0.7) if chance(0.05) else 0.03 * random.standard_normal(),
        turbulence=0.0 if chance(0.4) else float(random.uniform(0.05, 1.1)),
        noise=float(np.exp(random.uniform(math.log(0.6), math.log(2.0)))),
        attitude=chance(0.5),
        approach=random.uniform(4.0, 10.0),
        still=random.uniform(0.8, 2.0),
        start=(
            math.copysign(random.uniform(3.0, 30.0), random.uniform(-1, 1)) * DEGREE,
            random.uniform(-4.0, 4.0) * DEGREE,
            random.uniform(-8.0, 8.0) * FOOT,
            *(5.0 * DEGREE * random.standard_normal(3)),
        ),
    )


def around_one(error: float, random: np.random.Generator) -> float:
    return max(0.4, 1.0 + error * float(random.standard_normal()))
