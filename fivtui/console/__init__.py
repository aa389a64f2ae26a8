"""Console output: tables to stdout, progress to stderr."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .numbers import number as number
    from .printing import (
        ProgressBar as ProgressBar,
        parameter_line as parameter_line,
        print_list as print_list,
        print_rows as print_rows,
        print_rows_of as print_rows_of,
        print_titled as print_titled,
        terminal_width as terminal_width,
    )
else:
    from fivtui.lazy import lazily

    __getattr__, __dir__ = lazily(__name__)
