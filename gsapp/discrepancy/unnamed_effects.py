"""Structure without a name, as columns: products of states and inputs, lags, modes.

They compete so that what is in no catalog is not given the name of what is.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations_with_replacement

import numpy as np
from scipy.signal import lfilter

from gsapp.discrepancy.candidates import CandidateEffect, ColumnBuilder
from gsapp.discrepancy.settings import SEARCH
from gsapp.dynamics.buildup import LATERAL_COEFFICIENTS
from gsapp.dynamics.signal_terms import apply_lag
from gsapp.dynamics.terms import COEFFICIENTS
from gsapp.identification.filter_error.maneuver_state import (
    SensitivityColumn,
    SensitivityEntry,
)
from gsapp.identification.filter_error.motion_linearization import Linearization
from gsapp.quantities import FloatArray

_LONGITUDINAL = ("alpha", "q_hat", "de", "v")
_LATERAL = ("beta", "p_hat", "r_hat", "da", "dr")
_CUBIC_TERMS = (
    ("alpha",) * 3,
    ("alpha", "alpha", "q_hat"),
    ("alpha", "alpha", "de"),
    ("alpha", "de", "de"),
    ("de", "de", "de"),
    ("alpha", "beta", "beta"),
    ("alpha", "q_hat", "de"),
)
VIBRATING_CHANNELS = ("ax", "ay", "an")
"""Instruments that the structure shakes."""


def unnamed_candidates(
    named: Sequence[CandidateEffect], *, throttle: bool, flap: bool
) -> tuple[CandidateEffect, ...]:
    """Return products of states and inputs, and lags, that no effect of the catalog explains."""
    taken = {_sorted_name(one.id.partition(".")[2]) for one in named}
    found = []
    for target in COEFFICIENTS:
        lateral = target in LATERAL_COEFFICIENTS
        for factors in _products(lateral, throttle=throttle, flap=flap):
            name = _product_name(factors)
            if _sorted_name(f"{target}.{name}") not in taken:
                found.append(_product_candidate(target, name, factors))
        found += [
            _lag_candidate(target, variable, has_present=True)
            for variable in (("beta", "da", "dr") if lateral else ("alpha", "de"))
            if f"{target}.memory" not in taken or variable != "alpha"
        ]
        found += [
            _lag_candidate(target, variable, has_present=False)
            for variable in (("alpha", "q_hat", "de") if lateral else _LATERAL)
        ]
    found += [
        _structural_mode_candidate(channel, mode)
        for channel in VIBRATING_CHANNELS
        for mode in SEARCH.mode_frequencies
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
        out += [(f"|{one}|", one) for one in _LATERAL[1:]]
        return out
    out += list(combinations_with_replacement(_LONGITUDINAL, 2))
    out += list(combinations_with_replacement(_LATERAL, 2))
    out += [("|beta|",), ("|q_hat|", "q_hat"), ("|de|", "de"), *_CUBIC_TERMS]
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
        size = factor.strip("|").removesuffix("_hat").replace("v", "V")
        plain = f"abs{size}" if factor.startswith("|") else size
        words.append(plain if power == 1 else f"{plain}{power}")
    return "_".join(words)


def _read(found: Linearization, factor: str) -> FloatArray:
    if factor == "v":
        V = found.variables["V"]
        return V / 28.956 - 1.0
    if factor.startswith("|"):
        return np.abs(found.variables[factor.strip("|")])
    return found.variables[factor]


def _unnamed_candidate(place: str, words: str, make: ColumnBuilder) -> CandidateEffect:
    """Return the competitor for what the catalog does not hold."""
    return CandidateEffect(
        id=f"unnamed.{place}",
        title=f"{words}; no catalog effect does that",
        named=False,
        parameter="",
        plausible_size=1.0,
        neutral=0.0,
        build_column=make,
    )


def _product_candidate(target: str, name: str, factors: tuple[str, ...]) -> CandidateEffect:
    def make(found: Linearization) -> SensitivityColumn:
        history = np.ones(len(found.record))
        for factor in factors:
            history = history * _read(found, factor)
        return (SensitivityEntry(target=target, history=history),)

    words = " * ".join(factor.replace("_hat", "") for factor in factors)
    return _unnamed_candidate(f"{target}.{name}", f"{target} needs {words}", make)


def _lag_candidate(target: str, variable: str, *, has_present: bool) -> CandidateEffect:
    """Return what follows a variable late, by what it has of the variable as it is."""

    def make(found: Linearization) -> SensitivityColumn:
        signal = found.variables[variable]
        late = apply_lag(signal, SEARCH.trial_time_constant, found.record.dt)
        return (SensitivityEntry(target=target, history=signal - late if has_present else late),)

    name = variable.removesuffix("_hat")
    return _unnamed_candidate(f"{target}.late_{name}", f"{target} follows {name} late", make)


def _structural_mode_candidate(channel: str, frequency: float) -> CandidateEffect:
    def make(found: Linearization) -> SensitivityColumn | None:
        if channel not in found.record.channels:
            return None
        felt = found.computed[:, found.record.channels.index(channel)]
        history = _mode_response(felt - felt[0], frequency, found.record.dt)
        return (SensitivityEntry(target=f"channel.{channel}", history=history),)

    words = f"{channel} rings at about {frequency:g} Hz, like a flexible structure"
    return _unnamed_candidate(f"{channel}.mode{frequency:g}", words, make)


def _mode_response(signal: FloatArray, frequency: float, dt: float) -> FloatArray:
    """Return what a lightly damped mode adds that changes of a signal shake, at rest before."""
    omega = 2.0 * np.pi * frequency
    pole = np.exp(complex(-SEARCH.mode_damping, np.sqrt(1.0 - SEARCH.mode_damping**2)) * omega * dt)
    return np.asarray(
        lfilter(np.array([1.0, -1.0]) * omega * dt, [1.0, -2.0 * pole.real, abs(pole) ** 2], signal)
    )
