"""The trade of speed for accuracy, measured."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .charts import tradeoff_chart as tradeoff_chart
    from .measure import (
        Tradeoff as Tradeoff,
        measure_tradeoff as measure_tradeoff,
        tradeoff as tradeoff,
    )
    from .settings import (
        MeasuredSetting as MeasuredSetting,
        Setting as Setting,
        cheapest as cheapest,
        pareto as pareto,
    )
else:
    from fivtui.lazy import lazily

    __getattr__, __dir__ = lazily(__name__)
