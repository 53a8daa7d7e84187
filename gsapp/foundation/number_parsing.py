"""Numbers in text, as people and devices write them."""

from __future__ import annotations

import math


def parse_finite_number(text: str) -> float | None:
    """Return the number that a text is; NaN for an empty one, None for what is no finite number.

    `float` also takes ``1_000``, and digits of other scripts: neither is meant, and what stands
    for them is damaged.
    """
    try:
        value = float(text)
    except ValueError:
        return None if text and not text.isspace() else math.nan
    return None if math.isinf(value) or "_" in text or not text.isascii() else value
