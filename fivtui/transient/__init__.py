"""Transients: request, methods, event loop, result, its files and figure."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .charts import (
        TIME_LABEL,
        PlottedRun,
        column_label,
        contact_strips,
        difference_chart,
        partial_run,
        path_chart,
        phase_chart,
        plotted_run,
        second_half,
        time_chart,
        transient_sheet,
        window_text,
    )
    from .derivatives.variation import EXTREMES, START_SEEDS, Variation, compute_variation
    from .errors import (
        MIN_DIVERGENCE,
        Deviation,
        Divergence,
        Observation,
        deviation,
        divergence,
        finer_tol,
        first_tol,
        observation,
        rounding_error,
    )
    from .files import finite_trajectory
    from .methods import (
        ALL_METHODS,
        FMU_FLAVOURS,
        METHODS,
        check_uses_step,
        fixed_step,
        uses_step,
    )
    from .native import check_taylor_options, integrate, later_amplitude
    from .recorder import Recorder
    from .report import QUANTITY_ROWS, print_transient, transient_rows
    from .request import (
        DEFAULT_TOL,
        MAX_STEPS,
        TOL_RANGE,
        Kernel,
        KernelChoice,
        OnSamples,
        Request,
        Samples,
        check_max_steps,
        resolve_start,
    )
    from .result import Transient
    from .settings.checks import (
        DEFAULT_T_END,
        MAX_T_END,
        QUANTITIES,
        SET_BY_ACCURACY,
        START_SPECS,
        START_THRESHOLD,
        VARIABLES,
        Start,
        check_accuracy,
        check_horizon,
        check_quantity,
        check_start,
        check_step,
        check_tolerance,
    )
    from .settings.options import OVER_TIME, RunOptions, SimulateOptions
    from .settings.table import (
        SETTINGS,
        WITH_SEPARATION,
        WITHOUT_SEPARATION,
        Accuracy,
        RunSetting,
        check_file_number,
        check_file_text,
        setting,
    )
    from .stiffness import find_stiffness, max_steps_error
    from .trajectory import Trajectory, build_trajectory, segment_between
else:
    from fivtui.lazy import lazy_exports

    __getattr__, __dir__ = lazy_exports(__name__)
