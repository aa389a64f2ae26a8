"""Shared code of results: tables, files, figures, and the commands that compute a result."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .base import Comparable, Plottable, Result, Row, SystemResult, equal_values, scene_text
    from .codec import check_finite, from_data, not_finite_error, to_data
    from .grid import Grid, axes_from_data, build_grid, split_grid
    from .kinds import TABLE_SUFFIXES, Command, Storage, StudyKind, command_for, list_printer
    from .tables import (
        GridResult,
        Table,
        TableResult,
        Tabular,
        read_result,
        save_table,
    )
else:
    from fivtui.lazy import lazy_exports

    __getattr__, __dir__ = lazy_exports(__name__)
