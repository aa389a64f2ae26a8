"""The Taylor integrator in plain floats. Imports the standard library and `model` alone."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .belt import BeltStepper as BeltStepper
    from .polynomial import (
        derivative as derivative,
        evaluate as evaluate,
        first_root as first_root,
        minimum_maximum as minimum_maximum,
        restricted as restricted,
        roots as roots,
    )
    from .segment import BeltSegment as BeltSegment, Segment as Segment, Stepper as Stepper
    from .stepper import (
        DEFAULT_TOL as DEFAULT_TOL,
        TOL_RANGE as TOL_RANGE,
        StallError as StallError,
        TaylorStepper as TaylorStepper,
        follows_law as follows_law,
        local_tolerance as local_tolerance,
        order_for as order_for,
        overflow_error as overflow_error,
        stall_error as stall_error,
    )
    from .variation import (
        Deviations as Deviations,
        Seed as Seed,
        unbounded_error as unbounded_error,
    )
else:
    from fivtui.lazy import lazily

    __getattr__, __dir__ = lazily(__name__)
