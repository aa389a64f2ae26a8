"""Running FMUs: instances, the co-simulation master, runs and checks."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .check import check_fmu
    from .run import run_fmu, save_fmu_events, save_fmu_run
    from .transient import integrate_fmu
else:
    from fivtui.lazy import lazy_exports

    __getattr__, __dir__ = lazy_exports(__name__)
