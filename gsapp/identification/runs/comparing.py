"""Two kept runs beside each other: what was asked for, and what came of it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Literal

from gsapp.dynamics.buildup import derivative_names
from gsapp.identification.campaign import CampaignValue
from gsapp.identification.runs.keeping import KeptRun
from gsapp.identification.runs.repeating import other_versions
from gsapp.identification.runs.request import RunRequest
from gsapp.identification.runs.words import differing_settings

_FAR = 2.0
"""Joint bounds from which a difference is called one."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DifferingSetting:
    """A setting of two runs in words."""

    name: str
    one: str
    other: str


@dataclass(frozen=True, slots=True, kw_only=True)
class ComparedValue:
    """A derivative of two runs.

    Attributes
    ----------
    name : str
    one, other : CampaignValue or None
        None where the run did not earn it.
    difference : float or None
        Of the means, the other's less the one's.
    in_bounds : float or None
        The difference over the root of the sum of both variances. Runs that share maneuvers share
        their noise as well: they should then differ by less than 1.
    """

    name: str
    one: CampaignValue | None
    other: CampaignValue | None
    difference: float | None = None
    in_bounds: float | None = None

    @property
    def differs(self) -> bool:
        """Return whether the values lie farther apart than their bounds allow, or one is not."""
        if self.in_bounds is None:
            return True
        return abs(self.in_bounds) > _FAR


@dataclass(frozen=True, slots=True, kw_only=True)
class Comparison:
    """Two runs beside each other.

    Attributes
    ----------
    one, other : str
        Their names.
    settings : tuple of DifferingSetting
        Those that differ, flights and maneuvers among them.
    values : tuple of ComparedValue
        In the order of the build-up.
    versions : tuple of str
        What differs, in words.
    """

    one: str
    other: str
    settings: tuple[DifferingSetting, ...]
    values: tuple[ComparedValue, ...]
    versions: tuple[str, ...] = ()


def compare(
    one: KeptRun, other: KeptRun, *, means: Literal["values", "campaign"] = "values"
) -> Comparison:
    """Return two runs beside each other.

    Parameters
    ----------
    one, other : KeptRun
    means : {"values", "campaign"}
        Which of their means.

    Raises
    ------
    FlightError
        If what one of them was asked for cannot be read.
    """
    asked = one.request, other.request
    order = {name: place for place, name in enumerate(derivative_names())}
    ones: Mapping[str, CampaignValue] = getattr(one, means)
    others: Mapping[str, CampaignValue] = getattr(other, means)
    names = sorted({*ones, *others}, key=lambda name: (order.get(name, len(order)), name))
    return Comparison(
        one=one.name,
        other=other.name if other.name != one.name else f"{other.name} ({other.number})",
        settings=(
            *(
                DifferingSetting(name=name, one=first, other=second)
                for name, first, second in differing_settings(*asked)
            ),
            *_other_flights(one, other),
            *_other_maneuvers(*asked),
        ),
        values=tuple(_compared(name, ones, others) for name in names),
        versions=tuple(other_versions(one.versions, other.versions)),
    )


def _compared(
    name: str, ones: Mapping[str, CampaignValue], others: Mapping[str, CampaignValue]
) -> ComparedValue:
    one, other = ones.get(name), others.get(name)
    if one is None or other is None:
        return ComparedValue(name=name, one=one, other=other)
    difference = other.mean - one.mean
    bound = math.hypot(one.std, other.std)
    return ComparedValue(
        name=name,
        one=one,
        other=other,
        difference=difference,
        in_bounds=difference / bound if bound > 0.0 else None,
    )


def _other_flights(one: KeptRun, other: KeptRun) -> Iterator[DifferingSetting]:
    if one.flights != other.flights:
        yield DifferingSetting(
            name="flights", one=", ".join(one.flights), other=", ".join(other.flights)
        )
    sums = {file.name: file.sha256 for file in one.inputs if file.role == "flight"}
    for file in other.inputs:
        if sums.get(file.name, file.sha256) != file.sha256:
            yield DifferingSetting(name=file.name, one="as it was then", other="changed since")


def _other_maneuvers(one: RunRequest, other: RunRequest) -> Iterator[DifferingSetting]:
    edges = [
        {
            (chosen.flight.name, chosen.id): f"{chosen.t_start:.2f} to {chosen.t_end:.2f} s"
            for chosen in request.maneuvers
        }
        for request in (one, other)
    ]
    for key in dict.fromkeys((*edges[0], *edges[1])):
        first, second = (own.get(key, "not used") for own in edges)
        if first != second:
            yield DifferingSetting(name=f"maneuver {key[1]} of {key[0]}", one=first, other=second)
