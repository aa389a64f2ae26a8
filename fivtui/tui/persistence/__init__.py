"""Saves and restores sessions. Imports no Textual."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .autosave import Autosave as Autosave
    from .config import config_path as config_path, load_config as load_config
    from .imports import load_run as load_run, load_study as load_study
    from .slots import Slot as Slot
    from .snapshot import (
        restore_results as restore_results,
        restore_session as restore_session,
        state_of as state_of,
    )
    from .state_file import State as State, load_state as load_state, state_path as state_path
else:
    from fivtui.lazy import lazily

    __getattr__, __dir__ = lazily(__name__)
