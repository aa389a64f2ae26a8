"""Stability of the equilibrium: eigenvalues, critical friction coefficients, modes."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .arrays import (
        StabilityPoints as StabilityPoints,
        critical_mus as critical_mus,
        is_on_belt as is_on_belt,
        judge_growths as judge_growths,
    )
    from .belt import (
        critical_mu_on_belt as critical_mu_on_belt,
        critical_speeds as critical_speeds,
    )
    from .charts import (
        frequency_chart as frequency_chart,
        growth_chart as growth_chart,
        plane_chart as plane_chart,
    )
    from .critical import (
        CriticalMu as CriticalMu,
        critical_mu as critical_mu,
        flutter_margin as flutter_margin,
        lowest_critical_mu as lowest_critical_mu,
    )
    from .eigenvalues import (
        Stability as Stability,
        growth_rate as growth_rate,
        stability as stability,
    )
    from .gradient import critical_mu_derivatives as critical_mu_derivatives
    from .report import (
        critical_mu_text as critical_mu_text,
        margin_text as margin_text,
        stability_rows as stability_rows,
        verdict as verdict,
    )
    from .scan import ModeScan as ModeScan, mode_scan as mode_scan, scan_top as scan_top
else:
    from fivtui.lazy import lazily

    __getattr__, __dir__ = lazily(__name__)
