"""The FMU in each flavour, driven in a process of its own, and its model descriptions."""

import zipfile
from collections.abc import Iterator
from xml.etree import ElementTree as ET

import pytest

from fmu_src.build.builder import NATIVE, PYTHON, build_fmu
from fmu_src.build.components import COMPONENTS
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


@pytest.fixture(scope="module")
def descriptions(tmp_path_factory: pytest.TempPathFactory) -> dict[str, ET.Element]:
    """The model description of each component."""
    folder, roots = tmp_path_factory.mktemp("fmu"), {}
    for which in COMPONENTS:
        fmu = build_fmu(folder / f"{which}.fmu", component=which, flavour=PYTHON)
        with zipfile.ZipFile(fmu) as archive:
            roots[which] = ET.fromstring(archive.read("modelDescription.xml"))
    return roots
