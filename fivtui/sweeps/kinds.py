"""The sweep among the studies."""

from typing import TYPE_CHECKING, Final

from fivtui.lazy import later
from fivtui.model import ALL_PARAMETERS, InputError
from fivtui.ranges import number_text
from fivtui.results import Command, Stored, StudyKind, scene_fields

if TYPE_CHECKING:
    from .design import Axis
    from .run import Sweep
    from .study import Study

files, report = later(__name__, "files", "report")
_SAID: Final = (*ALL_PARAMETERS, "start", "t_end", "tol", "accuracy")
_TEXT_BYTES: Final = 20


def _unfinished(result: "Sweep") -> str:
    complete = len(result.table.reasons) >= result.study.members
    return "" if complete else "it is incomplete"


def _command(study: "Study") -> Command:
    from .design import Design
    from .study import BATCHES, DEFAULT_OUTPUTS

    design, both = study.design, len(study.cases) > 1
    if not isinstance(design, Design):
        raise InputError("a scattered sweep: fivtui uncertainty computes it")
    words = []
    if both or not study.cases[0]:
        words.append("--both" if both else "--ignore-separation")
    for name, axis in design.axes.items():
        words += ["--vary", f"{name}={_axis_text(axis)}"]
    if design.kind != "product":
        words += ["--design", design.kind]
    if design.count is not None:
        words += ["--count", str(design.count), "--seed", str(design.seed)]
    if study.outputs != DEFAULT_OUTPUTS:
        words += [word for name in study.outputs for word in ("--output", name)]
    scene = {**scene_fields(study, _SAID), "separation": both or study.cases[0]}
    needed: dict[str, object] = {"over_time": study.over_time}
    if not both:
        needed["separation"] = True
    if study.method == BATCHES:
        needed["method"] = study.method
    else:
        words += ["--method", study.method]
    return Command("sweep", scene, _SAID, words, needed)


def _axis_text(axis: "Axis") -> str:
    from .design import Range

    if not isinstance(axis, Range):
        return ",".join(map(number_text, axis))
    parts = [number_text(axis.start), number_text(axis.stop)]
    parts += [] if axis.count is None else [str(axis.count)]
    return ":".join([*parts, "log"] if axis.log else parts)


SWEEP: Final = StudyKind(
    data="sweep",
    show=report.print_sweep,
    suffixes=(".csv", ".parquet"),
    save=files.save_sweep,
    stem=lambda result: f"sweep-{'-'.join(result.study.design.axes)}",
    load=files.read_sweep,
    folders=(".parts",),
    header=frozenset({"sweep"}),
    json_keys=frozenset({"columns", "rows"}),
    json_refusal="does not say which sweep it is from; read the file of sweep --out",
    command=_command,
    stored=Stored(
        ".csv",
        size=lambda result: _TEXT_BYTES * len(result.table.reasons) * len(result.columns),
        unfinished=_unfinished,
    ),
)
