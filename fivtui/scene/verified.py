"""Transients to an accuracy that is asked for, verified by a finer run."""

import math
from collections.abc import Mapping
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
    Transient,
    check_accuracy,
    deviation,
    divergence,
    finer_tol,
    first_tol,
    observation,
    rounding_error,
    takes_step,
)

_FIRST_STEP: Final = 0.1
# From a setting to the next finer one.
_FINER_STEP: Final = 0.5
_LEAST_STEP: Final = 1e-4


@dataclass(frozen=True, slots=True)
class Verified:
    """A transient with the errors of its numbers."""

    transient: Transient
    asked: Mapping[str, float]
    estimate: Deviation
    runs: int

    def to_dict(self) -> dict[str, Any]:
        """Errors asked for and estimated, and the number of runs, as data for JSON.

        An estimate is null where the numbers of switches differ.
        """
        estimate = {name: self.estimate.of(name) for name in QUANTITIES}
        return {
            "asked": dict(self.asked),
            "estimate": {name: None if e == math.inf else e for name, e in estimate.items()},
            "runs": self.runs,
        }


@dataclass(frozen=True, slots=True)
class SceneTransient:
    """The transient of a scene, with its errors if the scene asks for an accuracy.

    With `parted`, two runs part at that time, and the transient ends before.
    """

    transient: Transient
    verified: Verified | None
    parted: Divergence | None = None

    def to_dict(self) -> dict[str, Any]:
        """The object that ``fivtui simulate --json`` prints."""
        accuracy = {} if self.verified is None else {"accuracy": self.verified.to_dict()}
        found = {**self.transient.to_dict(), **accuracy}
        return found if self.parted is None else {"parted": asdict(self.parted), "before": found}


class PartedError(ComputationError):
    """Two runs part on their way; `before` is what is verified before they do, if anything."""

    def __init__(self, parted: Divergence, before: SceneTransient | None) -> None:
        error = parted.error()
        super().__init__(error.why, error.advice)
        self.before = before


def simulate_to(
    asked: Mapping[str, float],
    request: Request,
    *,
    progress: OnProgress | None = None,
    on_samples: OnSamples | None = None,
) -> Verified:
    """Compute a transient to the errors that are asked for.

    The tolerance, or the step of a method that takes one, follows from the least error; the same
    run with a finer setting then tells the errors, and the setting is refined until they are met.
    Runs that part on their way tell nothing, however near their numbers are by chance.
    """
    targets = check_accuracy(asked)
    scale, by_step = time_scale(request.parameters), takes_step(request.method)

    def run(setting: float, asked: Request = request) -> Transient:
        changes: dict[str, Any] = {"step": setting} if by_step else {"tol": setting, "step": None}
        hand_out = on_samples if asked is request else None
        return compute(replace(asked, **changes), progress=progress, on_samples=hand_out)

    def before(parted: Divergence, until: float, *settings: float) -> SceneTransient | None:
        # The same two settings up to a time at which both runs are still one motion.
        shorter = replace(request, t_end=until, samples="none")
        one, other = (run(each, shorter) for each in settings)
        if runs_part(one, other) is not None:
            return None
        found = deviation(observation(one), observation(other)).at_least(rounding_error(other))
        return SceneTransient(other, Verified(other, targets, found, len(settings)), parted)

    setting = _FIRST_STEP * scale if by_step else first_tol(targets)
    least = _LEAST_STEP * scale if by_step else TOL_RANGE[0]
    coarse, runs = run(setting), 1
    while True:
        last = setting
        setting = max(setting * _FINER_STEP, least) if by_step else finer_tol(setting)
        fine, runs = run(setting), runs + 1
        found = deviation(observation(coarse), observation(fine)).at_least(rounding_error(fine))
        missed = [name for name, error in targets.items() if found.of(name) > error]
        parted = runs_part(coarse, fine)
        if not missed and parted is None:
            return Verified(fine, targets, found, runs)
        if setting <= least:
            if parted is not None:
                until = _shared_until(parted, fine.switch_times)
                raise PartedError(parted, before(parted, until, last, setting))
            name = missed[0]
            others = "" if request.method == "taylor" else " or the method taylor"
            raise ComputationError(
                f"the error of {name} is about {found.of(name):.1e} at the finest setting of the "
                f"method {request.method}, not {targets[name]:g}",
                f"allow a larger error, take a shorter horizon{others}",
            )
        coarse = fine


def _shared_until(parted: Divergence, switch_times: NDArray[np.float64]) -> float:
    """A time before two runs part, between the last two switches that both make."""
    shared = [0.0, *switch_times[switch_times < parted.t].tolist()]
    return 0.5 * sum(shared[-2:]) if len(shared) > 2 else 0.5 * parted.t


def runs_part(run: Transient, other: Transient) -> Divergence | None:
    """Where two runs of one request part, see `divergence`; None if they do not."""
    return divergence(
        observation(run),
        observation(other),
        t_end=other.t_end,
        time_scale=time_scale(other.parameters),
    )
