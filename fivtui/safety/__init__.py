"""Safe friction: below which μ no disturbance leads to vibration, as far as was searched."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .least import safe_mu_derivatives
    from .phrases import basis_rows, coexistence_here, safety_words
    from .table import MOST_FOLDS, SafeTable, safe_mus, safe_table
    from .verdict import SafeFriction, safe_friction
    from .zones import Zone, Zones, linear_zones, safety_zones, searched_zones
else:
    from fivtui.lazy import lazily

    __getattr__, __dir__ = lazily(__name__)
