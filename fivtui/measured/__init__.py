"""Import measured data and compare it with a run, within tolerances."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .charts import describe_verdict, overlay_chart, overlay_spectra
    from .comparison import QUANTITIES, Validation, prepare_comparison, validate
    from .options import SCALE, TIME, TIME_SCALE, ValidateOptions
    from .reading import has_column_name, read_measurement
    from .tolerances import Tolerances
else:
    from fivtui.lazy import lazy_exports

    __getattr__, __dir__ = lazy_exports(__name__)
