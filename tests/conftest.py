"""Tests start programs and interrupt them: they must hear it."""

import os
import signal

# Before numpy is there: two workers of the tests, each with BLAS' threads on both processors, wait for each other.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


def pytest_configure():
    # A shell starts background jobs with interrupts ignored, and every child would inherit that.
    if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
