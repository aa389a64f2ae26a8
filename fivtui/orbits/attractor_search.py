"""Attractors of one parameter set, found by transients from several starts.

If the equilibrium is stable and other attractors exist, they coexist: a disturbance may lead from
one to another. The standard starts are the static start, at rest at the equilibrium of μ = 0, and
releases at rest at several heights above and below the equilibrium.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Final

from fivtui.model import OnProgress, Parameters, Progress, System, check_off_edge, system_of
from fivtui.results import SystemResult, scene_text, to_data
from fivtui.transient import Kernel

from .basins import EscapeOffset, escape_offset
from .explorer import AT_REST, Attractor, Explorer, Kind, add_attractor, standard_starts

# Share of the progress that is reported for the search for attractors.
_SEARCH_SHARE: Final = 0.3
# Descriptions of attractors that are no limit cycles, for warnings.
_DESCRIPTIONS: Final = {
    Kind.UNBOUNDED: "unbounded growth",
    Kind.UNSETTLED: "motion that did not settle in the time allowed",
}


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Coexistence(SystemResult):
    """The attractors of a parameter set.

    Attributes
    ----------
    system : System
        The system, with `parameters` and `separation`.
    attractors : tuple of Attractor
        Those found, the equilibrium first.
    reached : tuple of int
        Index in `attractors` of the attractor that each start reaches, the static start first.
    stable : bool
        Whether the equilibrium is stable by its eigenvalues, even if no start reaches it.
    escape : EscapeOffset or None
        The smallest vertical offsets that leave the equilibrium's basin, if another attractor
        coexists with it.
    """

    system: System
    attractors: tuple[Attractor, ...]
    reached: tuple[int, ...]
    stable: bool
    escape: EscapeOffset | None

    @property
    def others(self) -> tuple[Attractor, ...]:
        """The attractors besides rest: limit cycles and unbounded growth."""
        rest = (*AT_REST, Kind.UNSETTLED)
        return tuple(attractor for attractor in self.attractors if attractor.kind not in rest)

    @property
    def coexists(self) -> bool:
        """Whether the equilibrium is stable and vibration or unbounded growth was also reached."""
        reaches_rest = any(attractor.kind in AT_REST for attractor in self.attractors)
        return (reaches_rest or self.stable) and bool(self.others)

    @property
    def settled(self) -> bool:
        """Whether every motion settled in the time allowed."""
        return all(attractor.kind is not Kind.UNSETTLED for attractor in self.attractors)

    @property
    def warning(self) -> str | None:
        """Warning if another attractor coexists with rest, or a motion did not settle."""
        if not self.coexists:
            return None if self.settled else "some motions did not settle in the time allowed"
        descriptions = [
            _DESCRIPTIONS.get(attractor.kind, f"a {attractor.description}")
            for attractor in self.attractors
            if attractor.kind not in AT_REST
        ]
        coexistence = f"it coexists with {' and '.join(descriptions)}"
        if self.escape is None:
            return f"the equilibrium is reached only from some starts: {coexistence}"
        offsets = [
            f"{value:.4g} m {side}"
            for side, value in (("above", self.escape.up), ("below", self.escape.down))
            if value is not None
        ]
        # Such as "; no return after a release at rest 0.2 m above or 0.3 m below it".
        escape = f"; no return after a release at rest {' or '.join(offsets)} it" if offsets else ""
        return f"the equilibrium is stable only for small disturbances: {coexistence}{escape}"

    def _summary(self) -> list[tuple[str, str]]:
        # The scene of a result is its parameter set, and whether separation is considered.
        rows = [
            ("scene", scene_text(self.system)),
            ("equilibrium", self._equilibrium()),
            *(
                (
                    f"attractor {index}",
                    f"{attractor.description}: {self.reached.count(index)} starts",
                )
                for index, attractor in enumerate(self.attractors)
            ),
        ]
        return rows if self.warning is None else [*rows, ("warning", self.warning)]

    def _equilibrium(self) -> str:
        if any(attractor.kind is Kind.STICK for attractor in self.attractors):
            return "the slider sticks to the belt at rest"
        return "stable" if self.stable else "unstable"

    def to_dict(self) -> dict[str, Any]:
        """The object that ``fivtui attractors --json`` prints.

        Keys are ``attractors``, ``coexistence``, ``escape_offset`` (``up`` and ``down``, m, or
        None) and ``warning`` (text, or None).
        """
        return {
            "attractors": [attractor.to_dict() for attractor in self.attractors],
            "coexistence": self.coexists,
            "escape_offset": to_data(self.escape),
            "warning": self.warning,
        }


def attractors(
    parameters: Parameters | None = None,
    *,
    separation: bool = True,
    progress: OnProgress | None = None,
) -> Coexistence:
    """Find the attractors of motions: the equilibrium, limit cycles, or unbounded growth.

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
    Coexistence
        Attractors reached from starts around the equilibrium, and the smallest offsets that leave
        it if another attractor coexists. There may be more attractors.

    Raises
    ------
    ComputationError
        If there is no equilibrium, eigenvalues do not decide its stability (F = 0 with
        separation), or a motion cannot be followed.
    Cancelled
        If `progress` returned False.

    Examples
    --------
    >>> from fivtui import Parameters, attractors
    >>> result = attractors(Parameters(mu=0.2))
    >>> [str(attractor.kind) for attractor in result.attractors], result.coexists
    (['equilibrium'], False)
    """
    return coexistence(system_of(parameters, separation), progress=progress)


def coexistence(
    system: System,
    *,
    kernel: Kernel | None = None,
    progress: OnProgress | None = None,
    on_found: Callable[[Coexistence], None] = lambda _: None,
) -> Coexistence:
    """As `attractors`, with a choice of the kernel.

    `on_found` is called with the attractors before the longer search for offsets that leave the
    equilibrium's basin.
    """
    work = Progress(progress)
    search_work, escape_work = work.stage(0.0, _SEARCH_SHARE), work.stage(_SEARCH_SHARE, 1.0)
    result = find_attractors(system, kernel=kernel, progress=search_work.callback)
    if not result.coexists:
        work.report(1.0)
        return result
    on_found(result)
    escape = escape_offset(system, kernel=kernel, progress=escape_work.callback)
    return replace(result, escape=escape)


def find_attractors(
    system: System, *, kernel: Kernel | None = None, progress: OnProgress | None = None
) -> Coexistence:
    """The attractors that several starts reach, without the search for escape offsets.

    The equilibrium comes first, then cycles by growing half peak-to-peak.
    """
    check_off_edge(system)
    work = Progress(progress)
    explorer = Explorer(system, kernel=kernel, work=work)
    starts = standard_starts(explorer)
    attractors: list[Attractor] = []
    reached = []
    for count, start in enumerate(starts):
        work.report(count / len(starts))
        reached.append(add_attractor(attractors, explorer.reach(start)))
    work.advance(1.0)
    # Indices in `attractors` in the order of the result, and their inverse.
    order = sorted(range(len(attractors)), key=lambda index: _sort_key(attractors[index]))
    rank = {index: position for position, index in enumerate(order)}
    return Coexistence(
        system=system,
        attractors=tuple(attractors[index] for index in order),
        reached=tuple(rank[index] for index in reached),
        stable=explorer.equilibrium_attracts,
        escape=None,
    )


def _sort_key(attractor: Attractor) -> tuple[bool, bool, int, float]:
    # Sort key: rest first, then cycles by kind and size, then attractors without an orbit.
    return (
        attractor.kind not in AT_REST,
        attractor.orbit is None,
        list(Kind).index(attractor.kind),
        attractor.half_range or 0.0,
    )
