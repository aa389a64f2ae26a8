"""Uncertainty studies: the probability of squeal if parameters scatter, and Sobol indices."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .charts import (
        displayed_quantity,
        histogram_chart,
        probability_text,
        quantity_name,
        samples_chart,
    )
    from .options import UncertaintyOptions
    from .report import UncertaintyProgress
    from .request import (
        DEFAULT_OUTPUTS,
        DEFAULT_SAMPLES,
        FIRST_SAMPLES,
        check_until,
        parse_inputs,
        scattered_study,
    )
    from .result import Uncertainty
    from .run import MembersFile, compute_uncertainty, uncertainty
    from .statistics import excess_remark, rank_inputs
else:
    from fivtui.lazy import lazy_exports

    __getattr__, __dir__ = lazy_exports(__name__)
