"""The paper's statements, compared with the model."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .check import claims
else:
    from fivtui.lazy import lazy_exports

    __getattr__, __dir__ = lazy_exports(__name__)
