"""The Taylor integrator in plain floats. Imports the standard library and `model` alone."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .polynomial import (
        MAX_DEPTH as MAX_DEPTH,
        derivative as derivative,
        first_root as first_root,
        minimum_maximum as minimum_maximum,
        restricted as restricted,
    )
    from .segment import Segment as Segment, Stepper as Stepper
    from .series import (
        Constants as Constants,
        RightHandSide as RightHandSide,
        Values as Values,
        constants as constants,
        newest_last as newest_last,
        recurrences as recurrences,
        right_hand_side as right_hand_side,
        state_function as state_function,
    )
    from .stepper import (
        DEFAULT_TOL as DEFAULT_TOL,
        EXP2_BIAS as EXP2_BIAS,
        LONGEST_STEP as LONGEST_STEP,
        MAX_ORDER as MAX_ORDER,
        MAX_STALLED as MAX_STALLED,
        MIN_ORDER as MIN_ORDER,
        ORDER_STEP as ORDER_STEP,
        SHORTEST_FLIGHT as SHORTEST_FLIGHT,
        TOL_RANGE as TOL_RANGE,
        TaylorStepper as TaylorStepper,
        local_tolerance as local_tolerance,
        order_for as order_for,
        overflow_error as overflow_error,
        stall_error as stall_error,
    )
else:
    from fivtui.lazy import lazily

    __getattr__, __dir__ = lazily(__name__)
