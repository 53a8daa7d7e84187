"""Memory that stays with the process between many short-lived arrays."""

from __future__ import annotations

from functools import cache

import numpy as np

_MAX_ARRAY_SIZE = 31 * 2**20


@cache
def retain_freed_memory() -> None:
    """Let freed arrays up to 31 MB be used again instead of going back to the system.

    The allocator of Linux fetches every array above 128 kB anew from the system, page by page,
    which takes as long as filling it. Once a larger one has been freed it keeps all below that
    size. Elsewhere this does nothing.
    """
    block = np.empty(_MAX_ARRAY_SIZE, dtype=np.uint8)
    del block
