"""Values on the screen with as many digits as their bounds earn."""

from __future__ import annotations


def bounded(value: float, std: float, least: int = 4) -> tuple[str, str]:
    """Return a value and its bound: never a bound of zero for one that is small.

    Parameters
    ----------
    value, std : float
    least : int
        Digits after the point, so that columns of usual values stand in line.
    """
    from gsapp.report.estimate_words import decimals

    digits = max(least, decimals(std))
    return f"{value:z.{digits}f}", f"{std:.{digits}f}"
