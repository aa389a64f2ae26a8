"""Measured data beside a run: imported, overlaid, compared within a tolerance."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .charts import overlay_chart, overlay_spectra
    from .comparison import QUANTITIES, Validation, comparison_of, read_shift, validate
    from .options import ValidateOptions
    from .reading import read_measurement
    from .tolerances import Tolerances, read_tolerances
else:
    from fivtui.lazy import lazily

    __getattr__, __dir__ = lazily(__name__)
