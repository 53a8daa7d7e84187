"""Sixteen maneuvers of about ten seconds in two flights, as a good crew would fly them.

Speeds from 80 to 115 ft/s (angles of attack from 2 to 7 deg), elevator doublets and 3-2-1-1 small
and large, aileron, rudder and both, doublets at sideslip, throttle moved at low and at medium
speed, flap up and down: so that effects of angle of attack, speed, throttle and flap can be told
apart. Timing, size and direction of inputs vary with the seed, as hands do.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from gsapp.aircraft import Aircraft
from gsapp.quantities import FloatArray
from tests.discrepancy.blind.engine import (
    CONTROLS,
    RATE,
    SETTLING,
    STEPS_PER_SECOND,
    Condition,
    Trim,
)
from tests.discrepancy.blind.jsbsim_aircraft import FOOT

DEGREE = math.pi / 180.0
SERVO_LAG = 0.04
"""Of each of the three lags between hand and surface, s."""
SERVO_ORDER = 3
LEVER_TIME = 0.4
"""That a hand takes to move throttle or flap lever, s."""
DURATION = 10.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Move:
    """One input: alternating pulses of a surface, or a lever moved to a new place."""

    channel: str
    shape: str
    size: float  # rad, or the change of throttle.
    width: float = 0.4  # Of a pulse (of the 1 of 3-2-1-1), s.
    start: float = 1.0  # s.


@dataclass(frozen=True, slots=True, kw_only=True)
class Planned:
    """One maneuver of the plan."""

    id: str
    flight: str
    kind: str
    speed: float  # ft/s.
    moves: tuple[Move, ...]
    throttle: float | None = None  # As in `Condition`.
    flap: float = 0.0
    beta: float = 0.0
    """deg."""

    @property
    def inputs(self) -> tuple[str, ...]:
        moved = {move.channel for move in self.moves}
        return tuple(name for name in ("de", "da", "dr") if name in moved)

    def condition(self, aircraft: Aircraft) -> Condition:
        burned = ((int(self.id) - 1) % 8 + 1) / 9.0 * aircraft.mass.fuel
        return Condition(
            V=self.speed * FOOT,
            throttle=self.throttle,
            flap=self.flap * DEGREE,
            beta=self.beta * DEGREE,
            mass=aircraft.mass.mass - burned,
        )


def _moves(*rows: tuple[str, str, float, float, float]) -> tuple[Move, ...]:
    return tuple(
        Move(
            channel=channel,
            shape=shape,
            size=size if channel == "throttle" else size * DEGREE,
            width=width,
            start=start,
        )
        for channel, shape, size, width, start in rows
    )


def _both(rudder: float, aileron: float) -> tuple[Move, ...]:
    return _moves(
        ("dr", "doublet", rudder, 0.55, 1.0),
        ("da", "doublet", aileron, 0.35, 3.0),
        ("dr", "doublet", 0.6 * rudder, 0.45, 5.0),
        ("da", "doublet", aileron, 0.35, 7.0),
    )


def _elevator(size: float) -> tuple[Move, ...]:
    return _moves(("de", "doublet", size, 0.4, 1.0), ("de", "doublet", 0.8 * size, 0.35, 5.0))


def _3211(size: float) -> tuple[Move, ...]:
    return _moves(("de", "3-2-1-1", size, 0.32, 1.0), ("de", "doublet", size, 0.35, 6.5))


PLAN: tuple[Planned, ...] = (
    Planned(id="1", flight="A", kind="doublet", speed=95, moves=_elevator(3.0)),
    Planned(id="2", flight="A", kind="3-2-1-1", speed=112, moves=_3211(2.5)),
    Planned(id="3", flight="A", kind="doublet", speed=85, moves=_elevator(7.0)),
    Planned(id="4", flight="A", kind="3-2-1-1", speed=100, throttle=0.25, moves=_3211(5.0)),
    Planned(
        id="5", flight="A", kind="doublet", speed=95,
        moves=_moves(("da", "doublet", 4.0, 0.4, 1.0), ("da", "doublet", 7.0, 0.35, 5.5)),
    ),
    Planned(
        id="6", flight="A", kind="doublet", speed=105,
        moves=_moves(("dr", "doublet", 8.0, 0.5, 1.0), ("dr", "doublet", 12.0, 0.5, 5.5)),
    ),
    Planned(id="7", flight="A", kind="doublet", speed=84, moves=_both(9.0, 5.0)),
    Planned(id="8", flight="A", kind="doublet", speed=114, moves=_both(8.0, 4.0)),
    Planned(
        id="9", flight="B", kind="doublet", speed=82, throttle=0.2,
        moves=_moves(
            ("throttle", "lever", 0.55, 0.0, 1.0), ("throttle", "lever", -0.5, 0.0, 4.0),
            ("de", "doublet", 3.0, 0.4, 6.0), ("dr", "doublet", 4.0, 0.5, 7.5),
        ),
    ),
    Planned(
        id="10", flight="B", kind="doublet", speed=98, throttle=0.9,
        moves=_moves(
            ("de", "doublet", 3.0, 0.4, 1.0), ("throttle", "lever", -0.7, 0.0, 3.5),
            ("throttle", "lever", 0.5, 0.0, 7.0),
        ),
    ),
    Planned(id="11", flight="B", kind="doublet", speed=84, flap=20.0, moves=_elevator(4.0)),
    Planned(id="12", flight="B", kind="doublet", speed=92, flap=20.0, moves=_both(9.0, 5.0)),
    Planned(id="13", flight="B", kind="doublet", speed=96, beta=7.0, moves=_elevator(4.0)),
    Planned(
        id="14", flight="B", kind="doublet", speed=100, beta=-6.0, throttle=0.8,
        moves=_moves(
            ("de", "doublet", 4.0, 0.4, 1.0), ("dr", "doublet", 8.0, 0.5, 3.5),
            ("da", "doublet", 5.0, 0.4, 6.0), ("de", "doublet", 4.0, 0.35, 8.0),
        ),
    ),
    Planned(
        id="15", flight="B", kind="3-2-1-1", speed=92,
        moves=(*_moves(("flap", "lever", 20.0, 0.0, 3.6)), *_3211(3.5)),
    ),
    Planned(
        id="16", flight="B", kind="doublet", speed=81, throttle=0.75, moves=_both(14.0, 9.0)
    ),
)  # fmt: skip


STALL_APPROACHES: tuple[Planned, ...] = tuple(
    Planned(
        id=str(number), flight=flight, kind="multistep", speed=speed, throttle=throttle,
        moves=_moves(("de", "pull", size, width, 1.0)),
    )
    for number, flight, speed, throttle, size, width in (
        (17, "A", 78, 0.35, -3.0, 4.0),
        (18, "A", 82, 0.2, -3.4, 3.0),
        (19, "B", 76, 0.3, -2.8, 5.0),
        (20, "B", 80, 0.4, -3.1, 3.5),
    )
)  # fmt: skip
"""Slow pulls into the stall and back, hands off the throttle."""


def _pulses(times: FloatArray, start: float, widths: Sequence[float]) -> FloatArray:
    out = np.zeros_like(times)
    edge, sign = start, 1.0
    for width in widths:
        out[(times >= edge) & (times < edge + width)] = sign
        edge, sign = edge + width, -sign
    return out


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Handled:
    """What hands did in one maneuver, at every step of JSBSim, the settling time included."""

    changes: FloatArray
    """Shape (n_steps, 5). Of the controls' commands from trim, in the order of `CONTROLS`."""

    def levers(self, trim: Trim) -> FloatArray:
        commands = np.array(trim.controls) + self.changes
        commands[:, -1] = np.clip(commands[:, -1], 0.0, 1.0)
        return commands


def hands(planned: Planned, seed: int) -> Handled:
    """Return the inputs of one maneuver of the plan; sizes, times, direction are a pilot's."""
    random = np.random.default_rng([seed, int(planned.id), 1])
    count = round((DURATION + SETTLING) * STEPS_PER_SECOND)
    times = np.arange(count) / STEPS_PER_SECOND - SETTLING
    changes = np.zeros((count, len(CONTROLS)))
    sign = float(random.choice((-1.0, 1.0)))
    late = float(random.uniform(-0.2, 0.3))
    for move in planned.moves:
        column = CONTROLS.index(move.channel)
        size = move.size * float(random.uniform(0.85, 1.15))
        start = move.start + late + float(random.uniform(-0.1, 0.1))
        if move.shape == "lever":
            changes[:, column] += size * np.clip((times - start) / LEVER_TIME, 0.0, 1.0)
            continue
        if move.shape == "pull":
            ahead = (times - start) / move.width
            changes[:, column] += size * np.clip(np.minimum(ahead, 2.2 - ahead), 0.0, 1.0)
            continue
        counts = (1.0, 1.0) if move.shape == "doublet" else (3.0, 2.0, 1.0, 1.0)
        widths = [move.width * one * float(random.uniform(0.9, 1.1)) for one in counts]
        changes[:, column] += sign * size * _pulses(times, start, widths)
    # Hands are never still: slow, small motion of all three surfaces.
    share = math.exp(-1.0 / (0.5 * STEPS_PER_SECOND))
    tremor = lfilter(
        [math.sqrt(1.0 - share * share)], [1.0, -share], random.standard_normal((count, 3)), axis=0
    )
    changes[:, :3] += 0.12 * DEGREE * (tremor - tremor[0])
    return Handled(changes=changes)


def lagged(history: FloatArray, tau: float) -> FloatArray:
    """Return a history at JSBSim's steps after one lag, settled at the start.

    Exact for straight lines between steps: without that, a lag of a few steps is half a step off.
    """
    if tau <= 0.0:
        return history
    ratio = 1.0 / (tau * STEPS_PER_SECOND)
    decay = math.exp(-ratio)
    mean = -math.expm1(-ratio) / ratio
    new, old = 1.0 - mean, mean - decay
    start = (1.0 - new) * history[:1]
    out, _ = lfilter([new, old], [1.0, -decay], history, axis=0, zi=start)
    return np.asarray(out)


def sampled(history: FloatArray) -> FloatArray:
    ahead = round(SETTLING * STEPS_PER_SECOND)
    return history[ahead :: STEPS_PER_SECOND // RATE]
