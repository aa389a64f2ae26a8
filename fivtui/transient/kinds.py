"""The kind of study of a transient: how its files are recognised, read, stored and printed."""

from typing import Final

from fivtui.lazy import lazy_modules
from fivtui.results import TABLE_SUFFIXES, Storage, StudyKind, command_for

from .settings.options import SimulateOptions

files, report = lazy_modules(__name__, "files", "report")
# Bytes per sample: seven columns of eight bytes.
_SAMPLE_BYTES: Final = 56

RUN: Final = StudyKind(
    contents_name="trajectory",
    show=report.print_transient,
    suffixes=TABLE_SUFFIXES,
    save=files.save_trajectory,
    load=files.load_transient,
    # A table is recognised as a trajectory by these keys of its header, JSON by the next ones.
    header_keys=frozenset({"method", "t_end"}),
    json_keys=frozenset({"final", "peak"}),
    json_refusal="has no trajectory; read the file that simulate --out wrote",
    # The arguments leave out parameters over time: the scene file must have them.
    command=lambda scene: command_for(
        "simulate", scene, SimulateOptions(), scene_only={"over_time": scene.over_time}
    ),
    storage=Storage(
        suffix=".npz",
        save=files.store_transient,
        load=files.restore_transient,
        size=lambda run: (
            0 if run.trajectory is None else _SAMPLE_BYTES * int(run.trajectory.t.size)
        ),
    ),
)
