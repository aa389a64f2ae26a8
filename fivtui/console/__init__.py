"""Console output: tables to stdout, progress to stderr."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .printing import (
        ProgressBar,
        number,
        parameter_line,
        print_list,
        print_rows,
        print_titled,
        terminal_width,
    )
else:
    from fivtui.lazy import lazy_exports

    __getattr__, __dir__ = lazy_exports(__name__)
