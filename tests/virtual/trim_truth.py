"""Was the aircraft trimmed? By the states of the simulator and the stated tolerances alone.

At each moment every state is averaged over the last second, as `TrimTolerances` says, and divided
by its tolerance; so is the unrest of the last three seconds. The largest of these shares tells:
below 1 trimmed, above not. Nothing of the code under test is used but the figures themselves.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from gsapp.aircraft import Aircraft, load_aircraft
from gsapp.dynamics.flight_model import FlightModel
from gsapp.dynamics.model import load_model
from gsapp.dynamics.trim import trim
from gsapp.excitation.flight_rows import rows_from_block
from gsapp.excitation.test_points.point import TestPoint
from gsapp.excitation.trim.trim_cue import DEFAULT_TOLERANCES, TrimCue
from gsapp.excitation.trim.trim_monitor import TrimMonitor
from gsapp.quantities import Block
from gsapp.quantities.constants import DEGREE, FOOT
from tests.virtual.inputs import RATE, FlownInput

INSTRUMENTS = {
    "all": (),
    "no attitude": ("phi", "theta", "psi"),
    "no attitude, no vanes": ("phi", "theta", "psi", "alpha", "beta"),
}
"""What each set of instruments lacks."""
EDGE = 0.1
"""Within so much of a boundary nobody can tell: scored apart."""
IN_TIME = 1.0
"""GO has to come within this, s."""
_BEGIN = 8.0
"""Seconds in which nothing is scored: no aircraft appears in mid-air, as these do, and a bank that
is not measured takes so long to be known."""
_SECOND = round(DEFAULT_TOLERANCES.averaging_time * RATE)
_CALM = round(DEFAULT_TOLERANCES.turbulence_time / DEFAULT_TOLERANCES.averaging_time)
_HASTE = 0.59
"""A state left sooner, s, flickers."""


def point_of(flown: FlownInput) -> TestPoint:
    aircraft = load_aircraft("b777")
    rho = float(flown.truth["density"].mean())
    level = trim(FlightModel(aircraft, load_model("b777")), V=flown.plan.speed, rho=rho)
    return TestPoint(
        speed=flown.plan.speed,
        alpha=level.polar.alpha,
        speed_tolerance=5.0 * FOOT,
        alpha_tolerance=1.5 * DEGREE,
    )


def untrimmed(truth: Block, point: TestPoint | None, *, attitude: bool = True) -> np.ndarray:
    """Return the largest share of all tolerances at each sample; NaN in the first three seconds.

    Parameters
    ----------
    truth : Block
        The states at the CG, 100 Hz.
    point : TestPoint or None
    attitude : bool
        Which tolerance of the bank counts.
    """
    limits = DEFAULT_TOLERANCES
    means = {
        "phi": limits.bank if attitude else limits.bank_unmeasured,
        "p": limits.roll_rate,
        "q": limits.pitch_rate,
        "r": limits.yaw_rate,
        "climb_rate": limits.climb,
    }
    shares = [np.abs(_lines(truth[name])[0]) / limit for name, limit in means.items()]
    shares.append(np.abs(_lines(truth["V"])[1]) * RATE / limits.acceleration)
    if point is not None:
        speed, alpha = _lines(truth["V"])[0], _lines(truth["alpha"])[0]
        shares.append(np.abs(speed - point.speed) / point.speed_tolerance)
        shares.append(np.abs(alpha - point.alpha) / point.alpha_tolerance)
    unrest = {
        "p": limits.roll_rate_rms,
        "q": limits.pitch_rate_rms,
        "r": limits.yaw_rate_rms,
        "an": limits.an_rms,
        "alpha": limits.alpha_rms,
        "beta": limits.beta_rms,
    }
    for name, limit in unrest.items():
        power = _lines(truth[name])[2]
        late = [np.concatenate((np.full(k * _SECOND, np.nan), power)) for k in range(_CALM)]
        seconds = np.array([one[: power.size] for one in late])
        shares.append(np.sqrt(seconds.mean(axis=0)) / limit)
    return np.asarray(np.max(shares, axis=0))


def _lines(values: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    windows = np.lib.stride_tricks.sliding_window_view(values, _SECOND)
    place = np.arange(_SECOND) - 0.5 * (_SECOND - 1)
    mean = windows.mean(axis=1)
    slope = (windows - mean[:, None]) @ place / (place @ place)
    power = (windows - mean[:, None]) ** 2
    rest = power.mean(axis=1) - slope**2 * (place @ place) / _SECOND
    before = np.full(_SECOND - 1, np.nan)
    mean, slope, rest = (np.concatenate((before, one)) for one in (mean, slope, rest))
    return mean, slope, np.maximum(rest, 0.0)


def without(block: Block, channels: Sequence[str]) -> Block:
    kept = tuple(name for name in block.channels if name not in channels)
    return Block(
        channels=kept, times=block.times, values=np.column_stack([block[name] for name in kept])
    )


def cues_of(block: Block, point: TestPoint | None, aircraft: Aircraft | None) -> list[TrimCue]:
    watch = TrimMonitor(aircraft, RATE)
    watch.set_test_point(point)
    rows = rows_from_block(block, RATE)
    cues = []
    for start in range(0, len(rows) - 4, 5):
        watch.process_rows(rows.slice_rows(start, start + 5))
        assert watch.cue is not None
        cues.append(watch.cue)
    return cues


@dataclass(slots=True, kw_only=True)
class Score:
    """What the cues of some flights were worth."""

    right: int = 0
    edge: int = 0
    wrong: int = 0
    """GOs given trimmed, within `EDGE` of a boundary, untrimmed."""
    trimmed: int = 0
    in_time: int = 0
    """Spells of a second or more clearly within all tolerances; those in which GO stood within
    `IN_TIME`."""
    delays: list[float] = field(default_factory=list)  # From the begin of each spell to GO, s.
    go: float = 0.0
    overstayed: float = 0.0
    """Seconds of GO, and those of them in which trim was lost already."""
    gusty: float = 0.0
    seconds: float = 0.0
    """Seconds of ``gusty``, and all."""
    changes: int = 0
    hasty: int = 0
    """Of state; those after less than `_HASTE` of a state other than GO."""

    def add(self, other: Score) -> None:
        for name in self.__slots__:
            setattr(self, name, getattr(self, name) + getattr(other, name))


def score(flown: FlownInput, instruments: str) -> Score:
    """Return what the cues were worth before the input of a flight."""
    point = point_of(flown)
    missing = INSTRUMENTS[instruments]
    cues = cues_of(without(flown.measured, missing), point, flown.aircraft)
    shares = untrimmed(flown.truth, point, attitude="phi" not in missing)
    begin = float(flown.truth.times[0])
    cues = [cue for cue in cues if begin + _BEGIN <= cue.time < flown.t_input]
    places = [round((cue.time - begin) * RATE) for cue in cues]
    off = shares[places]
    go = np.array([cue.state == "go" for cue in cues])
    found = Score(
        go=0.05 * int(go.sum()),
        overstayed=0.05 * int((go & (off > 1.0 + EDGE)).sum()),
        gusty=0.05 * sum(cue.state == "gusty" for cue in cues),
        seconds=0.05 * len(cues),
    )
    for place in np.flatnonzero(go[1:] & ~go[:-1]) + 1:
        kind = "right" if off[place] < 1.0 - EDGE else "edge"
        kind = "wrong" if off[place] > 1.0 + EDGE else kind
        setattr(found, kind, getattr(found, kind) + 1)
    for before, after in pairwise(cues):
        if before.state != after.state:
            found.changes += 1
            found.hasty += before.state != "go" and after.time - before.since < _HASTE
    _spells(off < 1.0 - EDGE, go, found)
    return found


def _spells(trimmed: np.ndarray, go: np.ndarray, found: Score) -> None:
    edges = np.flatnonzero(np.diff(np.concatenate(([0], trimmed.astype(int), [0]))))
    late = round(IN_TIME / 0.05)
    for start, stop in zip(edges[::2], edges[1::2], strict=True):
        if stop - start <= late:
            continue
        found.trimmed += 1
        given = np.flatnonzero(go[start:stop])
        if given.size:
            found.delays.append(0.05 * float(given[0]))
            found.in_time += int(given[0] <= late)
