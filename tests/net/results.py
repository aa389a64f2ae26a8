"""Every result type of the public API: its printed text, dictionary and columns."""

import tempfile
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np

import fivtui
from fivtui import Parameters
from tests.net.commands import reproducible
from tests.net.text import SECTION_MARK, array_line, data_lines, mask_varying

INPUTS: Final = Path(__file__).parent / "inputs"
BELT: Final = Parameters(v_belt=1.0, mu_s=0.9)
LAW: Final = Parameters(v_belt=1.0, mu_s=0.9, v_s=0.4)
PRELOADED: Final = Parameters(F=120.0)
# Parameters over time, and the values of parameters in maps and sweeps.
_TABLES: Final = {"F": [(0.0, 10.0), (2.0, 60.0)], "v_belt": [(0.0, 3.0), (3.0, 0.0)]}
_AXES: Final = {"F": [20.0, 60.0], "mu": [0.3, 0.7]}


def _validation() -> Any:
    measured = fivtui.read_measurement(
        INPUTS / "measured.csv", time="ms", signal="mm", time_scale=1e-3, scale=1e-3
    )
    run = fivtui.simulate(t_end=4.0, samples="dense")
    return fivtui.validate(run, measured, tolerances=fivtui.Tolerances(frequency=0.05))


def _sound(folder: Path) -> Any:
    return fivtui.sound(fivtui.simulate(t_end=3.0, samples="dense"), folder / "a.wav", factor=100.0)


def _film(folder: Path) -> Any:
    run = fivtui.simulate(t_end=2.0, samples="dense")
    return fivtui.animate(run, folder / "a.gif", window=(1.0, 1.2), speed=1.0)


def _fmu_run(folder: Path) -> Any:
    path = fivtui.build_fmu(folder / "a.fmu", flavour="native")
    return fivtui.run_fmu(path, t_end=2.0, output_interval=0.25, start_values={"F": 60.0})


# Results by name; each is computed in a folder of its own.
RESULTS: Final[Mapping[str, Callable[[Path], Any]]] = {
    "transient": lambda _: fivtui.simulate(t_end=5.0),
    "transient sampled": lambda _: fivtui.simulate(t_end=5.0, samples=11),
    # A linear system, without k_nl and separation: the solution is exact.
    "transient exact": lambda _: fivtui.simulate(
        Parameters(k_nl=0.0), t_end=3.0, separation=False, samples=7
    ),
    "transient interpreted": lambda _: fivtui.simulate(LAW, t_end=3.0, kernel="interpreted"),
    "transient on a belt": lambda _: fivtui.simulate(BELT, t_end=4.0, samples=11),
    "transient with a friction law": lambda _: fivtui.simulate(LAW, t_end=4.0, samples=11),
    "transient over time": lambda _: fivtui.simulate(BELT, t_end=4.0, over_time=_TABLES, samples=9),
    "transient with sensitivities": lambda _: fivtui.simulate(
        LAW, t_end=3.0, sensitivities=("mu", "F", "v_belt", "v_s", "m", "c1", "k3")
    ),
    "transient by RK4": lambda _: fivtui.simulate(t_end=3.0, method="rk4", step=0.01, samples=7),
    "batch": lambda _: fivtui.simulate_batch({"F": [20.0, 60.0, 120.0]}, t_end=5.0),
    "batch on belts": lambda _: fivtui.simulate_batch(
        {"v_belt": [0.5, 1.0], "v_s": [0.4, 0.8]}, base=LAW, t_end=5.0
    ),
    "stability": lambda _: fivtui.stability(),
    "stability with a friction law": lambda _: fivtui.stability(LAW),
    "map": lambda _: fivtui.stability_map(None, _AXES),
    "map of critical friction": lambda _: fivtui.stability_map(
        None, {"F": [20.0, 60.0], "m": [1.0, 5.0]}, "critical-mu"
    ),
    "safety map": lambda _: fivtui.safety_map(None, {"F": [60.0, 120.0], "k_nl": [50.0, 100.0]}),
    "coexistence map": lambda _: fivtui.safety_map(None, _AXES, "coexistence"),
    "safe friction": lambda _: fivtui.safe_friction(PRELOADED),
    "attractors": lambda _: fivtui.attractors(PRELOADED),
    "basin": lambda _: fivtui.basin(PRELOADED, {"y0": [-1.0, -0.8], "vy0": [0.0, 1.0, 2.0]}),
    # Attractors by transients from value to value of μ; and the curve of limit cycles along μ,
    # stable or not.
    "continuation": lambda _: fivtui.continuation(PRELOADED, "mu", [0.4, 0.6]),
    "branch": lambda _: fivtui.branch(PRELOADED, "mu", low=0.6, high=0.8),
    "boundary": lambda _: fivtui.boundary(None, "hopf", {"F": (60.0, 120.0), "mu": (0.3, 0.8)}),
    "sweep": lambda _: fivtui.sweep(vary=_AXES, t_end=5.0),
    "sweep on belts": lambda _: fivtui.sweep(
        BELT, vary={"v_belt": [0.5, 2.0]}, separation="both", t_end=3.0
    ),
    "uncertainty": lambda _: fivtui.uncertainty(
        vary={"mu": "uniform:0.2:0.8", "F": "normal:80:8"},
        samples=32,
        repeats=4,
        outputs=["growth_rate", "y_half_range"],
        t_end=2.0,
    ),
    # CPU time against error, for every method.
    "trade-off": lambda _: fivtui.tradeoff(t_end=0.2),
    "accuracy": lambda _: fivtui.accuracy(t_end=4.0),
    "validation": lambda _: _validation(),
    "sound": _sound,
    "film": _film,
    "run of an FMU": _fmu_run,
    "figures": lambda folder: fivtui.figures(folder, [2], formats=["png"]),
    # Statements of the paper, compared with the model.
    "claims": lambda _: fivtui.claims(["one-real-equilibrium", "frequencies-merge"]),
    # A named set of parameters with the settings of its transient.
    "scene": lambda _: fivtui.find_scene("brake-stop"),
    "parameters": lambda _: LAW,
}


def record_results() -> str:
    """All results, as lines."""
    lines = []
    with reproducible():
        for name, compute in RESULTS.items():
            with tempfile.TemporaryDirectory(prefix="fivtui-net-") as folder:
                lines.append(f"{SECTION_MARK}{name}")
                text = "\n".join(result_lines(compute(Path(folder).resolve())))
                lines += mask_varying(text, Path(folder).resolve()).splitlines()
    return "\n".join(lines) + "\n"


def result_lines(result: Any) -> Iterator[str]:
    """Printed text, dictionary and columns of a result."""
    yield f"type {type(result).__name__}"
    for entry in result if isinstance(result, list) else [result]:
        yield repr(entry)
    if hasattr(result, "to_dict"):
        yield from (f"to_dict {line}" for line in data_lines(result.to_dict()))
    if hasattr(result, "to_columns"):
        try:
            columns = result.to_columns()
        except fivtui.InputError as error:
            yield f"to_columns refused: {error}"
            return
        for column, values in columns.items():
            yield f"to_columns {array_line(column, values)}, {np.asarray(values).dtype.kind}"


def record_stored_files() -> str:
    """Content read from every stored file of results and scenes."""
    from fivtui.studies import kind_of, load_study

    stored = Path(__file__).parents[1] / "data" / "stored"
    lines = []
    # Not the session, a saved state of the laboratory: `tabs` records the laboratory with it.
    for path in sorted(path for path in stored.iterdir() if path.name != "session"):
        lines.append(f"{SECTION_MARK}{path.name}")
        try:
            if path.suffix == ".toml":
                result = fivtui.load_scene(path)
            else:
                kind = kind_of(path)
                lines.append(f"kind {kind}")
                result = load_study(kind, path)
        except fivtui.InputError as error:
            lines.append(mask_varying(f"refused: {error}", stored))
        else:
            lines += mask_varying("\n".join(result_lines(result)), stored).splitlines()
    return "\n".join(lines) + "\n"
