"""The fork server: a process that loads what workers need once, and of which each worker is a copy.

A worker of a new interpreter would be ready after two seconds, a copy is ready after milliseconds.
"""

import multiprocessing
import os
from multiprocessing import forkserver
from multiprocessing.context import ForkServerContext

# One BLAS thread per worker: the pool already fills the cores, and small products are slower on several threads. The
# libraries read these variables when they are loaded, so they must be set before numpy is imported.
BLAS_THREADS = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
# Processes that only pass fits on do not load the parts of SciPy that fits alone use: it loads them when they are used.
FITTING = ["scipy.ndimage", "scipy.optimize"]
PRELOAD = ["service.workers.tasks", "service.formats.exports", "service.formats.points.reader", *FITTING]


def context() -> ForkServerContext:
    """Return the context in which workers are started."""
    os.environ.update(dict.fromkeys(BLAS_THREADS, "1"))
    made = multiprocessing.get_context("forkserver")
    made.set_forkserver_preload(PRELOAD)
    return made


def start() -> None:
    """Let the fork server start and load its modules while this process goes on; else it starts with a worker."""
    context()
    forkserver.ensure_running()
