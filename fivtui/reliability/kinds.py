"""Kind of study: the uncertainty study."""

from operator import attrgetter
from typing import Any, Final

from fivtui.lazy import lazy_modules
from fivtui.results import Command, Storage, StudyKind, command_for

from .options import UncertaintyOptions

report, result = lazy_modules(__name__, "report", "result")
_SUFFIXES: Final = (".csv", ".parquet")
_BYTES_PER_NUMBER: Final = 20


def _command(study: Any) -> Command:
    # The command line that computes a study again.
    from .request import DEFAULT_OUTPUTS, STABILITY_OUTPUTS
    from .result import scattered_design

    design = scattered_design(study)
    # Every study has the outputs of stability, without an option.
    outputs = tuple(name for name in study.outputs if name not in STABILITY_OUTPUTS)
    default_outputs = [name for name in DEFAULT_OUTPUTS if name not in STABILITY_OUTPUTS]
    options = UncertaintyOptions(
        varied=tuple(f"{name}~{axis}" for name, axis in design.axes.items()),
        samples=design.samples,
        design=design.kind,
        repeats=design.repeats,
        seed=design.seed,
        # Where indices are possible, they are computed without an option (None).
        indices=None if design.indices else False,
        outputs=() if set(outputs) == set(default_outputs) else outputs,
    )
    return command_for(
        "uncertainty",
        study,
        options,
        scene_only={"correlation": design.correlations},
        scattered=design.axes,
        # A scattered study has one case: separation considered (True) or ignored.
        separation=study.cases[0],
        correlation=design.correlations,
    )


UNCERTAINTY: Final = StudyKind(
    contents_name="uncertainty study",
    show=report.print_uncertainty,
    rows=report.uncertainty_rows,
    warning=report.study_warning,
    failure=attrgetter("sweep.table.failure"),
    suffixes=_SUFFIXES,
    save=result.save_uncertainty,
    as_json=True,
    stem=lambda result: f"uncertainty-{'-'.join(result.inputs)}",
    load=result.read_uncertainty,
    header_keys=frozenset({"sweep", "scattered"}),
    json_keys=frozenset({"probabilities", "quantiles", "inputs"}),
    json_refusal="has no samples; read the file that uncertainty --out wrote",
    command=_command,
    storage=Storage(
        ".csv",
        size=lambda result: _BYTES_PER_NUMBER * result.study.members * len(result.sweep.columns),
    ),
)
