"""Error estimates of a run, from a second run and from the growth of small errors.

The second run is finer if the tolerance can be smaller: see `accuracy`.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

from fivtui.model import Column, OnProgress, Parameters, Progress
from fivtui.results import Result, Table, Tabular, scene_text, to_data
from fivtui.scene import Scene, find_divergence, make_scene
from fivtui.simulation import compute
from fivtui.transient import (
    METHODS,
    TOL_RANGE,
    Divergence,
    Request,
    Start,
    Transient,
    fixed_step,
    rounding_error,
)

from .lyapunov import ErrorGrowth, error_growth

# Ratio of the tolerances of the two runs.
_TOL_RATIO: Final = 100.0


@dataclass(frozen=True, slots=True)
class Estimate:
    """A value of a run, and its difference to that of the second run.

    The difference is replaced by the rounding error if that is greater.
    """

    value: float
    difference: float


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Accuracy(Result, Tabular):
    """Error estimates of a run.

    Attributes
    ----------
    run : Transient
        The run at the requested setting.
    finer : str
        The tolerance or the step of the second run, with which it is compared.
    estimates : mapping of str to Estimate
        ``x``, ``vx``, ``y``, ``vy`` at the end, ``peak_y_abs``, ``y_half_range``,
        ``separated_time`` and ``separations``, in SI units; ``stick_time`` and ``sticks`` on a belt
        of finite speed.
    growth : ErrorGrowth
        How small errors grow along the run; its `fate` tells whether they decay, stay bounded or
        grow in the long run.
    parted : Divergence or None
        When and why the two runs diverge, else None. If they do, no digit is reliable.
    """

    run: Transient
    finer: str
    estimates: Mapping[str, Estimate]
    growth: ErrorGrowth
    parted: Divergence | None

    def _summary(self) -> list[tuple[str, str]]:
        run = self.run
        rows = [
            ("scene", scene_text(run.system)),
            ("run", f"{run.t_end:g} s, {run.method}, compared with {self.finer}"),
            *(
                (name, f"{reliable_digits(estimate)} ± {estimate.difference:.1g}")
                for name, estimate in self.estimates.items()
            ),
            ("a small error", str(self.growth.fate)),
        ]
        if self.parted is not None:
            rows.append(("the runs diverge", f"at t = {self.parted.t:.6g} s"))
        return rows

    def to_dict(self) -> dict[str, Any]:
        """The object that ``fivtui accuracy --json`` prints.

        Keys are ``parameters``, ``separation``, ``t_end``, ``method``, ``tol``, ``step``,
        ``finer``, ``estimates{name: {value, difference}}``, ``growth`` and ``parted{t, reason}``
        (None if the runs stay together).
        """
        run = self.run
        data: dict[str, Any] = to_data(
            {
                "parameters": run.parameters.as_dict(),
                "separation": run.separation,
                **{name: getattr(run, name) for name in ("t_end", "method", "tol", "step")},
                **{
                    name: getattr(self, name) for name in ("finer", "estimates", "growth", "parted")
                },
            }
        )
        return data

    def _table(self) -> Table:
        estimates = self.estimates.values()
        return {
            Column("quantity", "", "name of the value"): np.array(list(self.estimates)),
            Column("value", "", "value of the run, SI units"): np.array(
                [estimate.value for estimate in estimates]
            ),
            Column("difference", "", "difference to the finer run, SI units"): np.array(
                [estimate.difference for estimate in estimates]
            ),
        }


def accuracy(
    scene: Scene | Parameters | None = None,
    *,
    t_end: float | None = None,
    tol: float | None = None,
    separation: bool | None = None,
    start: Start | None = None,
    method: str | None = None,
    step: float | None = None,
    progress: OnProgress | None = None,
) -> Accuracy:
    """Estimate the errors of a run.

    Parameters
    ----------
    scene : Scene or Parameters, optional
        A scene, or the parameters of one; the base set if not given.
    t_end, tol, separation, start, method, step : optional
        As in `simulate`; they replace those of the scene.
    progress : callable, optional
        Called with the fraction done; cancels the study by returning False.

    Returns
    -------
    Accuracy
        Differences to a second run at a hundredth of the tolerance, or at half the step, and the
        growth of errors. Where the hundredth is below the least tolerance, the second run has a
        hundred times the tolerance instead.

    Raises
    ------
    InputError
        If the request is wrong.
    ComputationError
        If a run cannot be finished.
    Cancelled
        If `progress` returned False.

    Examples
    --------
    >>> from fivtui import Parameters, accuracy
    >>> result = accuracy(Parameters(F=80.0), t_end=10.0)
    >>> peak = result.estimates["peak_y_abs"]
    >>> peak.difference < 1e-8 * peak.value
    True
    """
    scene = make_scene(
        scene, t_end=t_end, tol=tol, separation=separation, start=start, method=method, step=step
    )
    work = Progress(progress)
    request = scene.request()
    tol, step = scene.tol, scene.step
    if scene.method in METHODS and METHODS[scene.method].fixed_step:
        step = 0.5 * fixed_step(request)
        finer = f"step {step:.6g} s"
    else:
        least_tol, greatest_tol = TOL_RANGE
        has_finer_tol = tol / _TOL_RATIO >= least_tol
        tol = tol / _TOL_RATIO if has_finer_tol else min(tol * _TOL_RATIO, greatest_tol)
        finer = f"tol {tol:g}"

    def run(request: Request, begin: float) -> Transient:
        # Each run is a third of the progress, and so is the growth of errors.
        return compute(request, progress=work.stage(begin, begin + 1.0 / 3.0).callback)

    first_run = run(request, 0.0)
    second_run = run(replace(request, tol=tol, step=step), 1.0 / 3.0)
    growth = error_growth(request, progress=work.stage(2.0 / 3.0, 1.0).callback)
    work.advance(1.0)
    values, second_values = _named_values(first_run), _named_values(second_run)
    rounding_errors = _rounding_errors(first_run)
    estimates = {}
    for name, value in values.items():
        difference = abs(value - second_values[name])
        estimates[name] = Estimate(value, max(difference, rounding_errors.get(name, 0.0)))
    return Accuracy(
        run=first_run,
        finer=finer,
        estimates=estimates,
        growth=growth,
        parted=find_divergence(first_run, second_run),
    )


def _rounding_errors(run: Transient) -> dict[str, float]:
    # Rounding errors that both runs may have in common, by the name of the value. Errors of the
    # half range are relative to the peak, as in `Deviation`.
    relative, peak = rounding_error(run), run.peak.y_abs
    _, *state = run.final
    state_error = relative.final * max(map(abs, state))
    return dict.fromkeys(("x", "vx", "y", "vy"), state_error) | {
        "peak_y_abs": relative.peak * peak,
        "y_half_range": relative.half_range * peak,
    }


def _named_values(run: Transient) -> dict[str, float]:
    # The values of a run whose errors are estimated.
    sticks = {"stick_time": run.events.stick_time, "sticks": float(run.events.sticks)}
    return {
        "x": run.final.x,
        "vx": run.final.vx,
        "y": run.final.y,
        "vy": run.final.vy,
        "peak_y_abs": run.peak.y_abs,
        "y_half_range": run.steady.y_half_range,
        "separated_time": run.events.separated_time,
        "separations": float(run.events.separations),
        **({} if run.parameters.v_belt is None else sticks),
    }


def reliable_digits(estimate: Estimate) -> str:
    """The value of an estimate with the digits that are certain by its difference, at least one."""
    value, difference = abs(estimate.value), estimate.difference
    if value == 0.0 or difference == 0.0:
        return f"{estimate.value:.15g}"
    digits = math.floor(math.log10(value / difference)) if difference < value else 0
    return f"{estimate.value:.{min(max(digits, 1), 15)}g}"
