"""What results have in common: how they are listed, stored, read, drawn and computed anew."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .base import (
        Comparable as Comparable,
        Result as Result,
        Row as Row,
        SystemResult as SystemResult,
        equal_values as equal_values,
        scene_text as scene_text,
    )
    from .codec import from_data as from_data, to_data as to_data
    from .grid import Grid as Grid, grid_of as grid_of, over_of as over_of, split_grid as split_grid
    from .kinds import (
        PHYSICS as PHYSICS,
        Command as Command,
        Stored as Stored,
        StudyKind as StudyKind,
        listed as listed,
        scene_fields as scene_fields,
    )
    from .tables import (
        GridResult as GridResult,
        Table as Table,
        TableResult as TableResult,
        by_name as by_name,
        read_result as read_result,
        save_result as save_result,
        save_table as save_table,
    )
else:
    from fivtui.lazy import lazily

    __getattr__, __dir__ = lazily(__name__)
