"""Stability of the equilibrium: eigenvalues, critical friction coefficients, maps."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .arrays import judge_growths as judge_growths
    from .critical import CriticalMu as CriticalMu, critical_mu as critical_mu
    from .eigenvalues import (
        Stability as Stability,
        growth_rate as growth_rate,
        stability as stability,
    )
    from .figure import map_figure as map_figure, mode_figure as mode_figure
    from .files import (
        load_map as load_map,
        map_to_dict as map_to_dict,
        modes_over_mu as modes_over_mu,
        save_map as save_map,
        save_modes as save_modes,
        stability_to_dict as stability_to_dict,
    )
    from .map import StabilityMap as StabilityMap, stability_map as stability_map
    from .report import print_map as print_map, print_stability as print_stability
    from .scan import ModeScan as ModeScan, mode_scan as mode_scan, scan_top as scan_top
else:
    from fivtui.lazy import lazily

    __getattr__, __dir__ = lazily(__name__)
