"""The state of the laboratory without its screen. Imports no Textual."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .command_lines import study_line
    from .comparison import change_rows, changes, engine_words, percent_text
    from .editing import Edited
    from .equations import plain_names, symbol_of
    from .fields import FIELDS, FormField
    from .help import WELCOME, field_help, general_help
    from .jobs import PRECEDENCE, WRITING, ComputingThreads, Job, Outcome, crash_words, outcome_of
    from .live import AT_ONCE_S, Live, LiveJob, LiveRun, Pace, execute_live
    from .report import (
        SECOND_HALF,
        Coexisting,
        coexisting_rows,
        quantity,
        remark,
        result_brief,
        stability_brief,
        verdict_kind,
    )
    from .runs import MAX_RUNS, SOLVER, Run, Runs, RunState, RunStyle, execute, usual_style
    from .scene_differences import base_scene, differences, names_of
    from .scenes_of_paper import paper_scenes
    from .session import Session
    from .studies import DisplayedStudy, StoredResult, check_drawable
else:
    from fivtui.lazy import lazily

    __getattr__, __dir__ = lazily(__name__)
