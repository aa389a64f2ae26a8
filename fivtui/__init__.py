"""The nonlinear slider-belt model of friction-induced vibration, native and as an FMU.

The public names are imported on first use, so that importing the package costs nothing.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from .version import __version__ as __version__

if TYPE_CHECKING:
    from fmu_src.build.builder import build_fmu
    from fmu_src.build.ssp import build_ssp

    from .assessment.estimate import accuracy
    from .batch.run import simulate_batch
    from .equilibrium.eigenvalues import stability
    from .equilibrium.map import stability_map
    from .fmu.check import check_fmu
    from .fmu.run import run_fmu
    from .model.errors import Cancelled, ComputationError, InputError
    from .model.parameters import Parameters
    from .orbits.attractor_search import attractors
    from .orbits.basins import basin
    from .orbits.branches import continuation
    from .paper.claims.check import claims
    from .paper.export import figures
    from .scene.presets import PRESETS
    from .scene.scene import Scene, find_scene, load_scene, save_scene
    from .simulation import simulate
    from .sweeps.design import Design, Range
    from .sweeps.run import sweep
    from .tradeoffs.measure import tradeoff

__all__ = [
    "PRESETS",
    "Cancelled",
    "ComputationError",
    "Design",
    "InputError",
    "Parameters",
    "Range",
    "Scene",
    "__version__",
    "accuracy",
    "attractors",
    "basin",
    "build_fmu",
    "build_ssp",
    "check_fmu",
    "claims",
    "continuation",
    "figures",
    "find_scene",
    "load_scene",
    "run_fmu",
    "save_scene",
    "simulate",
    "simulate_batch",
    "stability",
    "stability_map",
    "sweep",
    "tradeoff",
]

# The module of every public name, by subject.
_HOMES = {
    name: module
    for module, names in {
        ".simulation": "simulate",
        ".batch.run": "simulate_batch",
        ".equilibrium.eigenvalues": "stability",
        ".equilibrium.map": "stability_map",
        ".orbits.attractor_search": "attractors",
        ".orbits.basins": "basin",
        ".orbits.branches": "continuation",
        ".sweeps.run": "sweep",
        ".sweeps.design": "Design Range",
        ".tradeoffs.measure": "tradeoff",
        ".assessment.estimate": "accuracy",
        ".paper.export": "figures",
        ".paper.claims.check": "claims",
        ".fmu.check": "check_fmu",
        ".fmu.run": "run_fmu",
        "fmu_src.build.builder": "build_fmu",
        "fmu_src.build.ssp": "build_ssp",
        ".scene.scene": "Scene find_scene load_scene save_scene",
        ".scene.presets": "PRESETS",
        ".model.parameters": "Parameters",
        ".model.errors": "Cancelled ComputationError InputError",
    }.items()
    for name in names.split()
}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    # Importing a submodule binds its name here: the function of that name must win.
    value = getattr(import_module(_HOMES[name], __name__), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
