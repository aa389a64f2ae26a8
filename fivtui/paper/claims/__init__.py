"""The paper's statements, compared with the model."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .check import claims
else:
    from fivtui.lazy import lazily

    __getattr__, __dir__ = lazily(__name__)
