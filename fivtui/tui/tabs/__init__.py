"""The tabs of the laboratory."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .export import EXPORT_KINDS, Export, check_scene_path, copy_picture
    from .job_pane import ActionPane, compute_in_thread
    from .messages import (
        FieldEdited,
        FieldFocused,
        FieldStepped,
        LiveRequested,
        PointRunRequested,
        Reported,
        RunActionRequested,
        RunRequested,
        RunsChanged,
        SceneLoaded,
        TabKeyPressed,
    )
    from .pane import Pane
    from .paper import panel_scene
    from .search import SearchableList
    from .studies.study_pane import StudyPane
    from .tab_book import TABS, TabBook, TabSpec
    from .tab_line import TabLine
    from .tables import ListTable, RowsView, flow_facts, rows_table, shorten
    from .views_pane import ViewsPane
else:
    from fivtui.lazy import lazy_exports

    __getattr__, __dir__ = lazy_exports(__name__)
