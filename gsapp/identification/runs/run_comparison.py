"""Two kept runs beside each other: what was asked for, and what came of it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Literal

from gsapp.dynamics.buildup import derivative_names
from gsapp.identification.campaign import CampaignValue
from gsapp.identification.runs.request import RunRequest
from gsapp.identification.runs.run_repetition import version_differences
from gsapp.identification.runs.run_store import StoredRun
from gsapp.identification.runs.settings_text import setting_differences
from gsapp.identification.summary.settings import SUMMARY


@dataclass(frozen=True, slots=True, kw_only=True)
class SettingDifference:
    """A setting of two runs in words."""

    name: str
    one: str
    other: str


@dataclass(frozen=True, slots=True, kw_only=True)
class ValueDifference:
    """A derivative of two runs."""

    name: str
    one: CampaignValue | None
    other: CampaignValue | None
    """None where the run did not earn it."""
    difference: float | None = None  # Of the means, the other's less the one's.
    in_bounds: float | None = None
    """The difference over the root of the sum of both variances. Runs that share maneuvers share
    their noise as well: they should then differ by less than 1."""

    @property
    def differs(self) -> bool:
        """Return whether the values lie farther apart than their bounds allow, or one is not."""
        if self.in_bounds is None:
            return True
        return abs(self.in_bounds) > SUMMARY.significant_sigmas


@dataclass(frozen=True, slots=True, kw_only=True)
class RunComparison:
    """Two runs beside each other."""

    one: str
    other: str
    """Their names."""
    settings: tuple[SettingDifference, ...]  # Those that differ, flights and maneuvers among them.
    values: tuple[ValueDifference, ...]  # In the order of the build-up.
    versions: tuple[str, ...] = ()  # What differs, in words.


def compare_runs(
    one: StoredRun, other: StoredRun, *, means: Literal["values", "campaign"] = "values"
) -> RunComparison:
    """Return two runs beside each other.

    `means`: which of their means.

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
    return RunComparison(
        one=one.name,
        other=other.name if other.name != one.name else f"{other.name} ({other.number})",
        settings=(
            *(
                SettingDifference(name=name, one=first, other=second)
                for name, first, second in setting_differences(*asked)
            ),
            *_flight_differences(one, other),
            *_maneuver_differences(*asked),
        ),
        values=tuple(_compare_value(name, ones, others) for name in names),
        versions=tuple(version_differences(one.versions, other.versions)),
    )


def _compare_value(
    name: str, ones: Mapping[str, CampaignValue], others: Mapping[str, CampaignValue]
) -> ValueDifference:
    one, other = ones.get(name), others.get(name)
    if one is None or other is None:
        return ValueDifference(name=name, one=one, other=other)
    difference = other.mean - one.mean
    bound = math.hypot(one.std, other.std)
    return ValueDifference(
        name=name,
        one=one,
        other=other,
        difference=difference,
        in_bounds=difference / bound if bound > 0.0 else None,
    )


def _flight_differences(one: StoredRun, other: StoredRun) -> Iterator[SettingDifference]:
    if one.flights != other.flights:
        yield SettingDifference(
            name="flights", one=", ".join(one.flights), other=", ".join(other.flights)
        )
    sums = {file.name: file.sha256 for file in one.inputs if file.role == "flight"}
    for file in other.inputs:
        if sums.get(file.name, file.sha256) != file.sha256:
            yield SettingDifference(name=file.name, one="unchanged", other="changed since")


def _maneuver_differences(one: RunRequest, other: RunRequest) -> Iterator[SettingDifference]:
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
            yield SettingDifference(name=f"maneuver {key[1]} of {key[0]}", one=first, other=second)
