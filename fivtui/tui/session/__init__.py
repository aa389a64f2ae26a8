"""The state of the laboratory without its screen. Imports no Textual."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .command_lines import study_line as study_line
    from .comparison import (
        change_rows as change_rows,
        changes as changes,
        engine_words as engine_words,
        percent_text as percent_text,
    )
    from .equations import plain_names as plain_names, symbol_of as symbol_of
    from .fields import (
        CONSIDERED as CONSIDERED,
        FIELDS as FIELDS,
        IGNORED as IGNORED,
        FormField as FormField,
    )
    from .help import WELCOME as WELCOME, field_help as field_help, general_help as general_help
    from .history import Edited as Edited
    from .jobs import (
        PRECEDENCE as PRECEDENCE,
        WRITING as WRITING,
        ComputingThreads as ComputingThreads,
        Job as Job,
        Outcome as Outcome,
        crash_words as crash_words,
        outcome_of as outcome_of,
    )
    from .live import (
        AT_ONCE_S as AT_ONCE_S,
        Live as Live,
        LiveJob as LiveJob,
        LiveRun as LiveRun,
        Pace as Pace,
        execute_live as execute_live,
    )
    from .report import (
        SECOND_HALF as SECOND_HALF,
        Coexisting as Coexisting,
        coexisting_rows as coexisting_rows,
        quantity as quantity,
        remark as remark,
        result_brief as result_brief,
        stability_brief as stability_brief,
        verdict_kind as verdict_kind,
    )
    from .runs import (
        MAX_RUNS as MAX_RUNS,
        SOLVER as SOLVER,
        Run as Run,
        Runs as Runs,
        RunState as RunState,
        RunStyle as RunStyle,
        execute as execute,
        usual_style as usual_style,
    )
    from .scene_differences import (
        base_scene as base_scene,
        differences as differences,
        names_of as names_of,
    )
    from .scenes_of_paper import paper_scenes as paper_scenes
    from .session import Session as Session
    from .studies import (
        CHARTS as CHARTS,
        DisplayedStudy as DisplayedStudy,
        StoredResult as StoredResult,
        check_drawable as check_drawable,
    )
else:
    from fivtui.lazy import lazily

    __getattr__, __dir__ = lazily(__name__)
