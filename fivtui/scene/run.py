"""Transients of scenes: if a scene has error targets, a finer run verifies its transient.

A target is the greatest allowed error of a quantity, such as a peak. At a switch the slider leaves
or meets the belt, or begins or ends to stick. Two runs diverge where their switches no longer
correspond; from there on, errors are not estimated.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from fivtui.model import ComputationError, OnProgress, time_scale
from fivtui.simulation import compute
from fivtui.transient import (
    QUANTITIES,
    TOL_RANGE,
    Deviation,
    Divergence,
    OnSamples,
    Request,
    Samples,
    Transient,
    check_accuracy,
    deviation,
    divergence,
    finer_tol,
    first_tol,
    observation,
    rounding_error,
    uses_step,
)

from .scene import Scene

# First and least step of fixed-step methods, as parts of the time scale √(m/stiffness).
_FIRST_STEP: Final = 0.1
_LEAST_STEP: Final = 1e-4
# Factor from a step to the next finer one.
_FINER_STEP: Final = 0.5


@dataclass(frozen=True, slots=True)
class Verified:
    """A transient, its error targets and estimated errors, and the number of runs computed."""

    transient: Transient
    targets: Mapping[str, float]
    estimate: Deviation
    runs: int

    def to_dict(self) -> dict[str, Any]:
        """Error targets, estimated errors and the number of runs, as data for JSON.

        An estimate is null where the numbers of switches differ.
        """
        errors = {name: self.estimate.of(name) for name in QUANTITIES}
        return {
            "asked": dict(self.targets),
            "estimate": {name: None if e == math.inf else e for name, e in errors.items()},
            "runs": self.runs,
        }


@dataclass(frozen=True, slots=True)
class SceneTransient:
    """The transient of a scene, with its errors if the scene has error targets.

    `diverges_at` is the point at which two runs diverge, if they do; the transient ends before it.
    """

    transient: Transient
    verified: Verified | None
    diverges_at: Divergence | None = None

    def to_dict(self) -> dict[str, Any]:
        """The object that ``fivtui simulate --json`` prints; runs that diverge are ``parted``."""
        accuracy = {} if self.verified is None else {"accuracy": self.verified.to_dict()}
        data = {**self.transient.to_dict(), **accuracy}
        if self.diverges_at is None:
            return data
        return {"parted": asdict(self.diverges_at), "before": data}


class DivergenceError(ComputationError):
    """Two runs diverge; `before` is the transient verified up to an earlier time, or None."""

    def __init__(self, diverges_at: Divergence, before: SceneTransient | None) -> None:
        error = diverges_at.error()
        super().__init__(error.why, error.advice)
        self.before = before


def scene_transient(
    scene: Scene,
    *,
    samples: Samples = "none",
    progress: OnProgress | None = None,
    on_samples: OnSamples | None = None,
    sensitivities: Sequence[str] = (),
) -> SceneTransient:
    """Compute the transient of a scene, to its tolerance or to its error targets."""
    request = scene.request(samples=samples, sensitivities=sensitivities)
    if scene.accuracy:
        verified = simulate_to(
            dict(scene.accuracy), request, progress=progress, on_samples=on_samples
        )
        return SceneTransient(verified.transient, verified)
    return SceneTransient(compute(request, progress=progress, on_samples=on_samples), None)


def simulate_to(
    accuracy: Mapping[str, float],
    request: Request,
    *,
    progress: OnProgress | None = None,
    on_samples: OnSamples | None = None,
) -> Verified:
    """Compute a transient to the error targets `accuracy`.

    The tolerance, or the step of a fixed-step method, follows from the smallest target. A run with
    a finer setting then estimates the errors, and the setting is refined until all targets are met.
    Runs that diverge give no estimate, even if their results agree by chance.
    """
    targets = check_accuracy(accuracy)
    # The setting that is refined: the step of a fixed-step method, else the tolerance.
    scale, by_step = time_scale(request.parameters), uses_step(request.method)

    def run(setting: float, variant: Request = request) -> Transient:
        changes: dict[str, Any] = {"step": setting} if by_step else {"tol": setting, "step": None}
        sample_callback = on_samples if variant is request else None
        return compute(replace(variant, **changes), progress=progress, on_samples=sample_callback)

    def run_until(until: float, diverges_at: Divergence, *settings: float) -> SceneTransient | None:
        # Verify the transient up to a time before its runs diverge, with the last two settings.
        shorter = replace(request, t_end=until, samples="none")
        coarser, finer = (run(value, shorter) for value in settings)
        if find_divergence(coarser, finer) is not None:
            return None
        verified = Verified(finer, targets, _estimate_errors(coarser, finer), len(settings))
        return SceneTransient(finer, verified, diverges_at)

    setting = _FIRST_STEP * scale if by_step else first_tol(targets)
    finest = _LEAST_STEP * scale if by_step else TOL_RANGE[0]
    coarse, runs = run(setting), 1
    while True:
        previous = setting
        setting = max(setting * _FINER_STEP, finest) if by_step else finer_tol(setting)
        fine, runs = run(setting), runs + 1
        estimate = _estimate_errors(coarse, fine)
        missed = [name for name, error in targets.items() if estimate.of(name) > error]
        diverges_at = find_divergence(coarse, fine)
        if not missed and diverges_at is None:
            return Verified(fine, targets, estimate, runs)
        if setting <= finest:
            if diverges_at is not None:
                until = _time_before_divergence(diverges_at, fine.switch_times)
                before = run_until(until, diverges_at, previous, setting)
                raise DivergenceError(diverges_at, before)
            name = missed[0]
            alternative = "" if request.method == "taylor" else " or the method taylor"
            raise ComputationError(
                f"the error of {name} is about {estimate.of(name):.1e} at the finest setting of "
                f"the method {request.method}, not {targets[name]:g}",
                f"allow a larger error, take a shorter horizon{alternative}",
            )
        coarse = fine


def _estimate_errors(coarse: Transient, fine: Transient) -> Deviation:
    # An observation has the results that are compared: final state, amplitudes and switches.
    return deviation(observation(coarse), observation(fine)).at_least(rounding_error(fine))


def _time_before_divergence(diverges_at: Divergence, switch_times: NDArray[np.float64]) -> float:
    """A time before two runs diverge, midway between their last two common switches."""
    common: list[float] = switch_times[switch_times < diverges_at.t].tolist()
    if len(common) < 2:
        return 0.5 * diverges_at.t
    return 0.5 * sum(common[-2:])


def find_divergence(coarse: Transient, fine: Transient) -> Divergence | None:
    """The point at which two runs of one request diverge, see `divergence`; None if they agree."""
    return divergence(
        observation(coarse),
        observation(fine),
        t_end=fine.t_end,
        time_scale=time_scale(fine.parameters),
    )
