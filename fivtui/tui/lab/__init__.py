"""The main screen of the laboratory."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .commands import LabCommands
    from .keyboard import KeyQueue, discard_alt_character, register_alt_keys
    from .keys import KEY_IDS, key_names
    from .screen import LabScreen
    from .terminal_line import TerminalLine
    from .verdict.view import VerdictView
else:
    from fivtui.lazy import lazy_exports

    __getattr__, __dir__ = lazy_exports(__name__)
