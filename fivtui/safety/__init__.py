"""Safe friction: the μ below which no searched disturbance leads to vibration."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .hopf_branch import safe_mu_derivatives
    from .phrases import basis_rows, largest_cycle_text, verdict_text
    from .search import START_DIMENSIONS, disturbed_states
    from .table import MAX_FOLDS, SafeTable, safe_mus, safe_table
    from .verdict import SafeFriction, safe_friction
    from .zones import Zone, Zones, linear_zones, safety_zones, zones_of_safe_friction
else:
    from fivtui.lazy import lazy_exports

    __getattr__, __dir__ = lazy_exports(__name__)
