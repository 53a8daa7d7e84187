"""Values and channels in the words of the checklist."""

from __future__ import annotations

from gsapp.foundation.name_suggestions import format_names
from gsapp.quantities import channel, from_si


def channel_name_text(channel_id: str) -> str:
    """Return the name of a channel inside a sentence: ``left engine speed``."""
    title = channel(channel_id).title
    return title if title[1:2].isupper() else title[0].lower() + title[1:]


def format_channel_value(value: float, channel_id: str, unit: str | None = None) -> str:
    """Return a value with its unit and the digits that its sensor earns.

    Metric where the systems of units differ: the checklist converts its sentences.
    """
    spec = channel(channel_id)
    own = spec.si_display if unit is None or spec.si_display != spec.us_display else unit
    number = from_si(value, own, spec.quantity)
    text = f"{number:.{spec.decimals(own)}f}"
    return f"{text} {own}".rstrip()


def format_list(parts: list[str], most: int = 4) -> str:
    """Return parts as a list in words; of many only the first are named."""
    if len(parts) > most:
        return format_names(parts, most)
    return " and ".join([", ".join(parts[:-1]), parts[-1]]) if len(parts) > 1 else "".join(parts)
