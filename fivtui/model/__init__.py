"""The slider-belt model: parameters, contact law, equations of motion, equilibrium.

Imports the standard library alone.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .advice import CUBIC_CONTACT, SEPARATION, advise, advise_one_of
    from .columns import COLUMNS, Column
    from .errors import Cancelled, ComputationError, InputError, one_line
    from .field import (
        CONSTANT,
        DERIVATIVE_STEP,
        Rates,
        coupling_stiffness,
        depends_on_speed,
        derivative,
        flutter_boundary,
        flutter_boundary_slope,
        friction_coefficient,
        friction_derivatives,
        friction_slope,
        guard_value,
        holding_force,
        horizontal_stiffness,
        load,
        rest_coefficients,
        spring_force,
        suspension_stiffness,
        tangent_slope,
        tangent_stiffness,
        total_stiffness,
    )
    from .modes import ALWAYS_SLIDING, IN_CONTACT, MODES, Guard, Mode, Transition, transition_name
    from .numbers import Interval, parse_number, read_integer, read_number
    from .over_time import (
        HELD_OVER_TIME,
        LINEAR_OVER_TIME,
        TIME_DEPENDENT,
        Course,
        Rows,
        TimeTable,
        build_course,
        initial_values,
        parameters_after,
        time_table,
        time_tables,
    )
    from .parameters import (
        ALL_PARAMETERS,
        BELT_PARAMETERS,
        NONE_TEXT,
        PARAMETERS,
        Parameters,
        ParameterSpec,
        check_always_sliding,
        check_known,
        check_names,
        check_parameters,
        check_varied_are_used,
        describe_unused,
        number_spec,
        parameter_spec,
        unknown_name_error,
        unused_parameters,
    )
    from .progress import OnProgress, Progress
    from .slider_belt import (
        Equilibrium,
        State,
        accelerations,
        check_has_verdict,
        check_off_edge,
        contact_force,
        equilibrium,
        friction_force,
        is_on_edge,
        jacobian,
        mode_of,
        no_equilibrium_error,
        resting_height,
        sliding_coefficients,
        sliding_friction_ratio,
        sliding_mode,
        static_deflection,
        static_start,
        static_start_change,
        time_scale,
    )
    from .system import System, check_separation, system_of
else:
    from fivtui.lazy import lazy_exports

    __getattr__, __dir__ = lazy_exports(__name__)
