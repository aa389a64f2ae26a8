"""Measure error and CPU time of every method on a scene.

The setting of a method is its tolerance or its step. Errors are deviations from a reference run.
"""

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple, cast

import numpy as np

from fivtui.batch import Requirement, simulate_batch
from fivtui.fmu import run_fmu
from fivtui.io import temporary_folder
from fivtui.kernel import stepping_kernel
from fivtui.model import (
    Cancelled,
    ComputationError,
    Mode,
    OnProgress,
    Parameters,
    Progress,
    State,
    time_scale,
)
from fivtui.results import Plottable, Result, Table, Tabular, scene_text
from fivtui.scene import Scene, find_divergence, make_scene
from fivtui.simulation import compute
from fivtui.transient import (
    DEFAULT_TOL,
    FMU_FLAVOURS,
    METHODS,
    QUANTITIES,
    TOL_RANGE,
    Deviation,
    KernelChoice,
    Observation,
    Start,
    Transient,
    deviation,
    observation,
    resolve_start,
)

from .settings import Ladder, MeasuredSetting, Setting, ladders

if TYPE_CHECKING:
    from fivtui.charts import Sheet

# CPU time of a whole measurement, s.
QUICK_S: Final = 7.0
THOROUGH_S: Final = 120.0
# Fraction of that CPU time for each method; rk4-across is RK4 without location of switches.
_SHARES: Final = {
    "taylor": 0.1,
    "scipy-dop853": 0.1,
    "scipy-lsoda": 0.1,
    "scipy-radau": 0.1,
    "rk4": 0.25,
    "rk4-across": 0.1,
    "fmu": 0.1,
    "fmu-native": 0.05,
}
# The CPU time is about proportional to setting^−exponent.
_COST_EXPONENT: Final = {"tol": 0.1, "step": 0.7}
# A run is repeated up to this CPU time, s, and this number of runs; the least time counts.
_REPEAT_UNTIL_S: Final = 0.02
_MOST_REPEATS: Final = 15
# Number of samples of the trajectory whose cost is measured.
_SAMPLES: Final = 5001
# Number of batches per measurement, and of members per batch.
_BATCH_RUNS: Final = 3
_BATCH_MEMBERS: Final = 64
# Tolerances of the reference, and of a run that shows the uncertainty of the reference.
_REFERENCE_TOL: Final = TOL_RANGE[0]
_CHECK_TOL: Final = 10.0 * TOL_RANGE[0]


@dataclass(frozen=True, slots=True)
class Feature:
    """The cost of a feature of a scene.

    Attributes
    ----------
    name : str
        The feature.
    without_s, with_s : float or None
        CPU time of a compiled run without and with it, s; None if that run did not finish.
    without_steps, with_steps : int or None
        Integration steps of those runs.
    """

    name: str
    without_s: float | None
    with_s: float | None
    without_steps: int | None
    with_steps: int | None


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Tradeoff(Result, Tabular, Plottable):
    """Errors and CPU times of every method on a scene.

    Attributes
    ----------
    scene : Scene
        The scene.
    reference : Transient or None
        The run that errors are measured against: Taylor at the least tolerance. None if read from a
        file.
    floor : Deviation
        Uncertainty of the reference: its deviation from a run at ten times the tolerance and from
        a run in interpreted Python. Smaller errors are not significant.
    rows : list of MeasuredSetting
        Every setting, grouped by method, from coarse to fine.
    features : list of Feature
        The cost of each feature of the scene.
    targets : mapping of str to float
        Error targets by quantity: reports name the cheapest setting that meets each of them. Empty
        unless the command line sets them.
    """

    scene: Scene
    reference: Transient | None
    floor: Deviation
    rows: list[MeasuredSetting]
    features: list[Feature]
    targets: Mapping[str, float] = field(default_factory=dict)

    def _summary(self) -> list[tuple[str, str]]:
        rows = [
            ("scene", f"{scene_text(self.scene.system)}; {self.scene.t_end:g} s"),
            ("uncertainty", f"{self.floor.of('peak'):.2g} of the peak"),
        ]
        for label in dict.fromkeys(row.setting.label for row in self.rows):
            measured = [
                (row.error.of("peak"), row.cpu_s)
                for row in self.rows
                if row.setting.label == label and row.error is not None
            ]
            text = "no run finished"
            if measured:
                error, cpu_s = min(measured)
                text = f"peak to {error:.1g} in {cpu_s:.2g} s"
            rows.append((label, text))
        return rows

    def to_dict(self) -> dict[str, Any]:
        """The object that ``fivtui tradeoff --json`` prints."""
        from .files import tradeoff_to_dict

        return tradeoff_to_dict(self)

    def _table(self) -> Table:
        from .files import tradeoff_table

        return tradeoff_table(self)

    def _sheet(self) -> "Sheet":
        from .charts import tradeoff_sheet

        return tradeoff_sheet(self)


def tradeoff(
    scene: Scene | Parameters | None = None,
    *,
    t_end: float | None = None,
    separation: bool | None = None,
    start: Start | None = None,
    thorough: bool = False,
    progress: OnProgress | None = None,
) -> Tradeoff:
    """Measure error against CPU time for every method on this machine.

    Parameters
    ----------
    scene : Scene or Parameters, optional
        A scene or parameters; the default parameters if not given. Its method, tolerance, step and
        error targets are not used.
    t_end, separation, start : optional
        As in `simulate`, in place of those of the scene.
    thorough : bool
        Whether to try more settings: about two minutes instead of seven seconds.
    progress : callable, optional
        Called with the fraction done; the measurement stops when it returns False.

    Returns
    -------
    Tradeoff
        CPU times and errors.

    Raises
    ------
    InputError
        If an argument is wrong.
    ComputationError
        If the reference cannot be computed or verified.
    Cancelled
        If `progress` returned False.

    Examples
    --------
    >>> from fivtui import Parameters, tradeoff
    >>> result = tradeoff(Parameters(F=80.0), t_end=1.0)
    >>> "rk4" in {row.setting.method for row in result.rows}
    True
    """
    measured_scene = make_scene(scene, t_end=t_end, separation=separation, start=start)
    return measure_tradeoff(measured_scene, thorough=thorough, progress=progress)


def measure_tradeoff(
    scene: Scene, *, thorough: bool = False, progress: OnProgress | None = None
) -> Tradeoff:
    """Measure error against CPU time on a scene, see `tradeoff`.

    Settings of a method are tried from coarse to fine, until the errors are within the uncertainty
    of the reference or the CPU time of the method is used up.
    """
    # Most methods cannot follow parameters that change over time.
    scene.check_constant("tradeoff")
    monitor = Progress(progress)
    budget = THOROUGH_S if thorough else QUICK_S
    # The code of the method taylor: compiled if that is available, else interpreted.
    taylor_kernel = stepping_kernel()
    reference = _simulate(scene, Setting("taylor", taylor_kernel, "tol", _REFERENCE_TOL), monitor)
    expected = observation(reference)
    checks = [
        _simulate(scene, Setting("taylor", *setting), monitor)
        for setting in ((taylor_kernel, "tol", _CHECK_TOL), ("interpreted", "tol", _REFERENCE_TOL))
    ]
    for check in checks:
        divergence = find_divergence(check, reference)
        if divergence is not None:
            raise divergence.error()
    floor = _greatest_deviation([deviation(observation(check), expected) for check in checks])
    rows: list[MeasuredSetting] = []
    with temporary_folder() as folder:
        fmus = _build_fmus(folder)
        methods = {*METHODS, *fmus}
        # The kernel of methods that have no choice of kernels is empty.
        kernels = {"", "interpreted", taylor_kernel}
        method_ladders = [
            ladder
            for ladder in ladders(time_scale(scene.parameters), scene.t_end)
            if ladder.kernel in kernels and ladder.method in methods
        ]
        benchmark = _Benchmark(scene, expected, floor, fmus, monitor)
        for number, ladder in enumerate(method_ladders):
            monitor.report(0.05 + 0.85 * number / len(method_ladders))
            rows += benchmark.measure_ladder(ladder, _SHARES[ladder.method] * budget)
    monitor.report(0.9)
    features = _measure_features(scene, monitor)
    monitor.report(1.0)
    return Tradeoff(scene, reference, floor, rows, features)


def _build_fmus(folder: Path) -> dict[str, Path]:
    # Build the FMUs, by method; the native one only if it is compiled.
    from fmu_src.build import build_fmu, native_failure

    return {
        method: build_fmu(folder / f"{method}.fmu", flavour=flavour)
        for method, flavour in FMU_FLAVOURS.items()
        if flavour != "native" or native_failure() is None
    }


def _greatest_deviation(deviations: Sequence[Deviation]) -> Deviation:
    # The greatest deviation in each quantity and count.
    greatest = {name: max(entry.of(name) for entry in deviations) for name in QUANTITIES}
    return Deviation(
        **greatest,
        separations=max(abs(entry.separations) for entry in deviations),
        sticks=max(abs(entry.sticks) for entry in deviations),
    )


@dataclass(frozen=True, slots=True)
class _Benchmark:
    # Run settings of a scene and compare the results with those of the reference.
    scene: Scene
    reference: Observation
    floor: Deviation
    fmus: Mapping[str, Path]
    monitor: Progress

    def measure_ladder(self, ladder: Ladder, total_s: float) -> list[MeasuredSetting]:
        # Measure settings until one has no significant error, or the next one would take too long.
        rows: list[MeasuredSetting] = []
        begin = time.thread_time()
        cost_ratio = ladder.factor ** -_COST_EXPONENT[ladder.knob]
        for setting in ladder.settings():
            budget_s = total_s - (time.thread_time() - begin)
            if rows and budget_s < rows[-1].cpu_s * cost_ratio:
                break
            row = self.measure(setting, budget_s)
            rows.append(row)
            if row.error is not None and row.error.within(self.floor):
                break
        return rows

    def measure(self, setting: Setting, budget_s: float) -> MeasuredSetting:
        # Run a setting several times; a run that exceeds the CPU time `budget_s` is cancelled.
        begin = time.thread_time()
        is_over_budget = False

        def continue_run(_fraction: float) -> bool:
            nonlocal is_over_budget
            is_over_budget = time.thread_time() - begin > budget_s
            return self.monitor.should_continue() and not is_over_budget

        try:
            observed, steps, cpu_s = self._run(setting, Progress(continue_run))
            for _ in range(_MOST_REPEATS - 1):
                if time.thread_time() - begin > min(_REPEAT_UNTIL_S, budget_s):
                    break
                cpu_s = min(cpu_s, self._run(setting, Progress(continue_run))[2])
        except ComputationError as error:
            return MeasuredSetting(setting, time.thread_time() - begin, 0, None, error.why)
        except Cancelled:
            if not is_over_budget:
                raise
            failure = f"not finished within {budget_s:.2g} s of CPU time"
            return MeasuredSetting(setting, time.thread_time() - begin, 0, None, failure)
        return MeasuredSetting(setting, cpu_s, steps, deviation(observed, self.reference))

    def _run(self, setting: Setting, monitor: Progress) -> tuple[Observation, int, float]:
        # The results of a run, its steps, and its CPU time, s.
        begin = time.thread_time()
        if setting.method in self.fmus:
            fmu = self.fmus[setting.method]
            observed, steps = _run_fmu(self.scene, fmu, setting.value, monitor)
        else:
            run = _simulate(self.scene, setting, monitor)
            observed, steps = observation(run), run.stats.steps
        return observed, steps, time.thread_time() - begin


def _run_fmu(scene: Scene, fmu: Path, step: float, monitor: Progress) -> tuple[Observation, int]:
    # The results of an FMU at its communication points, which are all that an importer sees, and
    # the number of communication steps. `step` is their length, s.
    x, vx, y, vy = resolve_start(scene.system, scene.start)
    run = run_fmu(
        fmu,
        t_end=scene.t_end,
        output_interval=step,
        start_values={
            **scene.parameters.as_dict(),
            "separation": scene.separation,
            "start_static": False,
            "x_start": x,
            "vx_start": vx,
            "y_start": y,
            "vy_start": vy,
        },
        outputs=("x", "vx", "y", "vy", "separations", "sticks", "last_event", "mode"),
        progress=lambda _fraction: monitor.should_continue(),
    )
    columns = run.columns
    final = tuple(columns[name][-1].item() for name in ("x", "vx", "y", "vy"))
    second_half = columns["y"][columns["time"] >= 0.5 * scene.t_end]
    switch_times = columns["last_event"]
    if scene.parameters.v_belt is not None:
        # Keep the last switch of a communication step only if the step changes between contact and
        # separation.
        is_separated = columns["mode"] == Mode.SEPARATED
        switch_times = switch_times[1:][is_separated[1:] != is_separated[:-1]]
    # Before the first switch, the time of the last event is 0.
    event_times = np.unique(switch_times)
    observed = Observation(
        final=cast("State", final),
        peak=float(np.abs(columns["y"]).max()),
        half_range=0.5 * float(np.ptp(second_half)),
        switch_times=event_times[event_times > 0.0],
        separations=round(columns["separations"][-1].item()),
        sticks=round(columns["sticks"][-1].item()),
    )
    return observed, columns["time"].size - 1


def _simulate(scene: Scene, setting: Setting, monitor: Progress) -> Transient:
    options: dict[str, Any] = {"tol": DEFAULT_TOL, "step": None, setting.knob: setting.value}
    request = scene.request(
        method=setting.method, kernel=cast("KernelChoice", setting.kernel or "auto"), **options
    )
    return compute(request, progress=lambda _fraction: monitor.should_continue())


def _measure_features(scene: Scene, monitor: Progress) -> list[Feature]:
    # Measure the cost of each feature by runs with and without it.
    plain = _TestRun(scene)
    runs_without_and_with: list[tuple[str, _TestRun, _TestRun]] = []
    if scene.parameters.k_nl != 0.0:
        linear = _TestRun(scene.with_values({"k_nl": 0.0}))
        runs_without_and_with.append(("cubic contact", linear, plain))
    if scene.parameters.v_belt is not None:
        infinite_speed = _TestRun(scene.with_values({"v_belt": "none"}))
        runs_without_and_with.append(("belt of finite speed", infinite_speed, plain))
    ignored, considered = (_TestRun(replace(scene, separation=flag)) for flag in (False, True))
    sampled = _TestRun(scene, np.linspace(0.0, scene.t_end, _SAMPLES))
    runs_without_and_with += [
        ("separation", ignored, considered),
        (f"trajectory of {_SAMPLES} samples", plain, sampled),
        ("trajectory as polynomials", plain, _TestRun(scene, "dense")),
    ]
    features = [
        _make_feature(name, _run_cost(without_feature, monitor), _run_cost(with_feature, monitor))
        for name, without_feature, with_feature in runs_without_and_with
    ]
    # A single run always records peaks and events, a batch only the required results.
    base_cost = _batch_cost(scene, (), monitor)
    requirements: tuple[tuple[str, Requirement], ...] = (
        ("peaks, in a batch", "peak"),
        ("event list, in a batch", "events"),
    )
    return features + [
        _make_feature(name, base_cost, _batch_cost(scene, (requirement,), monitor))
        for name, requirement in requirements
    ]


class _TestRun(NamedTuple):
    # A run whose cost is measured; `samples` is as in `simulate`.
    scene: Scene
    samples: Any = "none"


class _Cost(NamedTuple):
    # CPU time of a run, s, and its steps; None if it did not finish.
    cpu_s: float | None
    steps: int | None


def _make_feature(name: str, without_feature: _Cost, with_feature: _Cost) -> Feature:
    return Feature(
        name,
        without_s=without_feature.cpu_s,
        with_s=with_feature.cpu_s,
        without_steps=without_feature.steps,
        with_steps=with_feature.steps,
    )


def _batch_cost(scene: Scene, required: tuple[Requirement, ...], monitor: Progress) -> _Cost:
    # The cost of a member in a batch that computes the required results.
    least_s, steps = math.inf, 0
    for _ in range(_BATCH_RUNS):
        before = time.process_time()
        batch = simulate_batch(
            {"F": np.full(_BATCH_MEMBERS, scene.parameters.F)},
            base=scene.parameters,
            t_end=scene.t_end,
            separation=scene.separation,
            start=scene.start,
            require={"final", *required},
            workers=1,
            progress=lambda _fraction: monitor.should_continue(),
        )
        if batch.failed.size:
            return _Cost(None, None)
        least_s = min(least_s, (time.process_time() - before) / _BATCH_MEMBERS)
        steps = int(batch.steps[0])
    return _Cost(least_s, steps)


def _run_cost(test_run: _TestRun, monitor: Progress) -> _Cost:
    request = test_run.scene.request(
        method="taylor",
        step=None,
        tol=DEFAULT_TOL,
        samples=test_run.samples,
        kernel=stepping_kernel(),
    )
    least_s, steps, begin = math.inf, 0, time.thread_time()
    for _ in range(_MOST_REPEATS):
        monitor.check()
        before = time.thread_time()
        try:
            run = compute(request)
        except ComputationError:
            return _Cost(None, None)
        least_s, steps = min(least_s, time.thread_time() - before), run.stats.steps
        if time.thread_time() - begin > _REPEAT_UNTIL_S:
            break
    return _Cost(least_s, steps)
