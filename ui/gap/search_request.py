"""What a search is asked for, and what comes back. No Qt."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from gsapp.discrepancy.settings import DiscrepancySettings
from ui.translation import tr

if TYPE_CHECKING:
    # The window starts without the numerics behind a result.
    from gsapp.discrepancy.results import DiscrepancyResult


class GapRequest(DiscrepancySettings):
    """Flights to search, and the settings, with what the crew decided about effects."""

    flights: tuple[Path, ...]
    check_instruments: bool = True

    @property
    def text(self) -> str:
        """Return what is searched: ``flight 3 and 2 more · model b777``."""
        names = [path.name for path in self.flights]
        more = tr(" and {count} more").format(count=len(names) - 1) if len(names) > 1 else ""
        model = (
            tr("model {stem}").format(stem=Path(self.model).stem)
            if self.model
            else tr("baseline fitted here")
        )
        return f"{names[0]}{more} · {model}" if names else model

    @property
    def undecided(self) -> GapRequest:
        return self.with_changes(refused=(), forced=())

    def refuse(self, effect: str) -> GapRequest:
        """Return the request with that effect refused, and no longer forced."""
        kept = tuple(known for known in self.forced if known != effect)
        others = tuple(known for known in self.refused if known != effect)
        return self.with_changes(refused=(*others, effect), forced=kept)

    def force(self, effect: str) -> GapRequest:
        """Return the request with that effect forced, and no longer refused."""
        kept = tuple(known for known in self.refused if known != effect)
        others = tuple(known for known in self.forced if known != effect)
        return self.with_changes(refused=kept, forced=(*others, effect))


@dataclass(frozen=True, slots=True, kw_only=True)
class EffectInfo:
    """What the catalog says of an effect."""

    effect: str
    title: str
    equation: str = ""
    mistaken_for: tuple[str, ...] = ()
    """Ids of effects that it is taken for, or words."""
    distinguished_by: str = ""
    remedy: str = ""
    """The measurement on the ground that settles it; empty where flying does."""
    units: Mapping[str, str]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SearchResult:
    """What a search gave."""

    request: GapRequest
    discrepancy: DiscrepancyResult
    effect_infos: Mapping[str, EffectInfo]
    remarks: tuple[str, ...] = ()
    """About the flights: maneuvers left out, channels missing."""
    kinds: Mapping[str, str] = field(default_factory=dict)
    """Surfaces and shape of each maneuver, ``de doublet``, by its id."""
    aircraft: str = ""

    def continues(self, former: SearchResult) -> bool:
        """Return whether only decisions lie between a former answer and this one."""
        return self.request.undecided == former.request.undecided

    def title(self, effect: str) -> str:
        """Return an effect in a field engineer's words; its id where nobody knows any."""
        note = self.effect_infos.get(effect)
        if note is not None and note.title:
            return note.title
        for found in self.discrepancy.effects:
            if found.effect == effect:
                return found.title
        for step in self.discrepancy.steps:
            for candidate in step.ranking:
                if candidate.effect == effect:
                    return candidate.title
        return effect
