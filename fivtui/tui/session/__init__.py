"""The state of the laboratory without its screen. Imports no Textual."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .command_lines import study_command
    from .comparison import change_rows, engine_difference_text, percent_text
    from .editing import EditState
    from .equations import EQUATIONS, replace_symbols, symbol_of
    from .fields import FIELDS, FormField, scene_texts
    from .help import HINTS, field_help, welcome_text
    from .jobs import (
        FILE_WRITES,
        SCREEN_RESPONSE,
        ComputingThreads,
        Job,
        Outcome,
        compute_outcome,
        crash_message,
        duration_text,
    )
    from .live import MAX_IMMEDIATE_S, LiveJob, LiveRun, Pace
    from .report import (
        Attractors,
        attractor_rows,
        late_separation_warning,
        quantity_text,
        result_summary,
        stability_summary,
        verdict_kind,
    )
    from .runs import (
        MAX_RUNS,
        NATIVE_ENGINE,
        Run,
        Runs,
        RunState,
        compute_scene,
        execute,
    )
    from .scene_differences import (
        base_scene,
        change_texts,
        difference_text,
        legend_names,
    )
    from .session import (
        SAFETY_MAPS,
        DisplayedStudy,
        ResultKey,
        Session,
        StoredResult,
        check_drawable,
        study_key,
    )
else:
    from fivtui.lazy import lazy_exports

    __getattr__, __dir__ = lazy_exports(__name__)
