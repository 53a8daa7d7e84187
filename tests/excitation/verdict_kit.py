"""Truth labels of flown inputs from the simulator's states and stated bands; and watches flown."""

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from gsapp.aircraft import load_aircraft
from gsapp.dynamics.model import load_model
from gsapp.excitation.doublets.doublet_monitor import DoubletMonitor
from gsapp.excitation.doublets.verdict import InputVerdict
from gsapp.excitation.flight_rows import FlightRows, FlightRowStream
from gsapp.excitation.test_points.point import TargetInput, TestPoint
from gsapp.excitation.test_points.target_selection import select_target_input
from gsapp.excitation.trim.trim_cue import DEFAULT_TOLERANCES
from gsapp.flight.cards import TestCard
from gsapp.quantities import Block
from gsapp.quantities.constants import DEGREE, FOOT
from tests.virtual.inputs import FlownInput

RATE = 100.0
NEAR = 0.1
"""Cases this near to a boundary, as a share of it, are scored apart."""
START = 2.0
"""Times the tolerances of GO within which a start counts."""
OTHER_STICK, LEFT_OVER, HANDS_OFF, GUSTS = 0.35, 0.4, 0.5, 0.5
"""Stated: share of the main input by which another stick spoils; of its amplitude by which a stick
is not brought back; of the wanted interval that hands must be off; of the answer that is gust."""
ANSWERS = {"de": ("alpha", "q", "an"), "da": ("p", "r"), "dr": ("beta", "p", "r", "ay")}
"""Stated: what answers to each surface."""
CLIPPED_FOR, OUT_FOR = 0.03, 0.1
"""Stated: seconds beyond a sensor's range, and out of the linear range, that count."""
MOVED = 0.3 * DEGREE
"""Stated: a surface that goes further with the hands off is a hand put on."""


@dataclass(frozen=True, kw_only=True)
class Label:
    """What an input truly was."""

    result: str
    near: tuple[str, ...]
    """Criteria so near to their boundary that the result may as well be another."""
    values: dict[str, float]
    """Each criterion over its limit: more than 1 speaks against the input."""


@dataclass(frozen=True, kw_only=True)
class Heard:
    """What a watch said of a flown input, and when, s; NaN for never."""

    verdicts: tuple[InputVerdict, ...]
    recognized: float
    """When an input was first under way near the true one."""
    countdown: float
    """When hands off was first told."""
    begun: list[float]
    """When anything was first taken for an input."""


def point_of(flown: FlownInput) -> TestPoint:
    return TestPoint(
        speed=flown.plan.speed, speed_tolerance=5.0 * FOOT, alpha_tolerance=1.5 * DEGREE
    )


def wanted_of(flown: FlownInput, surfaces: tuple[str, ...] = (), kind: str = "") -> TargetInput:
    return select_target_input(
        surfaces or flown.plan.surfaces,
        kind or flown.plan.kind,
        aircraft=flown.aircraft,
        model=load_model("b777"),
        point=point_of(flown),
    )


def rows_in_ticks(*blocks: Block) -> Iterator[FlightRows]:
    stream = FlightRowStream(RATE)
    for block in blocks:
        for rows in itertools.chain(stream.feed(block), stream.finish()):
            for low in range(0, len(rows), stream.tick):
                yield rows.slice_rows(low, min(low + stream.tick, len(rows)))


def watched(
    flown: FlownInput,
    *blocks: Block,
    wanted: TargetInput | None = None,
    card: TestCard | None = None,
    invalid: Sequence[str] = (),
) -> tuple[InputVerdict, ...]:
    """Return the verdicts of a watch that expects an input, on its samples or on others."""
    watch = DoubletMonitor(load_aircraft("b777"), RATE)
    watch.expect(wanted or wanted_of(flown), point_of(flown), card)
    watch.set_invalid_channels(invalid)
    for rows in rows_in_ticks(*blocks or (flown.measured,)):
        watch.process_rows(rows)
    return watch.verdicts


def listen(flown: FlownInput, *, expected: bool = True, model: str | None = "b777") -> Heard:
    """Watch a flown input tick by tick; `expected` where the crew has said what comes."""
    watch = DoubletMonitor(
        load_aircraft("b777"),
        RATE,
        model=None if model is None else load_model(model),
        wanted_for=lambda surfaces, kind, _: wanted_of(flown, surfaces, kind),
    )
    watch.expect(wanted_of(flown) if expected else None, point_of(flown), None)
    blocks = [flown.measured] if flown.ground is None else [flown.ground, flown.measured]
    recognized = countdown = math.nan
    begun: list[float] = []
    known = 0.0
    for rows in rows_in_ticks(*blocks):
        watch.process_rows(rows)
        now = watch.input_in_progress
        if now is None:
            continue
        if now.t_input != known:
            begun.append(now.time)
            known = now.t_input
        if abs(now.t_input - flown.t_input) < 0.6 and math.isnan(recognized):
            recognized = now.time
        if now.phase == "hands-off" and math.isnan(countdown) and now.time > flown.t_input:
            countdown = now.time
    watch.finish()
    return Heard(verdicts=watch.verdicts, recognized=recognized, countdown=countdown, begun=begun)


def own(flown: FlownInput, verdicts: Sequence[InputVerdict]) -> list[InputVerdict]:
    return [
        one
        for one in verdicts
        if one.t_input <= flown.t_let_go and one.t_input_end >= flown.t_input
    ]


# --- the truth ---------------------------------------------------------------------------------


def label(flown: FlownInput, wanted: TargetInput) -> Label:
    values = _criteria(flown, wanted)
    near = []
    for name, value in values.items():
        if value > 1.0 + NEAR:
            return Label(result=_RESULTS[name], near=tuple(near), values=values)
        if value > 1.0 - NEAR:
            near.append(name)
    over = [name for name in near if values[name] > 1.0]
    return Label(result=_RESULTS[over[0]] if over else "good", near=tuple(near), values=values)


_RESULTS = {
    "clipped": "too-large",
    "trim": "not-trimmed",
    "stick": "invalid",
    "back": "invalid",
    "hands": "invalid",
    "small": "too-small",
    "linear": "too-large",
    "gusts": "invalid",
    "quick": "too-fast",
    "slow": "too-slow",
}


def first_move(flown: FlownInput) -> float:
    truth = flown.truth
    low = int(np.searchsorted(truth.times, flown.t_input))
    found = []
    for surface in flown.plan.surfaces:
        level = float(truth[surface][low - 20 : low].mean())
        away = np.abs(truth[surface][low:] - level)
        size = abs(flown.plan.amplitudes[surface])
        gone = np.flatnonzero(away > 0.1 * size)
        if gone.size:
            found.append(float(truth.times[low + int(gone[0])]))
    return min(found)


def _criteria(flown: FlownInput, wanted: TargetInput) -> dict[str, float]:
    truth, plan, aircraft = flown.truth, flown.plan, flown.aircraft
    times = truth.times
    begin = int(np.searchsorted(times, flown.t_input - 1e-6))
    second = slice(begin - 100, begin)
    back = int(np.searchsorted(times, flown.t_let_go + 0.35))
    shapes = {name: _shape(truth, name, begin, back) for name in plan.surfaces}
    rest_from, hand = _hand(flown, max(shape.end for shape in shapes.values()))
    stop = min(flown.t_hand, rest_from + wanted.hands_off)
    whole = slice(begin, int(np.searchsorted(times, stop)))
    means = {name: float(truth[name][second].mean()) for name in ("p", "q", "r", "phi", "V")}
    bank = DEFAULT_TOLERANCES.bank if plan.attitude else DEFAULT_TOLERANCES.bank_unmeasured
    share = {name: _share(aircraft, name, shape.amplitude) for name, shape in shapes.items()}
    main = max(share.values())
    others = [
        _share(aircraft, name, float(np.abs(truth[name][whole] - truth[name][second].mean()).max()))
        for name in ("de", "da", "dr")
        if name not in plan.surfaces
    ]
    gyro = aircraft.sensors.gyro.range[1]
    limits = aircraft.limits
    low_alpha, high_alpha = limits.alpha_linear
    alpha, beta, an = truth["alpha"][whole], truth["beta"][whole], truth["an"][whole]
    return {
        "clipped": max(_held(np.abs(truth[name][whole]), CLIPPED_FOR) for name in "pqr") / gyro,
        "trim": max(
            abs(means["p"]) / (START * DEFAULT_TOLERANCES.roll_rate),
            abs(means["q"]) / (START * DEFAULT_TOLERANCES.pitch_rate),
            abs(means["r"]) / (START * DEFAULT_TOLERANCES.yaw_rate),
            abs(means["phi"]) / (START * bank),
            abs(means["V"] - plan.speed) / (START * 5.0 * FOOT),
        ),
        "stick": max(others) / main / OTHER_STICK,
        "back": max(shape.left_over for shape in shapes.values()) / LEFT_OVER,
        "hands": HANDS_OFF * wanted.hands_off / max(hand - rest_from, 1e-3),
        "small": max(
            wanted.amplitudes[name].low / shape.amplitude for name, shape in shapes.items()
        ),
        "linear": max(
            _held(alpha, OUT_FOR) / high_alpha,
            _held(-alpha, OUT_FOR) / -low_alpha,
            _held(np.abs(beta), OUT_FOR) / limits.beta_linear,
            _held(an, OUT_FOR) / limits.load_factor[1],
            _held(-an, OUT_FOR) / -limits.load_factor[0],
        ),
        "gusts": gust_share(flown, stop) / GUSTS,
        "quick": max(wanted.width.low / shape.width for shape in shapes.values()),
        "slow": max(shape.width / wanted.width.high for shape in shapes.values()),
    }


def gust_share(flown: FlownInput, stop: float) -> float:
    """Return the gusts' part of the true answer over what it is without them."""
    calm = flown.calm
    low = int(np.searchsorted(flown.truth.times, calm.times[0] - 1e-6))
    count = int(np.searchsorted(calm.times, stop))
    axes = []
    for surfaces in ({"de"}, {"da", "dr"}):
        names = {name for one in surfaces & set(flown.plan.surfaces) for name in ANSWERS[one]}
        if names:
            axes.append(sorted(names))
    shares = []
    for names in axes:
        squares = [
            float(np.var(flown.truth[name][low : low + count] - calm[name][:count]))
            / float(np.var(calm[name][:count]))
            for name in names
        ]
        shares.append(math.sqrt(sum(squares) / len(squares)))
    return max(shares)


@dataclass(frozen=True)
class _Shape:
    amplitude: float
    width: float
    left_over: float
    end: float


def _shape(truth: Block, surface: str, begin: int, back: int) -> _Shape:
    """Return size, step, rest and end of a doublet as the surface truly made it."""
    level = float(truth[surface][begin - 20 : begin].mean())
    away = truth[surface][begin : back + 30] - level
    amplitude = 0.5 * float(np.ptp(away))
    rest = float(truth[surface][back + 5 : back + 30].mean()) - level
    first, second = sorted((int(np.argmax(away)), int(np.argmin(away))))
    start = int(np.flatnonzero(np.abs(away[: first + 1]) > 0.5 * abs(away[first]))[0])
    half = rest + 0.5 * (away[second] - rest)
    later = np.flatnonzero(np.sign(away[second]) * (away[second:] - half) < 0.0)
    end = second + (int(later[0]) if later.size else 0)
    return _Shape(
        amplitude=amplitude,
        width=0.5 * (end - start) / RATE,
        left_over=abs(rest) / amplitude,
        end=float(truth.times[begin + end]),
    )


def _hand(flown: FlownInput, end: float) -> tuple[float, float]:
    truth = flown.truth
    low = int(np.searchsorted(truth.times, flown.t_hand))
    moved = float(truth.times[-1])
    for surface in ("de", "da", "dr"):
        level = float(truth[surface][low - 2 : low + 2].mean())
        gone = np.flatnonzero(np.abs(truth[surface][low:] - level) > MOVED)
        if gone.size:
            moved = min(moved, float(truth.times[low + int(gone[0])]))
    return end + 0.1, moved


def _share(aircraft: object, surface: str, size: float) -> float:
    low, high = getattr(aircraft.controls, surface).travel  # type: ignore[attr-defined]
    return size / (0.5 * (high - low))


def _held(values: np.ndarray, seconds: float) -> float:
    count = max(round(seconds * RATE), 1)
    return float(np.sort(values)[-min(count, values.size)])
