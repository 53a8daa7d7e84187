"""Start of a standalone build: the commands, and ``-P -m MODULE`` for processes of the program."""

import multiprocessing
import os
import runpy
import sys

if __name__ == "__main__":
    # As `bootstrap.py` does: several processes work side by side.
    for variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "VECLIB_MAXIMUM_THREADS"):
        os.environ.setdefault(variable, "1")
    multiprocessing.freeze_support()
    if sys.argv[1:3] == ["-P", "-m"]:
        module = sys.argv[3]
        del sys.argv[1:4]
        runpy.run_module(module, run_name="__main__", alter_sys=True)
    else:
        from gsapp.cli import run_program

        run_program()
