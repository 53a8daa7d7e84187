"""Ground station for flight-testing remotely piloted research aircraft."""

import os

# Matrices here are small: a second thread of the linear algebra only waits for the first (a fit
# took 4 to 14 times the CPU with two). NumPy reads these when it is first imported; whoever
# wants threads sets them beforehand. The third is that of macOS.
for _name in (
    "OPENBLAS_NUM_THREADS",
    "OMP_NUM_THREADS",
    "VECLIB_MAXIMUM_THREADS",
    "MKL_NUM_THREADS",
):
    os.environ.setdefault(_name, "1")
