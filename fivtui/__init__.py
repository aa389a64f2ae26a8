"""The nonlinear slider-belt model of friction-induced vibration, native and as an FMU.

The public names are imported on first use, so that importing the package costs nothing.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from fmu_src.build import build_fmu, build_ssp

    from .assessment import accuracy
    from .batch import simulate_batch
    from .console import ProgressBar
    from .distributions import Distribution
    from .equilibrium import stability
    from .film import animate
    from .fmu import check_fmu, run_fmu
    from .identification import identify
    from .maps import safety_map, stability_map
    from .measured import Tolerances, read_measurement, validate
    from .model import Cancelled, ComputationError, InputError, Parameters
    from .orbits import attractors, basin, boundary, branch, continuation
    from .paper import figures
    from .paper.claims import claims
    from .reliability import uncertainty
    from .safety import safe_friction
    from .scene import PRESETS, Scene, find_scene, load_scene, save_scene
    from .signals import sound
    from .simulation import simulate
    from .sweeps import Design, Range, sweep
    from .tradeoffs import tradeoff
    from .version import __version__
else:
    from .lazy import lazy_exports

    __getattr__, __dir__ = lazy_exports(__name__)

__all__ = [
    "PRESETS",
    "Cancelled",
    "ComputationError",
    "Design",
    "Distribution",
    "InputError",
    "Parameters",
    "ProgressBar",
    "Range",
    "Scene",
    "Tolerances",
    "__version__",
    "accuracy",
    "animate",
    "attractors",
    "basin",
    "boundary",
    "branch",
    "build_fmu",
    "build_ssp",
    "check_fmu",
    "claims",
    "continuation",
    "figures",
    "find_scene",
    "identify",
    "load_scene",
    "read_measurement",
    "run_fmu",
    "safe_friction",
    "safety_map",
    "save_scene",
    "simulate",
    "simulate_batch",
    "sound",
    "stability",
    "stability_map",
    "sweep",
    "tradeoff",
    "uncertainty",
    "validate",
]
