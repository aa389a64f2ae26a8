"""Kind of study: the sweep."""

from operator import attrgetter
from typing import TYPE_CHECKING, Final

from fivtui.lazy import lazy_modules
from fivtui.model import InputError
from fivtui.ranges import number_text
from fivtui.results import Command, Storage, StudyKind, command_for

from .options import SweepOptions

if TYPE_CHECKING:
    from .design import Axis
    from .run import Sweep
    from .study import Study

files, report = lazy_modules(__name__, "files", "report")
# Approximate size of a value in a file of rows.
_CELL_BYTES: Final = 20


def _incomplete_reason(result: "Sweep") -> str:
    complete = result.table.members >= result.study.members
    return "" if complete else "it is incomplete"


def _command(study: "Study") -> Command:
    from .design import Design
    from .study import DEFAULT_OUTPUTS

    design, has_both_cases = study.design, len(study.cases) > 1
    if not isinstance(design, Design):
        raise InputError("a scattered sweep: fivtui uncertainty computes it")
    options = SweepOptions(
        varied=tuple(f"{name}={_axis_text(axis)}" for name, axis in design.axes.items()),
        design=design.kind,
        count=design.count,
        seed=design.seed,
        starts=design.starts,
        both=has_both_cases,
        outputs=() if study.outputs == DEFAULT_OUTPUTS else study.outputs,
    )
    return command_for(
        "sweep",
        study,
        options,
        # The option --both already decides on separation.
        varied=("separation",) if has_both_cases else (),
        # The option --over-time takes a file, not tables: the scene must have them.
        scene_only={"over_time": study.over_time},
        separation=study.cases[0],
    )


def _axis_text(axis: "Axis") -> str:
    from .design import Range

    if not isinstance(axis, Range):
        return ",".join(map(number_text, axis))
    parts = [number_text(axis.start), number_text(axis.stop)]
    parts += [] if axis.count is None else [str(axis.count)]
    return ":".join([*parts, "log"] if axis.log else parts)


SWEEP: Final = StudyKind(
    contents_name="sweep",
    show=report.print_sweep,
    failure=attrgetter("table.failure"),
    suffixes=(".csv", ".parquet"),
    save=files.save_sweep,
    stem=lambda result: f"sweep-{'-'.join(result.study.design.axes)}",
    load=files.read_sweep,
    folders=(".parts",),
    header_keys=frozenset({"sweep"}),
    json_keys=frozenset({"columns", "rows"}),
    # Follows the name of a file in an error.
    json_refusal="has no description of its sweep; read the file that sweep --out wrote",
    command=_command,
    storage=Storage(
        ".csv",
        size=lambda result: _CELL_BYTES * result.table.members * len(result.columns),
        reason_not_to_store=_incomplete_reason,
    ),
)
