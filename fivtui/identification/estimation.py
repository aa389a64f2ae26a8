"""Fit parameters to measured signals and features."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from fivtui.measured import QUANTITIES, has_column_name, read_measurement
from fivtui.model import (
    InputError,
    Interval,
    OnProgress,
    Parameters,
    Progress,
    check_known,
    check_names,
    parse_number,
)
from fivtui.scene import Scene, make_scene
from fivtui.transient import Start

from .features import check_targets, parse_target
from .fit import Fit, solve
from .options import IdentifyOptions
from .problem import Problem, Record
from .result import FittedValue, Identification
from .signals import scene_at
from .statistics import compute_intervals, find_unknown, residual_runs_test
from .unknowns import parse_unknowns

_NUMBERS: Final = ("scale", "time_scale", "noise")
_POSITIVE: Final = Interval(0.0, lower_open=True)
# Relative distance from a bound below which a value is at it.
_BOUND_TOL: Final = 1e-6


def identify(
    parameters: Parameters | Scene | None = None,
    measured: str | Path | Sequence[str | Path] = (),
    *,
    fit: Sequence[str],
    own: Sequence[str] = (),
    signals: Sequence[str] = ("y",),
    targets: Sequence[str] = (),
    noise: float | None = None,
    time: str = "",
    time_scale: float = 1.0,
    scale: float = 1.0,
    separation: bool | None = None,
    start: Start | None = None,
    progress: OnProgress | None = None,
) -> Identification:
    """Find the parameters that explain measurements, and how far to trust them.

    The sum of squared residuals is minimised (`scipy.optimize.least_squares`) with exact
    derivatives of the runs. The first part of the records is fitted first, and the fitted part is
    doubled until it is the whole, or until the run leaves the record. If the first part fits badly,
    further starts are tried.

    Parameters
    ----------
    parameters : Parameters or Scene, optional
        Values that are not fitted, and values from which the fit begins; the base set if not given.
    measured : path or sequence of paths
        Files with columns, see `read_measurement`. Their times are those of the run, from its
        start at 0.
    fit : sequence of str
        Parameters, or ``x0``, ``vx0``, ``y0``, ``vy0`` of the start: ``mu``, or ``c1=0.1:2`` with
        bounds. Without bounds, a positive value stays within a factor of 100.
    own : sequence of str
        As `fit`; each file has its own value.
    signals : sequence of str
        Measured quantities, ``x``, ``vx``, ``y``, ``vy`` or ``P``: ``y``, or ``y=COLUMN``.
    targets : sequence of str
        Measured features with their standard deviation, such as ``frequency=2000±10``:
        ``frequency`` (Hz) and ``growth-rate`` (1/s) of the least stable mode, ``critical-mu``, and
        ``half-range`` (m) and ``cycle-frequency`` (Hz) of the limit cycle from the static start.
    noise : float, optional
        Standard deviation of the noise of the signals, SI unit; estimated if not given.
    time : str
        Name or number of the time column, see `read_measurement`.
    time_scale, scale : float
        Factors that convert the times to s, and the signals to SI units.
    separation, start
        As in `simulate`; those of the scene if not given.
    progress : callable, optional
        Called with the fraction done; cancels the fit by returning False.

    Returns
    -------
    Identification
        Fitted values with 95 % intervals, residuals, and what the data do not determine.

    Raises
    ------
    InputError
        If an argument or a file is wrong.
    ComputationError
        If the first run cannot be computed.
    Cancelled
        If `progress` returned False.

    Examples
    --------
    >>> import numpy as np
    >>> from fivtui import Parameters, identify, simulate
    >>> motion = simulate(Parameters(mu=0.6), t_end=10.0, samples=1001).trajectory
    >>> np.savetxt("rig.csv", np.column_stack([motion.t, motion.y]), delimiter=",")
    >>> round(identify(measured="rig.csv", fit=["mu"]).fit["mu"].value, 6)
    0.6
    """
    scene = make_scene(parameters, separation=separation, start=start)
    scene.check_constant("a fit")
    paths = [measured] if isinstance(measured, str | Path) else list(measured)
    records = [
        _read_record(Path(path), check_names("signals", signals), time, time_scale, scale)
        for path in paths
    ]
    unknowns = parse_unknowns(scene, check_names("fit", fit), check_names("own", own), len(paths))
    targets_read = [parse_target(text) for text in check_names("targets", targets)]
    check_targets(targets_read, scene.system)
    count = sum(record.t.size * len(record.signals) for record in records) + len(targets_read)
    if count < len(unknowns):
        raise InputError(
            f"{count} measured values for {len(unknowns)} unknowns: must be at least as many; "
            "give --measured or more --target"
        )
    spreads = {
        name: float(np.std(np.concatenate([record.signals[name] for record in records]))) or 1.0
        for name in (records[0].signals if records else ())
    }
    if noise is not None:
        spreads = dict.fromkeys(spreads, _POSITIVE.check("noise", noise))
    problem = Problem(scene, unknowns, records, targets_read, spreads, Progress(progress))
    fitted = solve(problem, estimate_noise=noise is None)
    known_noise = noise is not None or not records
    result = _assess(problem, fitted, known_noise=known_noise)
    problem.work.advance(1.0)
    return result


def prepare_fit(scene: Scene, options: IdentifyOptions) -> Callable[..., Identification]:
    """The fit that options describe, to be called with `progress`; it reads the files.

    Raises `InputError` if an option is wrong for any file.
    """
    numbers: dict[str, Any] = {
        name: parse_number(f"--{name.replace('_', '-')}", text, "a number above 0")
        for name in _NUMBERS
        if (text := getattr(options, name)) is not None
    }
    parse_unknowns(scene, options.fit, options.own, len(options.measured))
    for text in options.target:
        parse_target(text)

    def fit(progress: OnProgress | None = None) -> Identification:
        result = identify(
            scene,
            options.measured,
            fit=options.fit,
            own=options.own,
            signals=options.signal or ("y",),
            targets=options.target,
            time=options.time,
            progress=progress,
            **numbers,
        )
        return replace(result, request=(scene, options))

    return fit


def _read_record(
    path: Path, signals: Sequence[str], time: str, time_scale: float, scale: float
) -> Record:
    values = {}
    for text in signals:
        quantity, _, column = (part.strip() for part in text.partition("="))
        check_known("signal", quantity, QUANTITIES)
        measurement = read_measurement(
            path,
            time=time,
            signal=column,
            quantity=quantity,
            scale=scale,
            time_scale=time_scale,
        )
        # A single signal may be in a column of any name.
        if not (column or len(signals) == 1 or has_column_name(measurement.signal, (quantity,))):
            raise InputError(f"{path}: has no column {quantity}: give {quantity}=COLUMN")
        if not np.isfinite(measurement.values).all():
            raise InputError(f"{path}: {measurement.signal}: must be finite numbers")
        values[quantity] = measurement.values
    if not signals:
        raise InputError("signals: must have at least one, e.g. y")
    if measurement.t[0] < 0.0 or measurement.t[-1] <= 0.0:
        raise InputError(
            f"{path}: t = {measurement.t[0]:g}: must be from 0 on, the start of the run"
        )
    return Record(str(path), measurement.t, values)


def _assess(problem: Problem, fitted: Fit, *, known_noise: bool) -> Identification:
    # The result with intervals, where the data determine the values.
    solution, t_end = fitted.solution, fitted.t_end
    directions = find_unknown(problem, solution)
    undetermined = frozenset().union(*directions.values())
    determined = [index for index in range(solution.z.size) if index not in undetermined]
    intervals = compute_intervals(problem, solution, t_end, determined, known_noise=known_noise)
    low, high = problem.bounds()
    span = _BOUND_TOL * problem.spreads()
    is_at_bound = (solution.z <= low + span) | (solution.z >= high - span)
    reaches_bound = (intervals.low <= low) | (intervals.high >= high)
    for index in np.flatnonzero(reaches_bound & ~is_at_bound).tolist():
        key = problem.unknowns[index].key
        directions[f"{key} is hardly determined: its interval reaches a bound"] = frozenset({index})
    undetermined = frozenset().union(*directions.values())
    values: dict[str, FittedValue] = {}
    for index, unknown in enumerate(problem.unknowns):
        value = unknown.value_at(float(solution.z[index]))
        ends: tuple[float | None, float | None, float | None] = (None, None, None)
        if index not in undetermined and not is_at_bound[index]:
            ends = (
                unknown.value_at(float(intervals.low[index])),
                unknown.value_at(float(intervals.high[index])),
                float(intervals.sd[index]),
            )
        values[unknown.key] = FittedValue(value, *ends, unknown.is_logarithmic)
    residuals = problem.signal_residuals(solution.residuals, t_end)
    measured_until = max((float(record.t[-1]) for record in problem.records), default=0.0)
    features = solution.residuals[solution.residuals.size - len(problem.targets) :]
    table: dict[str, Any] = problem.table(solution.residuals, t_end)
    return Identification(
        scene=scene_at(problem.scene, problem.values(solution.z)),
        fit=values,
        correlation=intervals.correlation,
        **table,
        targets={
            target: target.value + float(deviation) * target.sd
            for target, deviation in zip(problem.targets, features, strict=True)
        },
        residual_sd={
            name: float(np.sqrt(np.mean(np.concatenate(parts) ** 2)))
            for name, parts in residuals.items()
        },
        runs_test=residual_runs_test(problem, solution.residuals, t_end),
        fitted_until=min(t_end, measured_until),
        measured_until=measured_until,
        misfit=fitted.misfit,
        unknown=tuple(directions),
        at_bound=tuple(
            unknown.key
            for unknown, at_bound in zip(problem.unknowns, is_at_bound, strict=True)
            if at_bound
        ),
        converged=solution.converged,
        windows=fitted.windows,
        starts=fitted.starts,
        evaluations=problem.evaluations,
    )
