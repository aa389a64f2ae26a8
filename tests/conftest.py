"""Configuration of all tests."""

import gc
import os
import subprocess
import sys
from collections.abc import Generator
from pathlib import Path

import pytest
from hypothesis import HealthCheck, is_hypothesis_test, settings

# No test depends on the machine's speed; CI draws the same random examples every time. `-m whole`
# repeats the tests with random examples, with 1000 examples instead of 40.
settings.register_profile(
    "fivtui",
    max_examples=40,
    deadline=None,
    derandomize="CI" in os.environ,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.register_profile("whole", settings.get_profile("fivtui"), max_examples=1000)

# Most objects of a test of the terminal interface live until its end: collect garbage rarely.
gc.set_threshold(200_000, 20, 50)

# Hundreds of processes import the same modules: allow cached bytecode, so they compile once.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)


@pytest.hookimpl(wrapper=True, optionalhook=True)
def pytest_xdist_auto_num_workers() -> Generator[None, int, int]:
    """One worker more than processors, as some tests wait for others."""
    return (yield) + 1


def pytest_configure(config: pytest.Config) -> None:
    """Choose the number of random examples."""
    settings.load_profile("whole" if config.option.markexpr == "whole" else "fivtui")


_ROOT = Path(__file__).parents[1]
# Exit status 1 if the kernel cannot be loaded, or a native FMU is missing or compiled from other
# sources. Other reasons, such as a platform without native FMUs, would remain after a rebuild.
_STALENESS_CHECK = """
import sys
from fivtui.kernel import why_interpreted
from fmu_src.build import native_failure
native_reason = str(native_failure())
native_is_stale = any(text in native_reason for text in ("other sources", "not installed"))
sys.exit(bool(why_interpreted()) or native_is_stale)
"""


def pytest_sessionstart(session: pytest.Session) -> None:
    """Rebuild compiled files that do not match the sources, once for all processes."""
    if not hasattr(session.config, "workerinput"):
        check = subprocess.run([sys.executable, "-c", _STALENESS_CHECK], cwd=_ROOT, check=False)
        if check.returncode:
            subprocess.run([sys.executable, "hatch_build.py"], cwd=_ROOT, check=False)


@pytest.fixture(scope="session")
def fmu(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The Python FMU of the slider-belt, which tests only read."""
    from fmu_src.build.builder import build_fmu

    return build_fmu(tmp_path_factory.mktemp("fmu") / "slider_belt.fmu", flavour="python")


def pytest_collection_finish() -> None:
    """Exclude objects created by collection from garbage collection."""
    gc.freeze()


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Under `-m whole` mark tests with random examples, too; allow an hour for marked tests."""
    for item in items:
        if config.option.markexpr == "whole" and is_hypothesis_test(getattr(item, "obj", None)):
            item.add_marker(pytest.mark.whole)
        if item.get_closest_marker("whole") is not None:
            item.add_marker(pytest.mark.timeout(3600.0))
