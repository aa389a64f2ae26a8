"""The tabs of the laboratory."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .book import TabBook as TabBook
    from .exports.clipboard import copy_picture as copy_picture
    from .exports.export import (
        KINDS as KINDS,
        Export as Export,
        check_scene_path as check_scene_path,
        save_scene_as as save_scene_as,
        write_export as write_export,
    )
    from .job_pane import JobBar as JobBar, JobPane as JobPane
    from .messages import (
        ExportEnded as ExportEnded,
        FieldEdited as FieldEdited,
        FieldFocused as FieldFocused,
        FieldStepped as FieldStepped,
        LiveEnded as LiveEnded,
        LiveRequested as LiveRequested,
        PointOpened as PointOpened,
        Reported as Reported,
        ResultsRestored as ResultsRestored,
        RunActionRequested as RunActionRequested,
        RunEnded as RunEnded,
        RunRead as RunRead,
        RunRequested as RunRequested,
        RunsChanged as RunsChanged,
        SceneLoaded as SceneLoaded,
        SceneSaved as SceneSaved,
        SearchUpdated as SearchUpdated,
        SessionRequested as SessionRequested,
        StudyRead as StudyRead,
        TablesChosen as TablesChosen,
    )
    from .pane import Pane as Pane
    from .tables import ListTable as ListTable, flowed as flowed, grid as grid
    from .tabs import TABS as TABS, TabSpec as TabSpec
    from .views_pane import ViewsPane as ViewsPane
else:
    from fivtui.lazy import lazily

    __getattr__, __dir__ = lazily(__name__)
