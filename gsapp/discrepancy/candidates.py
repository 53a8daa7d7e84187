"""Candidates as columns: what each effect, and structure without a name, would change.

At its neutral value an effect adds one history to a coefficient, a control or a channel. Effects
that are not linear in their size (play, end stops) are taken at a finite one.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import combinations_with_replacement

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.discrepancy.catalog import EffectRecord
from gsapp.discrepancy.filtering.columns import Column, Entry
from gsapp.discrepancy.filtering.linearizing import Linearization
from gsapp.dynamics.flight_model import INPUTS
from gsapp.dynamics.signals import (
    SURFACES,
    Backlash,
    Bias,
    Delay,
    Lag,
    RateLimit,
    Saturation,
    Scale,
    SignalTerm,
    channels_of,
    lagged,
)
from gsapp.dynamics.terms import COEFFICIENTS, Term, make_term
from gsapp.quantities import FloatArray

Maker = Callable[[Linearization], Column | None]
_MEMORY = 0.15
"""Time constant of lags without a name, s."""
_AXES = {"CX": ("CA", -1.0), "CZ": ("CN", -1.0)}
_LOADS = {
    "X": ("CA", -1.0, ""),
    "thrust": ("CA", -1.0, ""),
    "Y": ("CY", 1.0, ""),
    "Z": ("CN", -1.0, ""),
    "L": ("Cl", 1.0, "span"),
    "M": ("Cm", 1.0, "chord"),
    "N": ("Cn", 1.0, "span"),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Competitor:
    """One competitor for the place of the missing effect.

    Attributes
    ----------
    id : str
        Of the catalog, or ``unnamed.<coefficient>.<terms>``.
    title : str
    named : bool
        Whether the catalog explains it.
    parameter : str
        Whose size the column belongs to; empty without a name.
    plausible : float
        A usual size, as a difference from neutral.
    neutral : float
    low, high : float
        Bounds of the size, as differences from neutral.
    start : callable or None
        Where a size cannot be had from the column (end stops): takes the linearizations of all
        maneuvers, returns the parameter to start from.
    make : callable
        Takes a `Linearization`, returns its column, or None where it cannot act.
    """

    id: str
    title: str
    named: bool
    parameter: str
    plausible: float
    neutral: float
    low: float = -np.inf
    high: float = np.inf
    make: Maker
    start: Callable[[Sequence[Linearization]], float] | None = None


def named_competitors(
    records: Sequence[EffectRecord], aircraft: Aircraft
) -> tuple[Competitor, ...]:
    """Return the competitors for effects of the catalog that can be made a column."""
    found = []
    for record in records:
        term = make_term(record.id, aircraft)
        maker = _maker(term, aircraft)
        free = [item for item in term.parameters if item.free]
        if maker is None or not free:
            continue
        item = free[0]
        found.append(
            Competitor(
                id=record.id,
                title=record.title,
                named=not record.decoy,
                parameter=item.name,
                plausible=item.default - item.neutral,
                neutral=item.neutral,
                low=item.bounds[0] - item.neutral,
                high=item.bounds[1] - item.neutral,
                make=maker,
                start=_start(term),
            )
        )
    return tuple(found)


def _maker(term: Term, aircraft: Aircraft) -> Maker | None:
    if term.target.startswith("control."):
        return _control_maker(term)
    if term.target.startswith("sensor."):
        return _sensor_maker(term)
    if term.target in COEFFICIENTS or term.target in _AXES or term.target in _LOADS:
        return _equation_maker(term, aircraft)
    return None


def _equation_maker(term: Term, aircraft: Aircraft) -> Maker:
    index = next((k for k, item in enumerate(term.parameters) if item.free), 0)
    neutral = [item.neutral for item in term.parameters]

    def make(found: Linearization) -> Column | None:
        reads = [found.variables[name] for name in term.reads]
        states: tuple[FloatArray, ...] = ()
        if term.states:
            taus = [item.default for item in term.parameters if item.name in ("tau", "lag")]
            states = tuple(
                lagged(reads[0], taus[0] if taus else _MEMORY, found.record.dt) for _ in term.states
            )
        history = np.broadcast_to(
            np.asarray(term.jacobian(reads, states, neutral).parameters[index], dtype=float),
            (len(found.record),),
        )
        entries = [coefficient_entry(term.target, history, found, aircraft)]
        if term.target == "thrust":
            # It acts at the engines: below the center of gravity it pitches.
            height = float(np.mean([z for _, _, z in aircraft.propulsion.position]))
            entries.append(coefficient_entry("M", height * history, found, aircraft))
        return tuple(entries)

    return make


def coefficient_entry(
    target: str, history: FloatArray, found: Linearization, aircraft: Aircraft
) -> Entry:
    """Return what adds to a coefficient, force or moment as an entry of a coefficient."""
    if target in COEFFICIENTS:
        return Entry(place=target, history=history)
    if target in _AXES:
        place, sign = _AXES[target]
        return Entry(place=place, history=sign * history)
    place, sign, arm = _LOADS[target]
    geometry = aircraft.geometry
    size = found.variables["qbar"] * geometry.wing_area
    length = geometry.span if arm == "span" else geometry.chord if arm == "chord" else 1.0
    return Entry(place=place, history=sign * history / (size * length))


def _control_maker(term: Term) -> Maker | None:
    channel = SURFACES[term.target.partition(".")[2]]
    if not isinstance(term, SignalTerm):
        return None

    def make(found: Linearization) -> Column | None:
        signal = found.inputs[INPUTS.index(channel)]
        dt = found.record.dt
        if isinstance(term, Lag | Delay):
            change = -np.gradient(signal, dt)
        elif isinstance(term, Scale):
            change = signal
        else:
            size = finite_size(term, signal, dt)
            change = term.respond(signal, dt, (size,)).values - signal
            if isinstance(term, Backlash):
                change = change / size
        if not np.any(change):
            return None
        return (Entry(place=channel, history=change),)

    return make


def _start(term: Term) -> Callable[[Sequence[Linearization]], float] | None:
    if not isinstance(term, Saturation | RateLimit) or not term.target.startswith("control."):
        return None
    channel = SURFACES[term.target.partition(".")[2]]

    def start(found: Sequence[Linearization]) -> float:
        row = INPUTS.index(channel)
        return max(finite_size(term, one.inputs[row], one.record.dt) for one in found)

    return start


def finite_size(term: SignalTerm, signal: FloatArray, dt: float) -> float:
    """Return the size at which an effect that is not linear in it is tried."""
    if isinstance(term, Saturation):
        # The column is then the whole effect: its size is 1.
        return 0.85 * float(np.abs(signal).max())
    if isinstance(term, RateLimit):
        return 0.7 * float(np.abs(np.gradient(signal, dt)).max())
    return term.parameters[0].default


def _sensor_maker(term: Term) -> Maker | None:
    name = term.target.partition(".")[2]
    channels = channels_of(name)
    if not isinstance(term, Lag | Delay | Scale | Bias):
        return None

    def make(found: Linearization) -> Column | None:
        entries = []
        for channel in channels:
            if channel in ("de", "da", "dr", "flap"):
                if isinstance(term, Lag | Delay):
                    signal = found.inputs[INPUTS.index(channel)]
                    # What was recorded late came earlier.
                    change = np.gradient(signal, found.record.dt)
                    entries.append(Entry(place=channel, history=change))
                continue
            if channel not in found.record.channels:
                continue
            column = found.record.channels.index(channel)
            if isinstance(term, Lag | Delay):
                history = -found.output_rates[:, column]
            elif isinstance(term, Scale):
                history = found.computed[:, column]
            else:
                history = np.ones(len(found.record))
            entries.append(Entry(place=f"channel.{channel}", history=history))
        return tuple(entries) or None

    return make


# --- structure without a name -------------------------------------------------------------------

_LONGITUDINAL = ("alpha", "q_hat", "de", "v")
_LATERAL = ("beta", "p_hat", "r_hat", "da", "dr")
_CUBES = (
    ("alpha",) * 3,
    ("alpha", "alpha", "q_hat"),
    ("alpha", "alpha", "de"),
    ("alpha", "de", "de"),
    ("de", "de", "de"),
    ("alpha", "beta", "beta"),
    ("alpha", "q_hat", "de"),
)


def unnamed_competitors(
    named: Sequence[Competitor], *, throttle: bool, flap: bool
) -> tuple[Competitor, ...]:
    """Return products of states and inputs, and lags, that no effect of the catalog explains."""
    taken = {_sorted_name(one.id.partition(".")[2]) for one in named}
    found = []
    for target in COEFFICIENTS:
        lateral = target in ("CY", "Cl", "Cn")
        for factors in _products(lateral, throttle=throttle, flap=flap):
            name = _product_name(factors)
            if _sorted_name(f"{target}.{name}") not in taken:
                found.append(_unnamed(target, name, factors))
        found += [
            _memory(target, variable)
            for variable in (("beta", "da", "dr") if lateral else ("alpha", "de"))
            if f"{target}.memory" not in taken or variable != "alpha"
        ]
    return tuple(found)


def _products(lateral: bool, *, throttle: bool, flap: bool) -> list[tuple[str, ...]]:
    more = (*(("throttle",) if throttle else ()), *(("flap",) if flap else ()))
    out: list[tuple[str, ...]] = []
    if lateral:
        out += [(one, other) for one in _LATERAL for other in (*_LONGITUDINAL, *more)]
        out += [(one,) * 3 for one in _LATERAL]
        out += [("alpha", "alpha", one) for one in _LATERAL]
        out += [("beta", "beta", one) for one in _LATERAL[1:]]
        out += [("|beta|", one) for one in _LATERAL]
        return out
    out += list(combinations_with_replacement(_LONGITUDINAL, 2))
    out += list(combinations_with_replacement(_LATERAL, 2))
    out += [("|beta|",), *_CUBES]
    out += [(one, other) for one in more for other in _LONGITUDINAL]
    return out


def _sorted_name(name: str) -> str:
    """Return a name by which products compare whatever the order of their factors."""
    target, _, factors = name.partition(".")
    return f"{target}.{'_'.join(sorted(factors.split('_')))}"


def _product_name(factors: tuple[str, ...]) -> str:
    words = []
    for factor in dict.fromkeys(factors):
        power = factors.count(factor)
        plain = factor.removesuffix("_hat").replace("|beta|", "absbeta").replace("v", "V")
        words.append(plain if power == 1 else f"{plain}{power}")
    return "_".join(words)


def _read(found: Linearization, factor: str) -> FloatArray:
    if factor == "v":
        V = found.variables["V"]
        return V / 28.956 - 1.0
    if factor == "|beta|":
        return np.abs(found.variables["beta"])
    return found.variables[factor]


def _unnamed(target: str, name: str, factors: tuple[str, ...]) -> Competitor:
    def make(found: Linearization) -> Column:
        history = np.ones(len(found.record))
        for factor in factors:
            history = history * _read(found, factor)
        return (Entry(place=target, history=history),)

    words = " * ".join(factor.removesuffix("_hat") for factor in factors)
    return Competitor(
        id=f"unnamed.{target}.{name}",
        title=f"{target} needs {words}; no effect of the catalog does that",
        named=False,
        parameter="",
        plausible=1.0,
        neutral=0.0,
        make=make,
    )


def _memory(target: str, variable: str) -> Competitor:
    def make(found: Linearization) -> Column:
        signal = found.variables[variable]
        late = signal - lagged(signal, _MEMORY, found.record.dt)
        return (Entry(place=target, history=late),)

    return Competitor(
        id=f"unnamed.{target}.late_{variable}",
        title=f"{target} follows {variable} late; no effect of the catalog does that",
        named=False,
        parameter="",
        plausible=1.0,
        neutral=0.0,
        make=make,
    )
