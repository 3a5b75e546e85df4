# SPDX-License-Identifier: Apache-2.0
"""What holds for all tests."""

import atexit
import gc
import signal

import hypothesis

# Most objects are the libraries': looking through them again and again takes a tenth of the time.
gc.set_threshold(100_000, 20, 50)
atexit.register(gc.freeze)

# A shell's background jobs ignore Ctrl-C, and so would every process that is started here.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


# Examples take as long as a busy machine makes them.
hypothesis.settings.register_profile(
    "patient", deadline=None, suppress_health_check=[hypothesis.HealthCheck.too_slow]
)
hypothesis.settings.load_profile("patient")


def pytest_configure(config):
    """Name the mark of files that make test runs and make test-fast leaves out."""
    config.addinivalue_line("markers", "long: a file that computes for many seconds")
