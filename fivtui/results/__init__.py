"""Shared code of results: lists, files, figures, and commands that compute them again."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .base import Comparable, Drawn, Result, Row, SystemResult, equal_values, scene_text
    from .codec import from_data, to_data
    from .grid import Grid, grid_of, over_of, split_grid
    from .kinds import TABLES, Command, Stored, StudyKind, command_for, listed
    from .tables import (
        GridResult,
        Table,
        TableResult,
        Tabular,
        read_result,
        save_table,
    )
else:
    from fivtui.lazy import lazily

    __getattr__, __dir__ = lazily(__name__)
