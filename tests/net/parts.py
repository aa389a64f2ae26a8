"""The recorded parts of the program's output; each has one file of recordings."""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Final

from tests.net.bits import COMPILED_KINDS, INTERPRETED_KINDS, record_bits
from tests.net.commands import read_groups, record_commands
from tests.net.fmus import record_fmus
from tests.net.results import record_results, record_stored_files
from tests.net.tabs import SIZES, record_tabs

PARTS: Final[Mapping[str, Callable[[], str]]] = {
    **{f"tabs-{size[0]}x{size[1]}": partial(record_tabs, size) for size in SIZES},
    **{f"commands-{group}": partial(record_commands, group) for group in read_groups()},
    "results": record_results,
    "stored-files": record_stored_files,
    "fmus": record_fmus,
    "bits": partial(record_bits, COMPILED_KINDS),
    "bits-interpreted": partial(record_bits, INTERPRETED_KINDS),
}
