"""How likely squeal is where parameters scatter, and what drives it."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .report import UncertaintyProgress as UncertaintyProgress
    from .request import (
        DEFAULT_OUTPUTS as DEFAULT_OUTPUTS,
        DEFAULT_SAMPLES as DEFAULT_SAMPLES,
        FIRST_SAMPLES as FIRST_SAMPLES,
        parse_inputs as parse_inputs,
        scattered_study as scattered_study,
        truncations as truncations,
        wanted_error as wanted_error,
    )
    from .result import Uncertainty as Uncertainty
    from .run import Place as Place, measured as measured, uncertainty as uncertainty
    from .statistics import beyond_share as beyond_share
else:
    from fivtui.lazy import lazily

    __getattr__, __dir__ = lazily(__name__)
