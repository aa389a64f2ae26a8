"""Identification: parameters fitted to measured signals and features."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .charts import fit_charts
    from .estimation import identify, prepare_fit
    from .options import IdentifyOptions
    from .result import Identification, unit_of
else:
    from fivtui.lazy import lazy_exports

    __getattr__, __dir__ = lazy_exports(__name__)
