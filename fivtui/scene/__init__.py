"""Scenes: what to compute, by name, and its computation."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .comparison import compare as compare, comparison_files as comparison_files
    from .files import (
        find_scene as find_scene,
        load_scene as load_scene,
        save_scene as save_scene,
        scene_file as scene_file,
        scene_from_dict as scene_from_dict,
        scene_to_dict as scene_to_dict,
    )
    from .over_time import (
        OverTime as OverTime,
        over_time_from as over_time_from,
        over_time_to_dict as over_time_to_dict,
        read_over_time as read_over_time,
    )
    from .presets import DEFAULT_PRESET as DEFAULT_PRESET, PRESETS as PRESETS
    from .report import print_comparison as print_comparison
    from .run import run_scene as run_scene, scene_transient as scene_transient
    from .scene import Accuracy as Accuracy, Scene as Scene, as_scene as as_scene
    from .verified import PartedError as PartedError, runs_part as runs_part
else:
    from fivtui.lazy import lazily

    __getattr__, __dir__ = lazily(__name__)
