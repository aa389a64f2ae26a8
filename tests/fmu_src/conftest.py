"""The FMU in each flavour, driven in a process of its own."""

from collections.abc import Iterator

import pytest

from fmu_src.build.builder import NATIVE, PYTHON, build_fmu
from tests.support.fmu_driver import Driver


@pytest.fixture(scope="module", params=[PYTHON, NATIVE])
def flavour(request: pytest.FixtureRequest) -> str:
    """The flavour of the FMU."""
    name: str = request.param
    return name


@pytest.fixture(scope="module")
def driver(flavour: str, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Driver]:
    """A process that drives the slider-belt."""
    fmu = tmp_path_factory.mktemp("fmu") / "slider_belt.fmu"
    with Driver(build_fmu(fmu, flavour=flavour)) as driver:
        yield driver
