"""The nonlinear slider-belt model of friction-induced vibration, native and as an FMU.

The public functions are imported on first use, so that importing the package costs nothing.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from .version import __version__ as __version__

if TYPE_CHECKING:
    from .batch.run import simulate_batch
    from .equilibrium.eigenvalues import stability
    from .model.parameters import Parameters
    from .simulation import simulate
    from .sweeps.run import sweep

__all__ = ["Parameters", "simulate", "simulate_batch", "stability", "sweep"]

_HOMES = {
    "Parameters": ".model.parameters",
    "simulate": ".simulation",
    "simulate_batch": ".batch.run",
    "stability": ".equilibrium.eigenvalues",
    "sweep": ".sweeps.run",
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
