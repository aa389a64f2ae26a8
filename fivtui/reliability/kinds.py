"""The uncertainty study among the studies."""

from typing import Any, Final

from fivtui.lazy import later
from fivtui.model import ALL_PARAMETERS
from fivtui.results import Command, Stored, StudyKind, scene_fields

files, report = later(__name__, "files", "report")
_SAID: Final = (*ALL_PARAMETERS, "separation", "start", "t_end", "tol")
_SUFFIXES: Final = (".csv", ".parquet")
_TEXT_BYTES: Final = 20


def _command(study: Any) -> Command:
    from .request import DEFAULT_OUTPUTS, JUDGED
    from .result import scatter_of

    design = scatter_of(study)
    words = [word for name, each in design.axes.items() for word in ("--vary", f"{name}~{each}")]
    if design.kind != "sobol":
        words += ["--design", design.kind]
    words += ["--samples", str(design.samples), "--repeats", str(design.repeats)]
    words += ["--seed", str(design.seed)]
    if not design.indices:
        words.append("--no-indices")
    outputs = tuple(name for name in study.outputs if name not in JUDGED)
    if set(outputs) != set(DEFAULT_OUTPUTS) - set(JUDGED):
        words += [word for name in outputs for word in ("--output", name)]
    scene = {**scene_fields(study, ("start", "t_end", "tol")), "separation": study.cases[0]}
    scene["correlation"] = design.correlations
    return Command("uncertainty", scene, _SAID, words, {"correlation": design.correlations})


UNCERTAINTY: Final = StudyKind(
    data="uncertainty study",
    show=report.print_uncertainty,
    rows=report.uncertainty_rows,
    warning=report.warning_of,
    suffixes=_SUFFIXES,
    save=files.save_uncertainty,
    as_json=True,
    stem=lambda result: f"uncertainty-{'-'.join(result.inputs)}",
    load=files.read_uncertainty,
    header=frozenset({"sweep", "scattered"}),
    json_keys=frozenset({"probabilities", "quantiles", "inputs"}),
    json_refusal="does not have the samples; read the file of uncertainty --out",
    command=_command,
    stored=Stored(
        ".csv",
        size=lambda result: _TEXT_BYTES * result.study.members * len(result.sweep.columns),
    ),
)
