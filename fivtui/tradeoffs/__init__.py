"""Measure the trade-off of speed against accuracy."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .charts import tradeoff_chart
    from .measure import QUICK_S, Tradeoff, measure_tradeoff, tradeoff
    from .options import TradeoffOptions
    from .report import settings_table
    from .settings import MeasuredSetting, cheapest
else:
    from fivtui.lazy import lazy_exports

    __getattr__, __dir__ = lazy_exports(__name__)
