"""Saves and restores sessions. Imports no Textual."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .autosave import Autosave
    from .config import Config, load_config
    from .slots import Slot
    from .state_file import (
        State,
        load_session,
        restore_results,
        session_state,
        user_files,
    )
else:
    from fivtui.lazy import lazy_exports

    __getattr__, __dir__ = lazy_exports(__name__)
