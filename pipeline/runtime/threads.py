"""Import first: one thread for every numeric library of this process, whatever the environment says.

The number of threads changes the order of sums, and with it the last bits of results. Libraries read these variables
when they are loaded, so that this module comes before any of them.
"""

import os

ONE_THREAD = dict.fromkeys(
    (
        "OMP_NUM_THREADS",
        "OPENBLAS_NUM_THREADS",
        "MKL_NUM_THREADS",
        "NUMBA_NUM_THREADS",
        "VECLIB_MAXIMUM_THREADS",
        "NUMEXPR_NUM_THREADS",
    ),
    "1",
)

os.environ.update(ONE_THREAD)
