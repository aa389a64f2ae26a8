"""Limit cycles and attractors: shooting, basins of attraction, continuation."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .attractor_search import (
        Coexistence as Coexistence,
        attractors as attractors,
        coexistence as coexistence,
    )
    from .basins import basin as basin
    from .branches import continuation as continuation
    from .explorer import Explorer as Explorer
    from .figure import basin_figure as basin_figure, continuation_figure as continuation_figure
    from .files import (
        attractor_to_dict as attractor_to_dict,
        basin_to_dict as basin_to_dict,
        coexistence_to_dict as coexistence_to_dict,
        continuation_to_dict as continuation_to_dict,
        save_basin as save_basin,
        save_continuation as save_continuation,
        warning_along as warning_along,
        warning_in as warning_in,
        warning_of as warning_of,
    )
    from .report import (
        print_attractors as print_attractors,
        print_basin as print_basin,
        print_coexistence as print_coexistence,
        print_continuation as print_continuation,
    )
    from .words import SEARCHING as SEARCHING, coexistence_words as coexistence_words
else:
    from fivtui.lazy import lazily

    __getattr__, __dir__ = lazily(__name__)
