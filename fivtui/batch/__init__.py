"""Compute many transients with one call."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .result import BATCH_COLUMNS, Batch
    from .run import Requirement, simulate_batch
else:
    from fivtui.lazy import lazy_exports

    __getattr__, __dir__ = lazy_exports(__name__)
