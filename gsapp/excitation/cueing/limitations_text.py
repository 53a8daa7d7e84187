"""What can be judged in a flight, by what, and what cannot and why: in words."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from gsapp.aircraft import Aircraft
from gsapp.dynamics.model import Model
from gsapp.excitation.alerts.alert import Alert
from gsapp.excitation.information.outlook import Outlook
from gsapp.excitation.trim.trim_cue import TrimCue
from gsapp.identification.compatibility.results import join_names
from gsapp.quantities import SURFACE_NAMES, channel

NO_AIRCRAFT = "no aircraft file: stall, sensor ranges and stick shares are not known"
NO_MODEL = "no model: inputs are judged by the card and by their shape, bounds are not predicted"
NO_CARDS = "no test cards: any speed is a test point"


def list_limitations(
    aircraft: Aircraft | None,
    model: Model | None,
    *,
    has_cards: bool,
    trim: TrimCue | None,
    dangers: Sequence[Alert] = (),
    outlook: Outlook | None = None,
    unseen: Sequence[str] = (),
) -> tuple[str, ...]:
    """Return what cannot be judged, the gravest first.

    Parameters
    ----------
    has_cards : bool
        Whether there are test cards.
    dangers : sequence of Alert
        Their channels are not believed.
    outlook : Outlook or None
        Says what stands in for what is not known.
    unseen : sequence of str
        Surfaces that nothing shows.
    """
    found: list[str] = []
    doubted = dict.fromkeys(name for danger in dangers for name in danger.channels)
    if doubted:
        found.append(f"ignored: {', '.join(channel(name).title for name in doubted)}")
    if unseen:
        words = join_names([SURFACE_NAMES[name] for name in unseen])
        found.append(f"inputs of {words}: the surface is not measured")
    found += [] if trim is None else trim.limitations
    found += [NO_AIRCRAFT] if aircraft is None else []
    found += [NO_MODEL] if model is None else []
    found += [] if has_cards else [NO_CARDS]
    found += [] if outlook is None else outlook.remarks
    return _without_duplicates(found)


def _without_duplicates(words: Iterable[str]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(words))
