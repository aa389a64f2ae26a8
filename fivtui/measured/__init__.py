"""Measured data beside a run: imported, overlaid, compared within a tolerance."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .comparison import (
        QUANTITIES as QUANTITIES,
        Criterion as Criterion,
        Validation as Validation,
        validate as validate,
    )
    from .reading import read_measurement as read_measurement
    from .tolerances import Tolerances as Tolerances, read_tolerances as read_tolerances
else:
    from fivtui.lazy import lazily

    __getattr__, __dir__ = lazily(__name__)
