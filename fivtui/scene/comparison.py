"""A scene run natively and as an FMU, in both cases of the paper that the README cites.

A scene is a parameter set with the settings of its run. Case 1 considers separation of slider and
belt, Case 2 ignores it.
"""

import dataclasses
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from fivtui.charts import check_figure_path, save_figure, sheet_figure
from fivtui.fmu import integrate_fmu
from fivtui.io import check_distinct, check_output
from fivtui.model import InputError, Progress
from fivtui.simulation import compute
from fivtui.transient import Transient, transient_sheet
from fmu_src.build import build_fmu

from .scene import Scene

FMU_NAME: Final = "slider_belt.fmu"
FIGURE_NAME: Final = "figs-10-12.png"
# Samples of each run, over which the runs are compared.
_SAMPLES: Final = 10_001
_STATE: Final = ("x", "vx", "y", "vy")


@dataclass(frozen=True, slots=True)
class CaseRuns:
    """Native run and FMU run of one case, with the wall-clock time of each, s."""

    native: Transient
    fmu: Transient
    native_s: float
    fmu_s: float

    @property
    def difference(self) -> float:
        """Greatest difference of both runs in the sampled and final states, m and m/s."""
        pairs: list[Sequence[Any]] = [(self.native.final, self.fmu.final)]
        motions = [run.trajectory for run in (self.native, self.fmu)]
        pairs += [[getattr(motion, name) for motion in motions] for name in _STATE]
        return max(float(np.abs(np.subtract(*pair)).max()) for pair in pairs)


@dataclass(frozen=True, slots=True)
class Comparison:
    """Both cases, the time of building the FMU, s, and the files written."""

    considered: CaseRuns
    ignored: CaseRuns
    build_s: float
    fmu: Path
    figure: Path


def comparison_files(folder: Path) -> tuple[Path, Path]:
    """The FMU and the picture that `compare` writes into a folder."""
    return folder / FMU_NAME, folder / FIGURE_NAME


def compare(
    scene: Scene,
    folder: Path,
    *,
    progress: Callable[[float], bool] | None = None,
) -> Comparison:
    """Build the FMU, and run a scene with it and natively in both cases.

    The picture has the paper's Figs. 10 to 12: contact force and displacements over time.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot create the folder: {error.strerror}") from None
    fmu, figure = comparison_files(folder)
    check_distinct([("the FMU", fmu), ("the picture", figure)])
    check_output(fmu)
    check_figure_path(figure)
    work = Progress(progress)
    begin = time.perf_counter()
    build_fmu(fmu, flavour="python")
    build_s = time.perf_counter() - begin
    case_1, case_2 = (dataclasses.replace(scene, separation=flag) for flag in (True, False))
    considered = _case_runs(case_1, fmu, work.stage(0.0, 0.5))
    ignored = _case_runs(case_2, fmu, work.stage(0.5, 1.0))
    # A sheet is a picture of several charts, here of both runs: the last, Case 1, covers Case 2.
    sheet = transient_sheet([ignored.native, considered.native])
    save_figure(sheet_figure(sheet), figure)
    return Comparison(considered, ignored, build_s, fmu, figure)


def _case_runs(scene: Scene, fmu: Path, progress: Progress) -> CaseRuns:
    samples = np.linspace(0.0, scene.t_end, _SAMPLES)
    begin = time.perf_counter()
    request = scene.request(method="taylor", step=None, samples=samples)
    native = compute(request, progress=progress.stage(0.0, 0.1).callback)
    native_end = time.perf_counter()
    fmu_run = integrate_fmu(
        dataclasses.replace(request, method="fmu"),
        progress=progress.stage(0.1, 1.0).callback,
        fmu=fmu,
    )
    return CaseRuns(native, fmu_run, native_end - begin, time.perf_counter() - native_end)
