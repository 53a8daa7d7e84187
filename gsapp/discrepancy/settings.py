"""What the search for a missing effect is told."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from gsapp.dynamics.model import Model
from gsapp.foundation import GroundStationError


class SearchStoppedError(GroundStationError):
    """The user stopped the search; nothing was written."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DiscrepancySettings:
    """Settings of one search.

    Attributes
    ----------
    model : Model, optional
        The current model, whose values are trusted. Without it the linear build-up is fitted on
        the naming maneuvers.
    held_out : tuple of str, optional
        Ids of maneuvers kept out of naming and fitting; by default one of each kind, about a
        quarter.
    refused : tuple of str
        Effects that the user does not want.
    forced : tuple of str
        Effects put into the model first, in this order, whatever the evidence.
    check_instruments : bool
        Whether instruments are compared by kinematics for the answer, even where the model
        explains the flights: seconds, ten of them with colored noise.
    most_effects : int
        Stops after so many.
    false_alarm : float
        Chance of naming anything where nothing is missing, over all places and candidates.
    """

    model: Model | None = None
    held_out: tuple[str, ...] | None = None
    refused: tuple[str, ...] = ()
    forced: tuple[str, ...] = ()
    check_instruments: bool = False
    most_effects: int = 4
    false_alarm: float = 0.001


@dataclass(frozen=True, slots=True, kw_only=True)
class SearchProgress:
    """How far a search has come: share done (0 to 1) and what it is doing."""

    share: float
    activity: str


SearchProgressCallback = Callable[[SearchProgress], bool | None]
"""Called often; returning False stops the search with `SearchStoppedError`."""
