"""Runs of any co-simulation FMU by fmpy: checks before the run, the run, and its result."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from textwrap import shorten
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from fivtui.io import save_csv
from fivtui.model import (
    Cancelled,
    Column,
    ComputationError,
    InputError,
    Interval,
    OnProgress,
    check_known,
    check_names,
)
from fivtui.results import Result, Table, Tabular
from fivtui.taylor import TOL_RANGE

from .inputs import NON_NUMERIC_TYPES, TIME, check_start_values, enable_belt_speed, read_signals
from .instance import FmuFile, create_instance, defer_interrupts, extract_fmu

# Communication steps: limit per run, number by default, and between two reports of progress.
_MAX_STEPS: Final = 20_000_000
_DEFAULT_STEPS: Final = 1000
_STEPS_PER_REPORT: Final = 128
# Most characters of a row of the summary.
_SUMMARY_LENGTH: Final = 150


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class FmuRun(Result, Tabular):
    """Recorded variables of an FMU run.

    Attributes
    ----------
    model : str
        Name of the model.
    fmi_version : str
        Version of FMI that the FMU implements.
    columns : dict of str to ndarray, shape (n, …)
        ``time`` and the variables recorded, by name.
    units : dict of str to str
        Units of the columns that have one, by name.
    discrete : dict of str to ndarray, shape (n,)
        Outputs and recorded variables that change only at events, by name.
    warnings : tuple of str
        Warnings that the FMU logged.
    """

    model: str
    fmi_version: str
    columns: dict[str, NDArray[Any]]
    units: dict[str, str]
    discrete: dict[str, NDArray[Any]]
    warnings: tuple[str, ...] = ()

    def events(self) -> list[tuple[float, str, Any]]:
        """Changes of discrete variables: time of the first row with the value, s; name; value."""
        times = self.columns[TIME]
        events = [
            (float(times[row + 1]), name, values[row + 1].item())
            for name, values in self.discrete.items()
            for row in np.flatnonzero(np.diff(values.astype(float)))
        ]
        return sorted(events, key=lambda event: event[0])

    def _summary(self) -> list[tuple[str, str]]:
        times = self.columns[TIME]
        recorded = ", ".join(name for name in self.columns if name != TIME)
        return [
            ("model", f"{self.model}, FMI {self.fmi_version}"),
            ("points", f"{times.size}, {times[0]:g} to {times[-1]:g} s"),
            ("recorded", shorten(recorded, _SUMMARY_LENGTH, placeholder=" …")),
            *(("warning", text) for text in self.warnings),
        ]

    def to_dict(self) -> dict[str, Any]:
        """The object that ``fivtui fmu run --json`` prints: the last value of every column."""
        final = {name: column[-1].tolist() for name, column in self.columns.items()}
        return self._header() | {"final": final}

    def _table(self) -> Table:
        table: Table = {}
        for name, values in self.columns.items():
            unit = self.units.get(name, "")
            elements = values.reshape(values.shape[0], -1).T
            names = [name] if values.ndim == 1 else [f"{name}[{i}]" for i in range(len(elements))]
            table |= {Column(n, unit, ""): v for n, v in zip(names, elements, strict=True)}
        return table

    def _header(self) -> dict[str, Any]:
        return {"model": self.model, "fmi_version": self.fmi_version}


def run_fmu(
    path: str | Path,
    *,
    t_end: float | None = None,
    output_interval: float | None = None,
    start_values: Mapping[str, object] | None = None,
    outputs: Sequence[str] | None = None,
    input_csv: str | Path | None = None,
    tol: float | None = None,
    progress: OnProgress | None = None,
) -> FmuRun:
    """Run an FMU for co-simulation, FMI 2.0 or 3.0.

    Parameters
    ----------
    path : str or Path
        The FMU.
    t_end : float, optional
        Stop time, s; by default that of the FMU's default experiment, else 1 s after the start.
    output_interval : float, optional
        Communication step, s; by default that of the default experiment, else a thousandth of the
        run.
    start_values : mapping of str to number, bool or text, optional
        Parameters, inputs and start values by name. If the FMU has a flag ``finite_belt``, without
        which ``v_belt`` has no effect, a value of ``v_belt`` makes it true, unless it is given.
    outputs : sequence of str, optional
        Variables to record; all outputs if not given.
    input_csv : str or Path, optional
        Table of inputs over time, with a column ``time`` and one per input. Real inputs are
        interpolated; two equal times are a jump. Inputs without a column keep their start value.
    tol : float, optional
        Relative tolerance; by default that of the default experiment.
    progress : callable, optional
        Called repeatedly with the fraction done; cancels the run by returning False.

    Returns
    -------
    FmuRun
        Time and the variables recorded.

    Raises
    ------
    InputError
        If the file is not an FMU for co-simulation, or a name or value is wrong.
    ComputationError
        If the FMU fails or its outputs are not finite, with the FMU's log.
    Cancelled
        If `progress` returned False.

    Examples
    --------
    >>> from fivtui import build_fmu, run_fmu
    >>> fmu = build_fmu("belt.fmu")
    >>> run = run_fmu(fmu, t_end=1.0, output_interval=0.1, start_values={"F": 60.0}, outputs=["y"])
    >>> run.columns["y"].shape, run.units["y"]
    ((11,), 'm')
    """
    with extract_fmu(Path(path)) as fmu:
        start, stop, step = _check_experiment(fmu, t_end, output_interval)
        values = check_start_values(fmu, start_values or {})
        recorded = _check_outputs(fmu, outputs)
        signals, columns = (
            (None, set()) if input_csv is None else read_signals(fmu, Path(input_csv), values)
        )
        values = enable_belt_speed(fmu, values, columns)
        options = {
            "start_time": start,
            "stop_time": stop,
            "output_interval": step,
            "start_values": values,
            "output": None if recorded is None else [*recorded, *_discrete_outputs(fmu, recorded)],
            "input": signals,
            "relative_tolerance": _check_tolerance(fmu, tol),
        }
        table, warnings = _simulate(fmu, (start, stop), options, progress)
        return _build_run(fmu, table, recorded, warnings)


def _check_experiment(
    fmu: FmuFile, t_end: float | None, output_interval: float | None
) -> tuple[float, float, float]:
    default = fmu.description.defaultExperiment
    start = float(getattr(default, "startTime", None) or 0.0)
    stop = float(getattr(default, "stopTime", None) or start + 1.0)
    stop = Interval(start, unit="s", lower_open=True).check(
        "t_end", stop if t_end is None else t_end
    )
    step = float(getattr(default, "stepSize", None) or (stop - start) / _DEFAULT_STEPS)
    if output_interval is not None:
        step = Interval(0.0, stop - start, "s", lower_open=True).check(
            "output interval", output_interval
        )
    if (stop - start) / step > _MAX_STEPS:
        raise InputError(
            f"output interval = {step:g} s: a run may have at most {_MAX_STEPS} intervals"
        )
    return start, stop, step


def _check_tolerance(fmu: FmuFile, tol: float | None) -> float | None:
    if tol is None:
        return None
    is_fivtui = str(fmu.description.generationTool).startswith("fivtui")
    lower, upper = TOL_RANGE if is_fivtui else (0.0, 1.0)
    return Interval(lower, upper, lower_open=not is_fivtui).check("tolerance", tol)


def _check_outputs(fmu: FmuFile, outputs: Sequence[str] | None) -> list[str] | None:
    if outputs is None:
        return None
    names = [v.name for v in fmu.description.modelVariables]
    recorded = check_names("outputs", outputs)
    for name in recorded:
        check_known("output", name, names)
    return list(recorded)


def _discrete_outputs(fmu: FmuFile, recorded: Sequence[str]) -> list[str]:
    # The discrete outputs, for events, that are not recorded.
    return [
        v.name
        for v in fmu.description.modelVariables
        if v.causality == "output"
        and v.variability == "discrete"
        and v.type not in NON_NUMERIC_TYPES
        and v.name not in recorded
    ]


def _simulate(
    fmu: FmuFile,
    span: tuple[float, float],
    options: Mapping[str, Any],
    progress: OnProgress | None,
) -> tuple[NDArray[Any], tuple[str, ...]]:
    from fmpy import simulate_fmu

    start, stop = span
    steps, cancelled = 0, False
    with defer_interrupts() as check_interrupt, create_instance(fmu) as (instance, messages):

        def after_step(t: float, _recorder: object) -> bool:
            nonlocal steps, cancelled
            check_interrupt()
            steps += 1
            if progress and steps % _STEPS_PER_REPORT == 0:
                cancelled = not progress(min((t - start) / (stop - start), 1.0))
            return not cancelled

        try:
            table: NDArray[Any] = simulate_fmu(
                fmu.folder,
                validate=False,
                model_description=fmu.description,
                fmu_instance=instance,
                step_finished=after_step,
                **options,
            )
        except Exception as error:  # noqa: BLE001
            reason = messages.last or " ".join(str(error).split())
            raise ComputationError(
                f"the FMU fails: {reason}", "check its start values and inputs"
            ) from None
        if cancelled:
            raise Cancelled
        final_time = float(table[TIME][-1])
        if final_time < stop and not math.isclose(final_time, stop):
            reason = messages.last or "it logged no reason"
            raise ComputationError(
                f"the FMU stops at t = {final_time:.6g} s: {reason}",
                "check its start values and inputs",
            )
    if progress:
        progress(1.0)
    return table, messages.warnings


def _build_run(
    fmu: FmuFile, table: NDArray[Any], recorded: list[str] | None, warnings: tuple[str, ...]
) -> FmuRun:
    description = fmu.description
    all_columns = {name: np.asarray(table[name]) for name in table.dtype.names or ()}
    names = [name for name in all_columns if recorded is None or name == TIME or name in recorded]
    for name, column in all_columns.items():
        if not np.all(np.isfinite(column)):
            raise ComputationError(
                f"the FMU's variable {name} is not finite", "check its start values and inputs"
            )
    units = {
        v.name: v.unit or getattr(v.declaredType, "unit", None) for v in description.modelVariables
    }
    return FmuRun(
        model=description.modelName,
        fmi_version=description.fmiVersion,
        columns={name: all_columns[name] for name in names},
        units={TIME: "s", **{name: str(units[name]) for name in names if units.get(name)}},
        discrete={
            v.name: all_columns[v.name]
            for v in description.modelVariables
            if v.name in all_columns
            and v.variability == "discrete"
            and all_columns[v.name].ndim == 1
        },
        warnings=warnings,
    )


def save_fmu_events(run: FmuRun, path: Path) -> None:
    """Write changes at events as ``.csv``: time, name, value; `InputError` if that fails."""
    events = run.events()
    columns: dict[str, list[Any]] = {
        "time": [t for t, _, _ in events],
        "name": [name for _, name, _ in events],
        "value": [value for _, _, value in events],
    }
    save_csv(path, "FMU events", columns, {})


def save_fmu_run(run: FmuRun, path: Path) -> None:
    """Write the outputs of an FMU as ``.csv`` without loss; `InputError` if that fails."""
    save_csv(path, "FMU result", run.to_columns(), run._header() | {"units": run.units})
