"""The main screen of the laboratory."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .commands import LabCommands as LabCommands
    from .keyboard import (
        KeyQueue as KeyQueue,
        know_alt_keys as know_alt_keys,
        take_for_alt as take_for_alt,
    )
    from .keys import KEY_IDS as KEY_IDS
    from .screen import LabScreen as LabScreen
else:
    from fivtui.lazy import lazily

    __getattr__, __dir__ = lazily(__name__)
