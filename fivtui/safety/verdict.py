"""The verdict on a parameter set: the μ below which no other attractor was found, and why."""

import math
import time
from dataclasses import dataclass
from itertools import groupby
from typing import Any, Final, Literal

from fivtui.equilibrium import critical_mu
from fivtui.model import (
    PARAMETERS,
    Cancelled,
    ComputationError,
    Parameters,
    check_always_sliding,
    check_parameters,
    equilibrium,
)
from fivtui.orbits import (
    Attraction,
    CycleBranch,
    CyclePoint,
    End,
    EventKind,
    Explorer,
    Kind,
    branch,
    branch_through,
    cycles_at,
)
from fivtui.results import Result, scene_text
from fivtui.transient import Progress

from .least import least_attracting
from .search import MOST_STEPS, SearchRound, Survivor, least_growth, least_staying, search_round

FoundBy = Literal["continuation", "global search", "eigenvalues"]

# The range of μ in which branches are followed, and the search without a critical μ goes, over the
# greatest of critical μ, μ of the scene, and 1.
_SPAN: Final = 2.0
_ROUNDING: Final = 1e-9
_ROUNDS: Final = 4
# Branches that are followed, and motions of which no cycle is found, beyond which the search ends.
_MOST_BRANCHES: Final = 6
# Motion on a torus is looked for down to this part of the least μ of a branch.
_BEYOND: Final = 0.95
# Amplitudes of the same cycle, relative.
_SAME: Final = 1e-2


@dataclass(frozen=True, slots=True)
class OtherAttractor:
    """An attractor beside the equilibrium, at the least μ at which it was found.

    Attributes
    ----------
    mu : float
        The friction coefficient there.
    found_by : str
        ``"continuation"`` of the branch from the Hopf point, or ``"global search"``.
    kind : str
        ``"limit cycle"``, ``"unbounded growth"``, or ``"other motion"``, on a torus or a cycle of
        a multiple period, which transients alone show.
    cycle : CyclePoint or None
        The limit cycle there; None if it was not followed.
    """

    mu: float
    found_by: FoundBy
    kind: Literal["limit cycle", "unbounded growth", "other motion"]
    cycle: CyclePoint | None


@dataclass(frozen=True, slots=True)
class SafeFrictionBasis:
    """What was searched, and what each statement of a verdict rests on.

    Attributes
    ----------
    branches : tuple of CycleBranch
        Continuation: the branch from the Hopf point first if there is one, then those through
        cycles that the global search found.
    not_followed : str
        Why there is no branch from a Hopf point; empty if there is one.
    rounds : tuple of SearchRound
        Global search: each round below the least μ known before it; the last found nothing below,
        unless `budget_ended`.
    unconfirmed : tuple of float
        μ of motions that stay, of which shooting found no cycle: they may settle very slowly, or be
        quasi-periodic; they are not in `safe_mu`.
    budget_ended : bool
        Whether the limit of work ended the search: motions that were not followed to their end, or
        branches that were not followed.
    proved_offset : float or None
        Proof: vertical displacement from rest, m, below which a Lyapunov function proves that
        motion at the μ of the parameter set decays; None if the equilibrium is not stable there.
    cpu_s : float
        CPU time of this process, s, as measured.
    """

    branches: tuple[CycleBranch, ...]
    not_followed: str
    rounds: tuple[SearchRound, ...]
    unconfirmed: tuple[float, ...]
    budget_ended: bool
    proved_offset: float | None
    cpu_s: float


@dataclass(frozen=True, slots=True, repr=False)
class SafeFriction(Result):
    """Which friction coefficients are safe, for small disturbances and for all that were searched.

    Attributes
    ----------
    parameters : Parameters
        The parameter set; its μ matters for `coexisting` and the proof alone.
    separation : bool
        Whether separation was considered.
    critical_mu : float or None
        Below it the equilibrium is stable to small disturbances; None if it is at every μ.
    safe_mu : float or None
        The least μ at which another attractor was found, else the critical μ, else None.
    found_by : str or None
        What `safe_mu` rests on: ``"continuation"``, ``"global search"``, or ``"eigenvalues"`` where
        nothing was found below the critical μ.
    others : tuple of OtherAttractor
        The attractors found below the critical μ, by ascending least μ.
    coexisting : tuple of CyclePoint
        The stable limit cycles at the μ of the parameter set on the branches followed, by growing
        half peak-to-peak.
    searched_to : float
        The greatest μ that was searched.
    basis : SafeFrictionBasis
        What was searched.
    """

    parameters: Parameters
    separation: bool
    critical_mu: float | None
    safe_mu: float | None
    found_by: FoundBy | None
    others: tuple[OtherAttractor, ...]
    coexisting: tuple[CyclePoint, ...]
    searched_to: float
    basis: SafeFrictionBasis

    @property
    def linear(self) -> bool:
        """Whether the system is linear: the contact is, and never breaks."""
        return not self.separation and self.parameters.k_nl == 0.0

    @property
    def undamped(self) -> bool:
        """Whether there is no damping at all."""
        return self.parameters.c1 == 0.0 and self.parameters.c2 == 0.0

    def _summary(self) -> list[tuple[str, str]]:
        from .words import basis_rows, safety_words

        scene = scene_text(self.parameters, separation=self.separation, without=("mu",))
        return [("scene", scene), ("verdict", safety_words(self)), *basis_rows(self)]

    def to_dict(self) -> dict[str, Any]:
        """The keys that ``fivtui stability --json`` adds: ``safe_mu`` and ``safe_mu_basis``."""
        from .files import safe_friction_to_dict

        return safe_friction_to_dict(self)


def safe_friction(
    parameters: Parameters | None = None,
    *,
    separation: bool = True,
    progress: Progress | None = None,
) -> SafeFriction:
    """Find the friction coefficients below which disturbances of any size die out.

    Three things are done, and the result says which statement rests on which. Continuation follows
    the limit cycles from the Hopf point through folds. A global search follows motions from Sobol
    starts at 16 values of μ below what is known; those that stay are confirmed by shooting and
    followed down in μ. A Lyapunov function proves decay near the equilibrium. What is not proved is
    a search: an attractor that no start reaches is not found.

    Parameters
    ----------
    parameters : Parameters, optional
        The parameter set; the base set if not given.
    separation : bool
        Whether separation is considered.
    progress : callable, optional
        Called with the fraction done; cancels the search by returning False.

    Returns
    -------
    SafeFriction
        The verdict. Its work is limited by a number of steps, so that it is the same everywhere.

    Raises
    ------
    InputError
        If the belt has a finite speed.
    ComputationError
        If there is no equilibrium, or a motion cannot be followed.
    Cancelled
        If `progress` returned False.

    Examples
    --------
    >>> from fivtui import Parameters, safe_friction
    >>> found = safe_friction(Parameters(F=120.0))
    >>> round(found.critical_mu, 4), round(found.safe_mu, 4), found.found_by
    (0.7623, 0.2779, 'continuation')
    """
    p = Parameters() if parameters is None else check_parameters(parameters)
    check_always_sliding(p, "safe friction; follow limit cycles down in mu by branch instead")
    begun = time.process_time()
    search = _Search(p, progress, separation=separation)
    search.run()
    point = equilibrium(p, separation=separation)
    region = Attraction(p, point, separation=separation)
    others = search.others()
    critical, least = search.critical, next(iter(others), None)
    found_by: FoundBy | None = "eigenvalues" if critical is not None else None
    result = SafeFriction(
        parameters=p,
        separation=separation,
        critical_mu=critical,
        safe_mu=critical if least is None else least.mu,
        found_by=found_by if least is None else least.found_by,
        others=others,
        coexisting=search.coexisting(),
        searched_to=search.top,
        basis=SafeFrictionBasis(
            branches=tuple(search.branches),
            not_followed=search.not_followed,
            rounds=tuple(search.rounds),
            unconfirmed=tuple(search.unconfirmed),
            budget_ended=search.budget_ended,
            proved_offset=region.offset if region.radius > 0.0 else None,
            cpu_s=time.process_time() - begun,
        ),
    )
    if progress is not None:
        progress(1.0)
    return result


class _Search:
    # The work under way.

    def __init__(self, p: Parameters, progress: Progress | None, *, separation: bool) -> None:
        self._p, self._separation = p, separation
        self._progress, self._fraction = progress, 0.0
        self.critical = next((c.mu for c in critical_mu(p, separation=separation)), None)
        upper = PARAMETERS["mu"].upper
        self._reach = min(_SPAN * max(self.critical or 0.0, p.mu, 1.0), upper)
        self.top = self._reach if self.critical is None else self.critical
        self.branches: list[CycleBranch] = []
        self.rounds: list[SearchRound] = []
        self.not_followed, self.budget_ended = "", False
        self.unconfirmed: list[float] = []
        self._found: list[OtherAttractor] = []

    def run(self) -> None:
        if not self._separation and self._p.k_nl == 0.0:
            self.not_followed = "the system is linear"
            return
        if self._p.c1 == 0.0 and self._p.c2 == 0.0:
            self.not_followed = "there is no damping"
            return
        self._from_hopf()
        self._tell(0.2)
        for turn in range(_ROUNDS):
            least = self._least()
            left = MOST_STEPS - sum(one.steps for one in self.rounds)
            found = search_round(
                self._p, least, left, separation=self._separation, progress=self._go_on
            )
            self.rounds.append(found)
            self._tell(0.2 + 0.8 * (turn + 1) / _ROUNDS)
            self.budget_ended |= bool(found.undecided) or not found.starts
            if not found.settled and not found.unbounded:
                return
            self._examine(found)
            if not self._least() < least:
                return
        self.budget_ended = True

    def others(self) -> tuple[OtherAttractor, ...]:
        # A branch that begins at the critical μ and rises has its least μ there, to rounding.
        top = math.inf if self.critical is None else (1.0 - _ROUNDING) * self.critical
        return tuple(sorted((one for one in self._found if one.mu < top), key=lambda one: one.mu))

    def coexisting(self) -> tuple[CyclePoint, ...]:
        inside = (each for each in self.branches if each.low <= self._p.mu <= each.high)
        found: list[CyclePoint] = []
        for one in sorted(
            (one for each in inside for one in cycles_at(each, self._p.mu) if one.stable),
            key=lambda one: one.half_range,
        ):
            if not found or not _alike(found[-1].half_range, one.half_range):
                found.append(one)
        return tuple(found)

    def _tell(self, fraction: float) -> None:
        self._fraction = fraction
        if not self._go_on(fraction):
            raise Cancelled

    def _go_on(self, _part: float) -> bool:
        return self._progress is None or self._progress(self._fraction)

    def _least(self) -> float:
        return min((one.mu for one in self._found), default=self.top)

    def _from_hopf(self) -> None:
        if self.critical is None:
            self.not_followed = "there is no Hopf point"
            return
        at = self._p.with_values({"mu": self.critical})
        try:
            found = branch(
                at,
                "mu",
                low=0.0,
                high=self._reach,
                separation=self._separation,
                progress=self._go_on,
            )
        except ComputationError as error:
            self.not_followed = str(error)
            return
        self._add(found, "continuation")

    def _add(self, found: CycleBranch, by: FoundBy) -> None:
        self.branches.append(found)
        cycle = least_attracting(found)
        if cycle is not None:
            self._found.append(OtherAttractor(cycle.value, by, "limit cycle", cycle))
            if any(
                (event.value, event.period) == (cycle.value, cycle.period)
                for event in found.events
                if event.kind in (EventKind.TORUS, EventKind.PERIOD_DOUBLING)
            ):
                self._beyond(cycle, min(point.value for point in found.points))
        for end, point in zip(found.ends, (found.points[0], found.points[-1]), strict=True):
            # Beyond an unstable cycle that grows without bounds, motion does.
            if end is End.UNBOUNDED and not point.stable:
                self._found.append(OtherAttractor(point.value, by, "unbounded growth", None))

    def _beyond(self, cycle: CyclePoint, least: float) -> None:
        # Where a cycle loses its stability to a torus or a cycle of twice its period, motion on
        # these goes on, perhaps to lower μ than that of any cycle of the branch.
        at = Survivor(cycle.value, cycle.start, cycle.half_range)
        mu = least_staying(self._p, at, _BEYOND * least, separation=self._separation)
        if mu < cycle.value:
            self._found.append(OtherAttractor(mu, "global search", "other motion", None))

    def _examine(self, found: SearchRound) -> None:
        for mu, here in groupby(found.settled, key=lambda one: one.mu):
            if mu >= self._least():
                break
            known = self._amplitudes(mu)
            for one in here:
                if any(_alike(one.half_range, size) for size in known):
                    continue
                known.append(one.half_range)
                if max(len(self.branches), len(self.unconfirmed)) > _MOST_BRANCHES:
                    self.budget_ended = True
                    return
                self._confirm(one)
        growing = next(iter(found.unbounded), None)
        if growing is not None and growing.mu < self._least():
            mu = least_growth(self._p, growing, found, separation=self._separation)
            self._found.append(OtherAttractor(mu, "global search", "unbounded growth", None))

    def _amplitudes(self, mu: float) -> list[float]:
        # Half peak-to-peak of the stable cycles known there.
        inside = (each for each in self.branches if each.low <= mu <= each.high)
        return [one.half_range for each in inside for one in cycles_at(each, mu) if one.stable]

    def _confirm(self, one: Survivor) -> None:
        at = self._p.with_values({"mu": one.mu})
        explorer = Explorer(at, separation=self._separation, go_on=lambda: self._go_on(0.0))
        try:
            reached = explorer.reach(one.state)
        except ComputationError:
            self.unconfirmed.append(one.mu)
            return
        if reached.orbit is None:
            if reached.kind is not Kind.EQUILIBRIUM:
                self.unconfirmed.append(one.mu)
            return
        cycle = (reached.orbit.start, reached.orbit.period)
        try:
            found = branch_through(
                at,
                "mu",
                cycle,
                (0.0, self._reach),
                separation=self._separation,
                progress=self._go_on,
            )
        except ComputationError:
            # A cycle that continuation cannot take up still counts where it is.
            self._found.append(OtherAttractor(one.mu, "global search", "limit cycle", None))
            return
        self._add(found, "global search")


def _alike(one: float, other: float) -> bool:
    return abs(one - other) <= _SAME * max(one, other)
