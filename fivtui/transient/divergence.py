"""Where two runs of one problem part: nothing after that is verified by comparing them."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from fivtui.model.errors import ComputationError

from .deviation import Observation

# States further apart than this part of the amplitude belong to different motions; so do switches
# further apart than this part of √(m/stiffness).
PARTED: Final = 0.01


@dataclass(frozen=True, slots=True)
class Divergence:
    """When two runs part, s, and how that shows."""

    t: float
    reason: str

    def error(self) -> ComputationError:
        """What is to be said where a number was to be verified."""
        return ComputationError(
            f"two runs at different accuracy part at t = {self.t:.6g} s: {self.reason}; nothing "
            "after that can be verified",
            "take a horizon before that time",
        )


def divergence(
    run: Observation, truth: Observation, *, t_end: float, time_scale: float
) -> Divergence | None:
    """Where two runs of the same problem part, if they do.

    Parameters
    ----------
    run, truth : Observation
        Of both runs, at different accuracy.
    t_end : float
        Their horizon, s.
    time_scale : float
        √(m/stiffness), s.

    Returns
    -------
    Divergence or None
        The first switch that only one of them makes, or that they make at different times; the
        horizon, where their states are apart; None if neither is so.
    """
    times, others = run.switch_times.tolist(), truth.switch_times.tolist()
    at = _first_difference(times, others, PARTED * time_scale)
    if at is not None:
        counts = f"{len(times)} and {len(others)} in all"
        return Divergence(at, f"their switches differ from there on ({counts})")
    weights = (1.0, time_scale, 1.0, time_scale)
    pairs = zip(run.final, truth.final, weights, strict=True)
    apart = max(abs(a - b) * weight for a, b, weight in pairs)
    sizes = (abs(a) * weight for a, weight in zip(truth.final, weights, strict=True))
    size = max(truth.peak, *sizes)
    if apart <= PARTED * size:
        return None
    return Divergence(t_end, f"their states differ by {apart / size:.1%} of the amplitude")


def _first_difference(
    times: Sequence[float], others: Sequence[float], allowed: float
) -> float | None:
    for one, other in zip(times, others, strict=False):
        if abs(one - other) > allowed:
            return min(one, other)
    common = min(len(times), len(others))
    return next(iter((*times[common:], *others[common:])), None)
