"""Which process goes first where there are few cores."""

from __future__ import annotations

import contextlib
import os
import sys

_BELOW_NORMAL = 0x4000  # BELOW_NORMAL_PRIORITY_CLASS


def lower_priority(steps: int) -> None:
    """Let this process yield to others of the user; where that is refused, nothing happens.

    Parameters
    ----------
    steps : int
        By how much, 1 to 19; Windows knows but one step.
    """
    if sys.platform == "win32":
        import ctypes

        kernel = ctypes.WinDLL("kernel32")
        # Else the handle, which is -1, would lose half of its bits.
        kernel.GetCurrentProcess.restype = ctypes.c_void_p
        kernel.SetPriorityClass.argtypes = (ctypes.c_void_p, ctypes.c_uint32)
        kernel.SetPriorityClass(kernel.GetCurrentProcess(), _BELOW_NORMAL)
    else:
        with contextlib.suppress(OSError):
            os.nice(steps)
