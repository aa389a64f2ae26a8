"""Scenes: what to compute, by name, and its computation."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .comparison import compare, comparison_files
    from .files import (
        find_scene,
        load_scene,
        save_scene,
        scene_file,
        scene_from_dict,
        scene_to_dict,
    )
    from .over_time import OverTime, over_time_to_dict, parse_over_time, read_over_time
    from .presets import DEFAULT_PRESET, PRESETS
    from .report import print_comparison
    from .run import DivergenceError, SceneTransient, find_divergence, scene_transient
    from .scene import Scene, make_scene
else:
    from fivtui.lazy import lazy_exports

    __getattr__, __dir__ = lazy_exports(__name__)
