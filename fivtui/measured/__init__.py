"""Measured data beside a run: imported, overlaid, compared within a tolerance."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .comparison import Validation as Validation, validate as validate
    from .reading import read_measurement as read_measurement
    from .tolerances import Tolerances as Tolerances, read_tolerance as read_tolerance
else:
    from fivtui.lazy import lazily

    __getattr__, __dir__ = lazily(__name__)
