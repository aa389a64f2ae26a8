"""The Taylor integrator in plain floats. It imports only the standard library and `model`."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .belt import taylor_stepper
    from .extremes import Extremes
    from .polynomial import derivative, evaluate, first_root, roots
    from .segment import Segment, Stepper
    from .stepper import (
        DEFAULT_TOL,
        TOL_RANGE,
        StallError,
        follows_law,
        local_tolerance,
        order_for,
        overflow_error,
        stall_error,
    )
    from .variation import Deviations, Seed, unbounded_error
else:
    from fivtui.lazy import lazy_exports

    __getattr__, __dir__ = lazy_exports(__name__)
