"""What these flights could show at all: sigmas of every effect, and what looks alike."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from gsapp.discrepancy.effect_catalog import all_effects, find_effect
from gsapp.discrepancy.results import Observability
from gsapp.discrepancy.screening import CandidateScreening

_MIN_ALIAS_COSINE = 0.7
_MOST_ALIASES = 4
VISIBLE_SIGMA = 5.0
"""Deviations from which an effect of a usual size counts as one that can be seen."""


def compute_observability(
    screening: CandidateScreening, found: Collection[str]
) -> tuple[Observability, ...]:
    """Return, for every effect of the catalog, what these flights could show of it."""
    rows = []
    ids = [one.id for one in screening.candidates]
    for one in screening.candidates:
        if not one.named:
            continue
        place = screening.index(one.id)
        std = float(screening.std[place])
        sigma = abs(one.plausible_size) / std if np.isfinite(std) else 0.0
        aliases: tuple[tuple[str, float], ...] = ()
        if np.isfinite(std):
            cosines = screening.cosines(one.id)
            table = dict(zip(screening.projected_information.names, cosines, strict=True))
            alike = sorted(
                (
                    (name, float(table[name]))
                    for name in ids
                    if name != one.id
                    and abs(table[name]) > _MIN_ALIAS_COSINE
                    and np.isfinite(screening.std[screening.index(name)])
                ),
                key=lambda pair: -abs(pair[1]),
            )
            aliases = tuple(alike[:_MOST_ALIASES])
        lore = find_effect(one.id)
        fly = lore.separated_by if aliases or sigma < VISIBLE_SIGMA else ""
        rows.append(
            Observability(
                effect=one.id,
                effect_class=lore.effect_class,
                sigma=float(sigma),
                sigma_size=std,
                aliases=aliases,
                fly="" if one.id in found and not aliases else fly,
            )
        )
    rows += [
        Observability(
            effect=one.id, effect_class="C", sigma=0.0, sigma_size=float("inf"), fly=one.remedy
        )
        for one in all_effects()
        if one.effect_class == "C"
    ]
    rows.sort(key=lambda row: -row.sigma)
    return tuple(rows)
