"""The verdict on a parameter set: safe μ, below which every motion comes to rest, and its basis.

Continuation follows limit cycles from the Hopf point to their least μ. A global search then looks
for further attractors at lower μ, in rounds, until a round finds none.
"""

import math
import time
from dataclasses import dataclass, field
from typing import Any, Final, Literal

from fivtui.equilibrium import lowest_critical_mu
from fivtui.model import (
    PARAMETERS,
    ComputationError,
    OnProgress,
    Parameters,
    Progress,
    System,
    check_always_sliding,
    equilibrium,
    system_of,
)
from fivtui.orbits import (
    CycleBranch,
    CyclePoint,
    DecayRegion,
    End,
    EventKind,
    Explorer,
    branch,
    branch_through,
    cycles_at,
    event_at,
)
from fivtui.results import SystemResult, scene_text

from .growth import least_growth_mu
from .hopf_branch import least_attracting_cycle
from .search import (
    SCOUT_STARTS,
    RunningRound,
    SearchRound,
    Survivor,
    least_persistent_mu,
    least_unbounded_mu,
    starts_within_limit,
)

FoundBy = Literal["continuation", "global search", "eigenvalues"]
AttractorKind = Literal["limit cycle", "unbounded growth", "other motion"]

# Branches, and the search if there is no critical μ, end at this multiple of a reference: the
# greatest of the critical μ, the μ of the parameter set, and 1.
_UPPER_MU_FACTOR: Final = 2.0
# An attractor counts as below the critical μ if its μ is less by this relative difference.
_MU_ROUNDING: Final = 1e-9
# Limit of the rounds with few starts (scouts), and of the full rounds.
_ROUND_LIMIT: Final = 8
# Fractions of the progress at the end of the branch from the Hopf point, and of the scouts.
_BRANCH_SHARE: Final = 0.2
_SCOUTS_END: Final = 0.4
# After a stage, shooting starts from at most this many of its motions: per level, and in total.
_SHOTS_PER_LEVEL: Final = 3
_SHOTS_PER_STAGE: Final = 12
# `Explorer` follows each to its attractor, for at most this many legs of 16 slowest periods.
_LEG_LIMIT: Final = 16
# Share of undecided motions from which on safe μ is not known.
_UNDECIDED_LIMIT: Final = 0.05
# The search for the least μ of a motion on a torus begins at this multiple of the least μ of its
# branch; without a branch, of the next lower level.
_TORUS_RANGE: Final = 0.95
# Relative difference of amplitudes below which two cycles are the same.
_SIZE_TOLERANCE: Final = 1e-2
# Relative difference up to which the search confirms a safe μ by continuation.
_MU_TOLERANCE: Final = 1e-3


@dataclass(frozen=True, slots=True)
class OtherAttractor:
    """An attractor beside the equilibrium, at the least μ at which it was found.

    Attributes
    ----------
    mu : float
        The least friction coefficient at which the attractor was found.
    found_by : str
        ``"continuation"`` of the branch from the Hopf point, or ``"global search"``.
    kind : str
        ``"limit cycle"``, ``"unbounded growth"``, or ``"other motion"``: on a torus or a cycle of
        a multiple period, found by transients alone.
    cycle : CyclePoint or None
        The limit cycle at `mu`; None if it was not followed.
    """

    mu: float
    found_by: FoundBy
    kind: AttractorKind
    cycle: CyclePoint | None


@dataclass(frozen=True, slots=True)
class SafeFrictionBasis:
    """Record of the search, and the basis of every statement of a verdict.

    Attributes
    ----------
    branches : tuple of CycleBranch
        Continuation: the branch from the Hopf point, if there is one, then the branches through
        cycles that the global search found.
    not_followed : str
        The reason why there is no branch from a Hopf point; empty if there is one.
    rounds : tuple of SearchRound
        Global search: each round is below the least μ of the attractors known before it; the first
        rounds have few starts. A round ends as soon as it finds an attractor, so that its
        remaining motions stay undecided.
    budget_ended : bool
        Whether a limit ended the search: motions of the last round are undecided, or the limit of
        rounds was reached.
    growth_at_any_size : float or None
        With a linear contact spring (k_nl = 0) large motions grow at a rate that does not depend
        on their size: the least μ, to 1e-7, at which they grow; None without such a μ.
    proved_offset : float or None
        Proof: vertical displacement from rest, m, below which a Lyapunov function proves that
        motion at the μ of the parameter set decays; None if the equilibrium is not stable there.
    cpu_s : float
        CPU time of this process, s, as measured.
    """

    branches: tuple[CycleBranch, ...]
    not_followed: str
    rounds: tuple[SearchRound, ...]
    budget_ended: bool
    growth_at_any_size: float | None
    proved_offset: float | None
    cpu_s: float = field(compare=False)


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class SafeFriction(SystemResult):
    """Safe friction coefficients, for small disturbances and for all searched disturbances.

    Attributes
    ----------
    system : System
        The system, with `parameters` and `separation`; its μ has an effect only on `coexisting` and
        on the proof.
    critical_mu : float or None
        Below it the equilibrium is stable to small disturbances; None if it is stable at every μ.
    safe_mu : float or None
        The least μ at which another attractor was found, else the critical μ, else None. None also
        if it is not known: see `unknown_above`.
    unknown_above : float or None
        The μ above which `safe_mu` is not known, because at least one in 20 motions stayed
        undecided; None if `safe_mu` is known.
    found_by : str or None
        Basis of `safe_mu`: ``"continuation"``, ``"global search"``, or ``"eigenvalues"`` if no
        attractor was found below the critical μ; None without a `safe_mu`.
    others : tuple of OtherAttractor
        The attractors found below the critical μ, by ascending least μ.
    coexisting : tuple of CyclePoint
        The stable limit cycles at the μ of the parameter set on the branches followed, by growing
        half peak-to-peak.
    searched_to : float
        The greatest μ that was searched.
    basis : SafeFrictionBasis
        Record of the search.
    """

    system: System
    critical_mu: float | None
    safe_mu: float | None
    unknown_above: float | None
    found_by: FoundBy | None
    others: tuple[OtherAttractor, ...]
    coexisting: tuple[CyclePoint, ...]
    searched_to: float
    basis: SafeFrictionBasis

    @property
    def linear(self) -> bool:
        """Whether the system is linear: linear contact and no separation."""
        return not self.separation and self.parameters.k_nl == 0.0

    @property
    def undamped(self) -> bool:
        """Whether there is no damping at all."""
        return self.parameters.c1 == 0.0 and self.parameters.c2 == 0.0

    @property
    def safe_to(self) -> float:
        """The μ below which no searched disturbance leads to vibration."""
        if self.unknown_above is not None:
            return self.unknown_above
        return self.searched_to if self.safe_mu is None else self.safe_mu

    def limit_of(self, continued_mu: float) -> float:
        """The μ up to which the search confirms a safe μ by continuation.

        It is the greatest allowed μ if the search found no attractor at a lower μ. Otherwise it is
        `safe_mu`, or `unknown_above` if safe μ is not known.

        Parameters
        ----------
        continued_mu : float
            The least μ of the branch from the Hopf point, or the critical μ; NaN without either.
        """
        if self.unknown_above is not None:
            return self.unknown_above
        if self.safe_mu is None or continued_mu <= (1.0 + _MU_TOLERANCE) * self.safe_mu:
            return PARAMETERS["mu"].upper
        return self.safe_mu

    def _summary(self) -> list[tuple[str, str]]:
        from .phrases import basis_rows, verdict_text

        scene = scene_text(self.system, without=("mu",))
        return [("scene", scene), ("verdict", verdict_text(self)), *basis_rows(self)]

    def to_dict(self) -> dict[str, Any]:
        """The keys that ``fivtui stability --json`` adds: ``safe_mu`` and ``safe_mu_basis``."""
        from .files import safe_friction_to_dict

        return safe_friction_to_dict(self)


def safe_friction(
    parameters: Parameters | None = None,
    *,
    separation: bool = True,
    progress: OnProgress | None = None,
) -> SafeFriction:
    """Find the friction coefficients below which disturbances of any size die out.

    Three methods are used, and the result names the basis of every statement. Continuation follows
    the limit cycles from the Hopf point through folds. A global search follows motions from Sobol
    starts at 16 values of μ below the least known μ; shooting confirms persisting motions, which
    are then followed to lower μ. A Lyapunov function proves decay near the equilibrium. Only the
    last is a proof: an attractor that no start reaches is missed. If a twentieth or more of the
    motions stay undecided, no μ is called safe.

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
        The verdict. Limits are numbers of steps, so that it is the same on every machine.

    Raises
    ------
    InputError
        If `v_belt` is given: the belt must always be faster than the slider.
    ComputationError
        If there is no equilibrium, or a motion cannot be followed.
    Cancelled
        If `progress` returned False.

    Examples
    --------
    >>> from fivtui import Parameters, safe_friction
    >>> result = safe_friction(Parameters(F=120.0))
    >>> round(result.critical_mu, 4), round(result.safe_mu, 4), result.found_by
    (0.7623, 0.2779, 'continuation')
    """
    system = system_of(parameters, separation)
    p = system.parameters
    check_always_sliding(p, "safe friction; use branch to follow limit cycles down in mu instead")
    cpu_start = time.process_time()
    search = _SafeFrictionSearch(system, Progress(progress))
    search.run()
    attractors = search.attractors_below_critical()
    unknown_above, critical = search.unknown_above, search.critical
    safe_mu: float | None = None
    found_by: FoundBy | None = None
    if unknown_above is None and attractors:
        safe_mu, found_by = attractors[0].mu, attractors[0].found_by
    elif unknown_above is None and critical is not None:
        safe_mu, found_by = critical, "eigenvalues"
    region = DecayRegion(system, equilibrium(system))
    result = SafeFriction(
        system=system,
        critical_mu=critical,
        safe_mu=safe_mu,
        unknown_above=unknown_above,
        found_by=found_by,
        others=attractors,
        coexisting=search.coexisting(),
        searched_to=search.searched_to,
        basis=SafeFrictionBasis(
            branches=tuple(search.branches),
            not_followed=search.not_followed,
            rounds=tuple(search.rounds),
            budget_ended=search.budget_ended,
            growth_at_any_size=search.growth_at_any_size,
            proved_offset=region.offset if region.radius > 0.0 else None,
            cpu_s=time.process_time() - cpu_start,
        ),
    )
    search.work.advance(1.0)
    return result


class _SafeFrictionSearch:
    # The search for attractors: its branches, rounds and attractors so far.

    def __init__(self, system: System, work: Progress) -> None:
        self._system, self._p, self.work = system, system.parameters, work
        self.critical = lowest_critical_mu(system)
        upper = PARAMETERS["mu"].upper
        self._upper_mu = min(_UPPER_MU_FACTOR * max(self.critical or 0.0, self._p.mu, 1.0), upper)
        self.searched_to = self._upper_mu if self.critical is None else self.critical
        self.branches: list[CycleBranch] = []
        self.rounds: list[SearchRound] = []
        self.not_followed = ""
        self.growth_at_any_size: float | None = None
        self._attractors: list[OtherAttractor] = []
        self._is_undamped = self._rounds_exhausted = False

    def run(self) -> None:
        if not self._system.separation and self._p.k_nl == 0.0:
            self.not_followed = "the system is linear"
            return
        if self._p.c1 == 0.0 and self._p.c2 == 0.0:
            self.not_followed = "there is no damping"
            self._is_undamped = True
            return
        if self._p.k_nl == 0.0:
            self.growth_at_any_size = least_growth_mu(self._p, self.searched_to)
            if self.growth_at_any_size is not None:
                self._record(self.growth_at_any_size, "unbounded growth")
        self._follow_from_hopf()
        self.work.report(_BRANCH_SHARE)
        # Scouts lower the least μ cheaply where many motions reach cycles.
        self._run_rounds(SCOUT_STARTS, _BRANCH_SHARE)
        starts = starts_within_limit(self.rounds[-1])
        if starts > SCOUT_STARTS and not self._rounds_exhausted:
            self._run_rounds(starts, _SCOUTS_END)

    @property
    def budget_ended(self) -> bool:
        """Whether rounds were cut off, or the final round has no motions or undecided ones."""
        if not self.rounds:
            return False
        final_round = self.rounds[-1]
        return self._rounds_exhausted or bool(final_round.undecided) or not final_round.starts

    @property
    def unknown_above(self) -> float | None:
        """The μ above which too many motions are undecided; None if enough are decided."""
        if self._is_undamped or self._rounds_exhausted:
            return 0.0
        if not self.rounds:
            return None
        final_round = self.rounds[-1]
        if not final_round.starts:
            return 0.0
        if final_round.undecided < _UNDECIDED_LIMIT * final_round.starts:
            return None
        limit = _UNDECIDED_LIMIT * final_round.starts / len(final_round.levels)
        index = next(
            index for index, count in enumerate(final_round.undecided_at) if count >= limit
        )
        return final_round.levels[index - 1] if index else 0.0

    def attractors_below_critical(self) -> tuple[OtherAttractor, ...]:
        # A rising branch has its least μ at the critical μ, to rounding.
        limit = math.inf if self.critical is None else (1.0 - _MU_ROUNDING) * self.critical
        below = (attractor for attractor in self._attractors if attractor.mu < limit)
        return tuple(sorted(below, key=lambda attractor: attractor.mu))

    def coexisting(self) -> tuple[CyclePoint, ...]:
        # The stable cycles at the μ of the parameter set, by growing size.
        mu = self._p.mu
        curves = (curve for curve in self.branches if curve.low <= mu <= curve.high)
        cycles = [cycle for curve in curves for cycle in cycles_at(curve, mu) if cycle.stable]
        distinct: list[CyclePoint] = []
        for cycle in sorted(cycles, key=lambda cycle: cycle.half_range):
            size = cycle.half_range
            if not distinct or size - distinct[-1].half_range > _SIZE_TOLERANCE * size:
                distinct.append(cycle)
        return tuple(distinct)

    def _should_continue(self, _fraction: float) -> bool:
        return self.work.should_continue()

    def _least_mu(self) -> float:
        # The least μ of the attractors so far, below which to search.
        return min((attractor.mu for attractor in self._attractors), default=self.searched_to)

    def _follow_from_hopf(self) -> None:
        if self.critical is None:
            self.not_followed = "there is no Hopf point"
            return
        separation = self._system.separation
        at_hopf, upper_mu = self._p.with_values({"mu": self.critical}), self._upper_mu
        try:
            curve = branch(
                at_hopf,
                "mu",
                low=0.0,
                high=upper_mu,
                separation=separation,
                progress=self._should_continue,
            )
        except ComputationError as error:
            self.not_followed = str(error)
        else:
            self._add_branch(curve, "continuation")

    def _run_rounds(self, starts: int, fraction: float) -> None:
        # Run rounds until one finds no attractor. As the number of rounds is not known in advance,
        # the progress begins at `fraction`, and each round halves its distance to twice `fraction`.
        for count in range(_ROUND_LIMIT):
            if not self._find_lower_attractor(starts):
                return
            self.work.report(fraction * (2.0 - 0.5**count))
        self._rounds_exhausted = True

    def _find_lower_attractor(self, starts: int) -> bool:
        # Run a round below the least known μ; return whether it found an attractor.
        least_mu = self._least_mu()
        search_round = RunningRound(self._system, least_mu, starts, progress=self._should_continue)
        while self._least_mu() >= least_mu and search_round.advance():
            # Shoot from persisting motions until a cycle is found: its branch leads to lower μ.
            for motion in search_round.persistent_motions(_SHOTS_PER_LEVEL)[:_SHOTS_PER_STAGE]:
                if self._follow_cycle_near(motion):
                    break
        result = search_round.result()
        self.rounds.append(result)
        unbounded = next(iter(result.unbounded), None)
        if unbounded is not None and unbounded.mu < self._least_mu():
            self._record(least_unbounded_mu(self._system, unbounded, result), "unbounded growth")
        settled = next(iter(result.settled), None)
        if settled is not None and settled.mu < self._least_mu():
            # Shooting found no cycle: the motion is on a torus, or its period is long.
            low = _TORUS_RANGE * max((mu for mu in result.levels if mu < settled.mu), default=0.0)
            self._record(least_persistent_mu(self._system, settled, low), "other motion")
        return self._least_mu() < least_mu

    def _record(
        self,
        mu: float,
        kind: AttractorKind,
        found_by: FoundBy = "global search",
        cycle: CyclePoint | None = None,
    ) -> None:
        self._attractors.append(OtherAttractor(mu, found_by, kind, cycle))

    def _add_branch(self, curve: CycleBranch, found_by: FoundBy) -> None:
        self.branches.append(curve)
        cycle = least_attracting_cycle(curve)
        if cycle is not None:
            self._record(cycle.value, "limit cycle", found_by, cycle)
            if event_at(curve, cycle) in (EventKind.TORUS, EventKind.PERIOD_DOUBLING):
                # Beyond this event a torus or a cycle of twice the period is stable; it may exist
                # at lower μ than the cycles of the branch.
                motion = Survivor(cycle.value, cycle.start, cycle.half_range)
                low = _TORUS_RANGE * min(point.value for point in curve.points)
                mu = least_persistent_mu(self._system, motion, low)
                if mu < cycle.value:
                    self._record(mu, "other motion")
        for end, point in zip(curve.ends, (curve.points[0], curve.points[-1]), strict=True):
            # Motions beyond an unstable cycle grow, without bounds where the branch itself does.
            if end is End.UNBOUNDED and not point.stable:
                self._record(point.value, "unbounded growth", found_by)

    def _follow_cycle_near(self, motion: Survivor) -> bool:
        # Shoot for a stable cycle near a motion and follow its branch; return whether there is one.
        system = self._system.with_values({"mu": motion.mu})
        try:
            orbit = Explorer(system, work=self.work).reach(motion.state, max_legs=_LEG_LIMIT).orbit
        except ComputationError:
            return False
        if orbit is None:
            return False
        cycle, mu_range = (orbit.start, orbit.period), (0.0, self._upper_mu)
        try:
            curve = branch_through(system, "mu", cycle, mu_range, progress=self._should_continue)
        except ComputationError:
            # Continuation cannot follow the cycle: it counts at the μ of the motion.
            self._record(motion.mu, "limit cycle")
        else:
            self._add_branch(curve, "global search")
        return True
