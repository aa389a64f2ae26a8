"""Trials at the extremes: scenes that break solvers, every method on each, and its verdict.

The truth beside the scenes comes from an independent solver in quadruple precision
(``tests/references``). Every trial is bounded by a number of steps, never by a clock.
"""

import enum
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cache
from importlib.resources import files
from typing import Final

from fivtui.kernel import loader
from fivtui.model import Cancelled, ComputationError, InputError, Parameters, unknown_name
from fivtui.simulation import simulate
from fivtui.transient import KernelChoice, Progress, Start, Transient

TRUTH_FILE: Final = "trial_truth.json"
_TOL: Final = 1e-9
# Largest error of a result that is right: this, or so many tolerances if that is more.
_ACCURACY: Final = 1e-4
_TOLERANCES: Final = 20.0
# Looks at the progress of an FMU, at 128 communication steps each.
_LOOKS: Final = 100


@dataclass(frozen=True, slots=True)
class Trial:
    """A scene at an extreme.

    Attributes
    ----------
    name : str
        Short name.
    meaning : str
        What is extreme about it.
    parameters : Parameters
        The parameter set.
    t_end : float
        Horizon, s.
    tol : float
        Relative tolerance.
    separation : bool
        Whether separation is considered.
    start : "static" or tuple of four floats
        See `simulate`.
    truth_of : str or None
        Name of the trial whose truth it shares; None if no finite answer exists.
    """

    name: str
    meaning: str
    parameters: Parameters
    t_end: float
    tol: float = _TOL
    separation: bool = True
    start: Start = "static"
    truth_of: str | None = ""


@dataclass(frozen=True, slots=True)
class Truth:
    """What a trial should give.

    Attributes
    ----------
    x, vx, y, vy : float
        Final state, m and m/s.
    y_abs, x_abs : float
        Greatest |y| and |x|, m.
    separations : int
        Number of separations.
    separated_time : float
        Time off the belt, s.
    """

    x: float
    vx: float
    y: float
    vy: float
    y_abs: float
    x_abs: float
    separations: int
    separated_time: float


class Verdict(enum.StrEnum):
    """What became of a trial."""

    RIGHT = "right"
    REFUSED = "refused"
    WRONG = "wrong"


@dataclass(frozen=True, slots=True)
class Finding:
    """A method on a trial.

    Attributes
    ----------
    verdict : Verdict
        What became of it.
    error : float or None
        Greatest error of final and greatest displacements, relative to the greatest, and of the
        time off the belt, relative to the horizon. None if refused.
    reason : str
        Why it was refused, or what is wrong.
    steps : int or None
        Steps taken, if not refused.
    """

    verdict: Verdict
    error: float | None = None
    reason: str = ""
    steps: int | None = None


@dataclass(frozen=True, slots=True)
class Contestant:
    """A method under trial: its name, kernel, and the steps it may take."""

    method: str
    max_steps: int
    kernel: KernelChoice = "auto"


CONTESTANTS: Final[Mapping[str, Contestant]] = {
    "taylor": Contestant("taylor", 3_000_000),
    "taylor-interpreted": Contestant("taylor", 15_000, "interpreted"),
    "rk4": Contestant("rk4", 20_000),
    "scipy-dop853": Contestant("scipy-dop853", 8_000),
    "scipy-radau": Contestant("scipy-radau", 8_000),
    "scipy-lsoda": Contestant("scipy-lsoda", 25_000),
    "fmu": Contestant("fmu", _LOOKS * 128),
}

_BASE_T: Final = 20.0
TRIALS: Final[Mapping[str, Trial]] = {
    trial.name: trial
    for trial in (
        Trial("hard-cubic", "k_nl = 1e9 N/m³", Parameters(k_nl=1e9), 20.0),
        Trial("hard-linear", "k2 = 1e8 N/m", Parameters(k2=1e8), 2.0),
        Trial("light", "m = 1e-6 kg: stiff", Parameters(m=1e-6), 10.0),
        Trial("heavy-load", "F = 1e6 N", Parameters(F=1e6), 20.0),
        Trial("undamped", "no damping", Parameters(c1=0.0, c2=0.0), 20.0),
        Trial("strong-friction", "μ = 5: unbounded growth", Parameters(mu=5.0), 12.0),
        Trial("rest-on-switch", "F = 0: rests exactly on the switch", Parameters(F=0.0), 20.0),
        Trial(
            "start-on-switch",
            "F = 0, starts at y = ẏ = 0",
            Parameters(F=0.0),
            20.0,
            start=(0.5, 0.0, 0.0, 0.0),
        ),
        Trial("start-at-origin", "starts at y = ẏ = 0", Parameters(), 20.0, start=(0.0,) * 4),
        Trial(
            "lifted",
            "F = -20 N: comes off for good",
            Parameters(F=-20.0),
            20.0,
            start=(0.1, 0.0, -0.2, 1.0),
        ),
        Trial("long", "a horizon of 1e5 s", Parameters(), 1e5),
        Trial(
            "linear-growth",
            "k_nl = 0, contact never breaks: overflow",
            Parameters(k2=186.0, k_nl=0.0, mu=2.0),
            1e4,
            separation=False,
            truth_of=None,
        ),
        Trial("base", "base scene, tol 1e-9", Parameters(), _BASE_T),
        *(
            Trial(
                f"tol-{tol:g}",
                f"base scene, tol {tol:g}",
                Parameters(),
                _BASE_T,
                tol,
                truth_of="base",
            )
            for tol in (1e-3, 1e-6, 1e-13)
        ),
        Trial(
            "tol-too-small",
            "tol 1e-16, below rounding",
            Parameters(),
            _BASE_T,
            1e-16,
            truth_of="base",
        ),
    )
}


@cache
def _truths() -> Mapping[str, Truth]:
    text = files(__package__).joinpath(TRUTH_FILE).read_text(encoding="utf-8")
    truths = {}
    for name, entry in json.loads(text).items():
        separations = int(entry.pop("separations"))
        numbers = {key: float(value) for key, value in entry.items()}
        truths[name] = Truth(separations=separations, **numbers)
    return truths


def truth(trial: Trial) -> Truth | None:
    """What a trial should give.

    Parameters
    ----------
    trial : Trial
        The trial.

    Returns
    -------
    Truth or None
        None if there is no finite answer.
    """
    return None if trial.truth_of is None else _truths()[trial.truth_of or trial.name]


def run_trial(trial: Trial, contestant: Contestant) -> Finding:
    """Put one method to one trial.

    Parameters
    ----------
    trial : Trial
        The scene.
    contestant : Contestant
        The method.

    Returns
    -------
    Finding
        The verdict.

    Raises
    ------
    ComputationError
        If the compiled kernels cannot be loaded.
    """
    if contestant.method == "taylor" and contestant.kernel == "auto":
        loader.single.module()
    looks = iter(range(_LOOKS)) if contestant.method == "fmu" else None
    try:
        run = simulate(
            trial.parameters,
            t_end=trial.t_end,
            tol=trial.tol,
            separation=trial.separation,
            start=trial.start,
            method=contestant.method,
            max_steps=contestant.max_steps,
            kernel=contestant.kernel,
            progress=None if looks is None else lambda _part: next(looks, None) is not None,
        )
    except Cancelled:
        return Finding(Verdict.REFUSED, reason=f"over {contestant.max_steps} communication steps")
    except ComputationError as error:
        return Finding(Verdict.REFUSED, reason=error.why)
    except InputError as error:
        return Finding(Verdict.REFUSED, reason=str(error))
    return _judged(run, trial)


def _judged(run: Transient, trial: Trial) -> Finding:
    expected = truth(trial)
    if expected is None:
        return Finding(Verdict.WRONG, reason="no finite answer exists", steps=run.stats.steps)
    size = max(expected.x_abs, expected.y_abs) or 1.0
    differences = (
        run.final.x - expected.x,
        run.final.y - expected.y,
        run.peak.x_abs - expected.x_abs,
        run.peak.y_abs - expected.y_abs,
    )
    error = max(
        max(map(abs, differences)) / size,
        abs(run.events.separated_time - expected.separated_time) / trial.t_end,
    )
    right = error <= max(_ACCURACY, _TOLERANCES * trial.tol)
    reason = ""
    if run.events.separations != expected.separations:
        reason = f"{run.events.separations} separations, not {expected.separations}"
    return Finding(
        Verdict.RIGHT if right and not reason else Verdict.WRONG, error, reason, run.stats.steps
    )


def run_trials(
    trials: Sequence[str] = tuple(TRIALS),
    contestants: Sequence[str] = tuple(CONTESTANTS),
    *,
    progress: Progress | None = None,
) -> dict[str, dict[str, Finding]]:
    """Put methods to trials.

    Parameters
    ----------
    trials : sequence of str
        Names in `TRIALS`.
    contestants : sequence of str
        Names in `CONTESTANTS`.
    progress : callable, optional
        Called with the fraction done; cancelled when it returns False.

    Returns
    -------
    dict
        Findings by trial and contestant.

    Raises
    ------
    InputError
        If a name is unknown.
    ComputationError
        If the compiled kernels cannot be loaded.
    Cancelled
        If `progress` returned False.
    """
    _check_names("trial", trials, TRIALS)
    _check_names("method", contestants, CONTESTANTS)
    found: dict[str, dict[str, Finding]] = {name: {} for name in trials}
    pairs = [(trial, contestant) for trial in trials for contestant in contestants]
    for count, (trial, contestant) in enumerate(pairs):
        if progress is not None and not progress(count / len(pairs)):
            raise Cancelled
        found[trial][contestant] = run_trial(TRIALS[trial], CONTESTANTS[contestant])
    if progress is not None:
        progress(1.0)
    return found


def _check_names(kind: str, names: Sequence[str], known: Mapping[str, object]) -> None:
    for name in names:
        if name not in known:
            raise unknown_name(kind, name, known)


def trials_to_dict(found: Mapping[str, Mapping[str, Finding]]) -> dict[str, object]:
    """Findings as data that JSON can hold.

    Parameters
    ----------
    found : mapping
        What `run_trials` returned.

    Returns
    -------
    dict
        ``trials``, a list with the scene of each and its ``findings`` by method.
    """
    rows = []
    for name, findings in found.items():
        trial = TRIALS[name]
        rows.append(
            {
                "name": name,
                "meaning": trial.meaning,
                "parameters": trial.parameters.as_dict(),
                "separation": trial.separation,
                "start": trial.start if isinstance(trial.start, str) else list(trial.start),
                "t_end": trial.t_end,
                "tol": trial.tol,
                "findings": {key: asdict(finding) for key, finding in findings.items()},
            }
        )
    return {"trials": rows}
