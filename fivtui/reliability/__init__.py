"""Uncertainty studies: the probability of squeal if parameters scatter, and what drives it."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .charts import displayed_quantity, histogram_chart, quantity_name, samples_chart
    from .options import UncertaintyOptions
    from .report import UncertaintyProgress
    from .request import (
        DEFAULT_OUTPUTS,
        DEFAULT_SAMPLES,
        FIRST_SAMPLES,
        check_until,
        parse_inputs,
        scattered_study,
        truncations,
    )
    from .result import Uncertainty
    from .run import MembersFile, compute_uncertainty, uncertainty
    from .statistics import beyond_share
else:
    from fivtui.lazy import lazily

    __getattr__, __dir__ = lazily(__name__)
