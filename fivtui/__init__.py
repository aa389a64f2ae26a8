"""The nonlinear slider-belt model of friction-induced vibration, native and as an FMU.

The public functions are imported on first use, so that importing the package costs nothing.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .core.batch import simulate_batch
    from .core.parameters import Parameters
    from .core.stability import stability
    from .simulation import simulate
    from .sweeps import sweep

__version__ = "0.1.0"
__all__ = ["Parameters", "simulate", "simulate_batch", "stability", "sweep"]

_HOMES = {
    "Parameters": ".core.parameters",
    "simulate": ".simulation",
    "simulate_batch": ".core.batch",
    "stability": ".core.stability",
    "sweep": ".sweeps",
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
