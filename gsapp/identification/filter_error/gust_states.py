"""Gusts among the states of the filter: along the axes and, where asked for, about them.

Gusts along x, y, z are first order, the white noise behind them entering airspeed or flow angle,
too. Rotation of the air follows MIL-F-8785C, section 3.7.2: roll is a first-order process of its
own with the time constant 4b/(pi V); pitch and yaw are the gradients of vertical and side gusts,

    q_g = -w_g'/V / (1 + 4b/(pi V) s),     r_g = v_g'/V / (1 + 3b/(pi V) s).

They, too, have noise of their own: other simulations than the standard's make them independent.
Forces and moments, and vanes away from the CG, feel p - p_g, q - q_g and r - r_g; gyros show p, q
and r.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gsapp.identification.filter_error.noise_model import (
    GUSTS,
    ROTATIONS,
    NoiseModel,
)
from gsapp.identification.filter_error.settings import FILTER_ERROR
from gsapp.quantities import FloatArray

GUST_TARGETS = dict(zip(GUSTS, ("V", "beta", "alpha"), strict=True))
"""States that gusts along x, y, z enter."""
MOMENT_TARGETS = ("p", "q", "r")
"""States that unmeasured moments enter."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GustStates:
    """The gusts that a filter follows, behind the states of the equations.

    Gusts along x, y, z are in the units of the states that they enter (u in m/s, v and w in rad, as
    -w_g/V): what flows past the aircraft. Rotation is in rad/s.
    """

    names: tuple[str, ...]  # ``u``, ``v``, ``w``, ``p``, ``q``, ``r``: those of the states.
    rows: tuple[int, ...]  # States of the equations that the gusts along x, y, z enter.
    rates: FloatArray  # Shape (n_gusts, n_gusts). Their derivatives by themselves, 1/s.
    rotation: FloatArray  # Shape (3, n_gusts). p_g, q_g, r_g (rad/s) by them.
    scales: FloatArray  # Shape (n_gusts,). Sizes that make them comparable.
    entries: FloatArray
    """Shape (n_gusts, n_states + n_gusts). What noise of 1 m/s^2 (rotation: 1 rad/s^2) behind each
    adds to all rates."""

    @property
    def count(self) -> int:
        return len(self.scales)

    @property
    def is_rotational(self) -> bool:
        return bool(self.rotation.any())

    @classmethod
    def create(
        cls,
        states: Sequence[str],
        n_states: int,
        V: float,
        span: float,
        noise: NoiseModel | None,
    ) -> GustStates:
        """Return the gusts that enter some of the states.

        Parameters
        ----------
        states : sequence of str
            Polar states that are integrated; the first of `n_states`.
        V : float
            Mean airspeed, m/s.
        span : float
            m.
        noise : NoiseModel or None
            Scale lengths, and whether the air rotates. Without it gusts stay as they are.
        """
        along = [name for name in GUSTS if GUST_TARGETS[name] in states]
        names = list(along)
        if noise is not None and noise.rotation_intensities is not None:
            names += [name for name in ROTATIONS if name in states]
        count = len(names)
        rates, rotation = np.zeros((count, count)), np.zeros((3, count))
        entries = np.zeros((count, n_states + count))
        for index, name in enumerate(names):
            own = n_states + index
            if name in along:
                size = 1.0 if name == "u" else 1.0 / V
                entries[index, states.index(GUST_TARGETS[name])] = entries[index, own] = size
                if noise is not None:
                    rates[index, index] = -V / noise.gust_lengths[GUSTS.index(name)]
                continue
            if noise is None:  # No air that rotates.
                continue
            entries[index, own] = rotation[ROTATIONS.index(name), index] = 1.0
            bandwidth = noise.rotation_rate(name, V, span)
            rates[index, index] = -bandwidth
            source = {"q": "w", "r": "v"}.get(name)
            if source in along:
                # Gusts are what flows past, -w_g/V: q_g follows their rate, r_g minus it.
                pitch, yaw = noise.gradient_gains
                gain, row = bandwidth * (pitch if name == "q" else -yaw), names.index(source)
                rates[index, row] = gain * rates[row, row]
                entries[row, own] = gain * entries[row, n_states + row]
        sizes = dict(zip(GUSTS, FILTER_ERROR.gust_scales, strict=True))
        return cls(
            names=tuple(names),
            rows=tuple(states.index(GUST_TARGETS[name]) for name in along),
            rates=rates,
            rotation=rotation,
            scales=np.array([sizes.get(name, FILTER_ERROR.rotation_scale) for name in names]),
            entries=entries,
        )
