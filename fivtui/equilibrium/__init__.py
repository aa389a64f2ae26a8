"""Stability of the equilibrium: eigenvalues, critical friction coefficients, modes."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .arrays import (
        StabilityPoints,
        critical_mus,
        has_finite_speed,
        judge_stability,
        reasons_without_verdict,
    )
    from .belt import critical_mu_on_belt, critical_speeds
    from .charts import frequency_chart, growth_chart, plane_chart
    from .critical import (
        CriticalMu,
        critical_mu,
        critical_mu_derivatives,
        flutter_margin,
        lowest_critical_mu,
    )
    from .eigenvalues import Stability, growth_rate, stability
    from .modes import VibrationMode
    from .report import critical_mu_text, margin_text, stability_rows, verdict
    from .scan import ModeScan, mu_scan_end
else:
    from fivtui.lazy import lazy_exports

    __getattr__, __dir__ = lazy_exports(__name__)
