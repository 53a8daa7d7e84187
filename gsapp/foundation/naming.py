"""How a sentence lists names, and helps with one that does not exist."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Sequence


def listed(names: Sequence[str], most: int) -> str:
    """Return names in a row; of many only the first are named, and the others counted.

    Examples
    --------
    >>> listed(["p", "q", "r"], 2)
    'p, q and 1 more'
    """
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return f"{', '.join(names[:most])}{more}"


def did_you_mean(name: str, known: Iterable[str], otherwise: str = "", *, most: int = 3) -> str:
    """Return the question for the nearest names that exist, or other words where none is near.

    Parameters
    ----------
    name : str
        As it was typed.
    known : iterable of str
        What it could have been.
    otherwise : str
        The remedy where no name is near.
    most : int
        How many are named, the nearest first.

    Examples
    --------
    >>> did_you_mean("alhpa", ["alpha", "beta"])
    "did you mean 'alpha'?"
    """
    near = difflib.get_close_matches(name, list(known), n=most)
    return f"did you mean {' or '.join(repr(one) for one in near)}?" if near else otherwise
