"""Results that figures and claims share, each computed once.

A panel is one diagram of a figure. A line over time is the run of one scene; in a line over a
parameter each point belongs to one scene.
"""

from collections.abc import Callable, Iterable, Iterator
from typing import Final

import numpy as np

from fivtui.model import Cancelled, OnProgress
from fivtui.scene import Scene
from fivtui.simulation import compute as compute_transient
from fivtui.transient import Transient

from .amplitudes import Amplitude, compute_amplitudes
from .data import FigureData
from .panels import PANELS, Panel
from .tables import COLUMNS, amplitude_columns, motion_columns, panel_data

# Number of samples of the trajectory of a run.
_SAMPLES: Final = 10_001


class PaperResults:
    """Tables and runs of the paper, each computed when first requested.

    `tables` has those computed so far, by the keys of their panels. `should_continue` is called
    between computations, which are cancelled when it returns False.
    """

    def __init__(self, *, workers: int | None = None) -> None:
        self.should_continue: Callable[[], bool] = lambda: True
        self._workers = workers
        self.tables: dict[str, FigureData] = {}
        self._runs: dict[Scene, Transient] = {}
        self._amplitudes: dict[Scene, Amplitude] = {}

    def prepare(self, scenes: Iterable[Scene], progress: OnProgress | None = None) -> None:
        """Compute the amplitudes of many scenes at once, unless already known.

        `progress` is called with the fraction done; raises `Cancelled` if it returns False, and
        `ComputationError` if a run cannot be finished.
        """
        missing = [scene for scene in dict.fromkeys(scenes) if scene not in self._amplitudes]
        if missing:
            results = compute_amplitudes(missing, workers=self._workers, progress=progress)
            self._amplitudes.update(zip(missing, results, strict=True))

    def amplitudes(self, scenes: Iterable[Scene]) -> list[Amplitude]:
        """The amplitudes of scenes, in their order."""
        scenes = list(scenes)
        self.prepare(scenes)
        return [self._amplitudes[scene] for scene in scenes]

    def run(self, scene: Scene) -> Transient:
        """The run of a scene, with 10,001 samples of its trajectory."""
        if scene not in self._runs:
            samples = np.linspace(0.0, scene.t_end, _SAMPLES)
            self._runs[scene] = compute_transient(
                scene.request(method="taylor", step=None, samples=samples),
                progress=lambda _fraction: self.should_continue(),
            )
        return self._runs[scene]

    def runs(self, panel: Panel) -> list[Transient]:
        """The runs of a panel of the kind ``"transient"``, one per line."""
        return [self.run(line.scene) for line in panel.lines]

    def table(self, key: str) -> FigureData:
        """The data of a panel, by its key in `PANELS`."""
        if key not in self.tables:
            self.tables[key] = self._compute_table(PANELS[key])
        return self.tables[key]

    def _compute_table(self, panel: Panel) -> FigureData:
        if panel.kind == "transient":
            columns = motion_columns(panel, self.runs(panel))
        elif panel.kind == "amplitude":
            scenes = panel.scenes()
            columns = amplitude_columns(scenes, self.amplitudes(scenes))
        else:
            columns = COLUMNS[panel.kind](self._cancellable(panel.scenes()))
        return panel_data(panel, columns)

    def _cancellable(self, scenes: Iterable[Scene]) -> Iterator[Scene]:
        for scene in scenes:
            if not self.should_continue():
                raise Cancelled
            yield scene
