"""How a sentence lists names, and helps with one that does not exist."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Sequence


def format_names(names: Sequence[str], most: int) -> str:
    """Return names in a row; of many only the first are named, and the others counted.

    Examples
    --------
    >>> format_names(["p", "q", "r"], 2)
    'p, q and 1 more'
    """
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return f"{', '.join(names[:most])}{more}"


def join_names(names: Sequence[str]) -> str:
    """Return ``a``, ``a and b``, or ``a, b and c``."""
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def did_you_mean(name: str, known: Iterable[str], otherwise: str = "", *, most: int = 3) -> str:
    """Return the question for the nearest names, `most` at most, or other words where none is near.

    Examples
    --------
    >>> did_you_mean("alhpa", ["alpha", "beta"])
    "did you mean 'alpha'?"
    """
    *others, last = [repr(one) for one in close_matches(name, known, most=most)] or [""]
    if not last:
        return otherwise
    return f"did you mean {', '.join(others)}{' or ' if others else ''}{last}?"


def close_matches(
    name: str, known: Iterable[str], *, most: int = 3, cutoff: float = 0.6
) -> list[str]:
    """Return the names that are most like one that was typed, in whatever case; the best first.

    For `cutoff`, how like, from 0 to 1, see `difflib.get_close_matches`.
    """
    of_plain: dict[str, list[str]] = {}
    for one in known:
        of_plain.setdefault(one.casefold(), []).append(one)
    near = difflib.get_close_matches(name.casefold(), of_plain, n=most, cutoff=cutoff)
    return [one for plain in near for one in of_plain[plain]][:most]
