"""Processes that work in the background yield to the window."""

import os
import subprocess
import sys

import pytest


@pytest.mark.skipif(not hasattr(os, "nice"), reason="read where the system tells it by a number")
def test_a_process_that_stands_back_yields_to_others() -> None:
    code = (
        "import os; from gsapp.foundation.process_control import lower_priority\n"
        "before = os.nice(0); lower_priority(3); print(min(before + 3, 19) == os.nice(0))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.stdout.split() == ["True"], done.stderr
