"""The slider-belt model: parameters, contact law, equations of motion, equilibrium.

Imports the standard library alone.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .advice import (
        CUBIC_CONTACT as CUBIC_CONTACT,
        SEPARATION as SEPARATION,
        advise as advise,
        use_one_of as use_one_of,
    )
    from .columns import COLUMNS as COLUMNS, Column as Column
    from .errors import (
        Cancelled as Cancelled,
        ComputationError as ComputationError,
        InputError as InputError,
        one_line as one_line,
    )
    from .field import (
        CONSTANT as CONSTANT,
        DERIVATIVE_STEP as DERIVATIVE_STEP,
        Rates as Rates,
        coupling_stiffness as coupling_stiffness,
        depends_on_speed as depends_on_speed,
        derivative as derivative,
        flutter_boundary as flutter_boundary,
        flutter_boundary_slope as flutter_boundary_slope,
        friction_coefficient as friction_coefficient,
        friction_derivatives as friction_derivatives,
        friction_slope as friction_slope,
        guard_value as guard_value,
        holding_force as holding_force,
        horizontal_stiffness as horizontal_stiffness,
        load as load,
        rest_coefficients as rest_coefficients,
        spring_force as spring_force,
        suspension_stiffness as suspension_stiffness,
        tangent_slope as tangent_slope,
        tangent_stiffness as tangent_stiffness,
        total_stiffness as total_stiffness,
    )
    from .modes import (
        ALWAYS_SLIDING as ALWAYS_SLIDING,
        IN_CONTACT as IN_CONTACT,
        MODES as MODES,
        Guard as Guard,
        Mode as Mode,
        Transition as Transition,
        transition_name as transition_name,
    )
    from .numbers import (
        Interval as Interval,
        parse_number as parse_number,
        read_number as read_number,
        read_whole as read_whole,
    )
    from .over_time import (
        TIMED as TIMED,
        Course as Course,
        Rows as Rows,
        TimeTable as TimeTable,
        course_of as course_of,
        parameters_after as parameters_after,
        time_table as time_table,
        time_tables as time_tables,
    )
    from .parameters import (
        ALL_PARAMETERS as ALL_PARAMETERS,
        BELT_PARAMETERS as BELT_PARAMETERS,
        NONE as NONE,
        PARAMETERS as PARAMETERS,
        Parameters as Parameters,
        ParameterSpec as ParameterSpec,
        check_always_sliding as check_always_sliding,
        check_effect as check_effect,
        check_names as check_names,
        check_parameters as check_parameters,
        number_spec as number_spec,
        parameter_spec as parameter_spec,
        unknown_name as unknown_name,
        unused_parameters as unused_parameters,
        without_effect as without_effect,
    )
    from .progress import OnProgress as OnProgress, Progress as Progress
    from .slider_belt import (
        Equilibrium as Equilibrium,
        State as State,
        accelerations as accelerations,
        contact_force as contact_force,
        equilibrium as equilibrium,
        friction_force as friction_force,
        jacobian as jacobian,
        mode_of as mode_of,
        no_equilibrium_error as no_equilibrium_error,
        resting_height as resting_height,
        sliding as sliding,
        static_deflection as static_deflection,
        static_start as static_start,
        static_start_change as static_start_change,
        time_scale as time_scale,
    )
    from .system import System as System, system_of as system_of
else:
    from fivtui.lazy import lazily

    __getattr__, __dir__ = lazily(__name__)
