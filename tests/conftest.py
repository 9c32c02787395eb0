"""Tests start programs and interrupt them: they must hear it."""

import signal


def pytest_configure():
    # A shell starts background jobs with interrupts ignored, and every child would inherit that.
    if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
