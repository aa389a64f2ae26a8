"""Safe friction: below which μ no disturbance leads to vibration, as far as was searched."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .gradient import safe_mu_derivatives as safe_mu_derivatives
    from .table import (
        MOST_FOLDS as MOST_FOLDS,
        SafeTable as SafeTable,
        safe_mus as safe_mus,
        safe_table as safe_table,
    )
    from .verdict import SafeFriction as SafeFriction, safe_friction as safe_friction
    from .words import (
        basis_rows as basis_rows,
        coexistence_here as coexistence_here,
        safety_words as safety_words,
    )
    from .zones import (
        Zone as Zone,
        Zones as Zones,
        linear_zones as linear_zones,
        safety_zones as safety_zones,
        searched_zones as searched_zones,
    )
else:
    from fivtui.lazy import lazily

    __getattr__, __dir__ = lazily(__name__)
