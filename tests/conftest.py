"""Settings of all tests."""

import gc
import os
import subprocess
import sys

import pytest
from hypothesis import HealthCheck, settings

# No test depends on how fast the machine is; the checks run the same examples every time.
settings.register_profile(
    "fivtui",
    deadline=None,
    derandomize="CI" in os.environ,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("fivtui")

# A third of a test of the laboratory would go into looking at what stays anyway.
gc.set_threshold(50_000, 20, 50)


_KERNELS = (
    "from fivtui import simulate; simulate(t_end=1.0, kernel='compiled')",
    "from fivtui import simulate_batch; simulate_batch({'F': [80.0]}, t_end=1.0)",
)


def pytest_sessionstart(session: pytest.Session) -> None:
    """Compile the kernels once, before several processes that run all tests need them at once."""
    config = session.config
    several = config.getoption("numprocesses", 0) and not hasattr(config, "workerinput")
    if several and config.args_source is config.ArgsSource.TESTPATHS:
        compiling = [subprocess.Popen([sys.executable, "-c", code]) for code in _KERNELS]
        for process in compiling:
            process.wait()


def pytest_collection_finish() -> None:
    """Leave what was imported to collect the tests out of every collection of garbage."""
    gc.freeze()
