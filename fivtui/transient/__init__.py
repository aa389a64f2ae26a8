"""Transients: what is asked, the methods, the event loop, the result, its files and figure."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .derivatives.variation import (
        EXTREMES as EXTREMES,
        START_SEEDS as START_SEEDS,
        Variation as Variation,
        vary as vary,
    )
    from .errors import (
        PARTED as PARTED,
        QUANTITIES as QUANTITIES,
        Deviation as Deviation,
        Divergence as Divergence,
        Observation as Observation,
        check_accuracy as check_accuracy,
        check_quantity as check_quantity,
        deviation as deviation,
        divergence as divergence,
        finer_tol as finer_tol,
        first_tol as first_tol,
        observation as observation,
    )
    from .figure import transient_figure as transient_figure
    from .files import trajectory_of as trajectory_of
    from .linear.rounding import rounding_error as rounding_error
    from .methods import (
        FMU_FLAVOURS as FMU_FLAVOURS,
        METHODS as METHODS,
        check_takes_step as check_takes_step,
        fixed_step as fixed_step,
        takes_step as takes_step,
    )
    from .native import (
        check_taylor_options as check_taylor_options,
        integrate as integrate,
        later_amplitude as later_amplitude,
    )
    from .recorder import Recorder as Recorder
    from .report import print_transient as print_transient, transient_rows as transient_rows
    from .request import (
        DEFAULT_T_END as DEFAULT_T_END,
        DEFAULT_TOL as DEFAULT_TOL,
        LEAST_START as LEAST_START,
        MAX_STEPS as MAX_STEPS,
        MAX_T_END as MAX_T_END,
        START_FORM as START_FORM,
        START_SPECS as START_SPECS,
        T_END_INTERVAL as T_END_INTERVAL,
        TOL_INTERVAL as TOL_INTERVAL,
        TOL_RANGE as TOL_RANGE,
        Kernel as Kernel,
        KernelChoice as KernelChoice,
        OnSamples as OnSamples,
        Request as Request,
        Samples as Samples,
        Start as Start,
        check_horizon as check_horizon,
        check_max_steps as check_max_steps,
        check_start as check_start,
        check_step as check_step,
        check_tolerance as check_tolerance,
        resolve_start as resolve_start,
    )
    from .result import Transient as Transient
    from .stiffness import (
        budget_error as budget_error,
        find_stiffness as find_stiffness,
    )
    from .trajectory import Trajectory as Trajectory, segment_between as segment_between
else:
    from fivtui.lazy import lazily

    __getattr__, __dir__ = lazily(__name__)
