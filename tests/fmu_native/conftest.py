"""The native FMU of the slider-belt, as a file and extracted."""

from pathlib import Path

import fmpy
import pytest

from fmu_src.build.builder import build_fmu


@pytest.fixture(scope="session")
def fmu(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The FMU."""
    return build_fmu(tmp_path_factory.mktemp("fmu") / "slider_belt.fmu", flavour="native")


@pytest.fixture(scope="session")
def folder(fmu: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the extracted FMU."""
    extracted = tmp_path_factory.mktemp("extracted")
    fmpy.extract(str(fmu), str(extracted))
    return extracted
