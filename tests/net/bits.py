"""Hashes of the bits of random runs: one for each kind of run and seed.

A block of runs is drawn from a seed; its hash changes if a bit of a result changes. The hashes
belong to the net, the recorded outputs with which `tests.net` compares new ones.
"""

import hashlib
import itertools
import math
import random
import struct
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import Any, Final

import fmpy
import numpy as np

from fivtui import ComputationError, Parameters, build_fmu, simulate, simulate_batch
from tests.net.text import SECTION_MARK
from tests.support.fmu_instance import FmuInstance

# Number of runs in a block, and their horizon, s; runs over time are shorter.
RUNS: Final = 50
T_END: Final = 15.0
_T_END_OVER_TIME: Final = 6.0
_FMU_STEPS: Final = 40
# Values are drawn as multiples of the base set, without functions of the C library, such as exp,
# whose rounding varies by platform.
_BASE: Final = Parameters().as_dict()
_STATES: Final = ("x", "vx", "y", "vy")


@dataclass(frozen=True, slots=True)
class Scene:
    """A random run: parameter values, whether separation is considered, and start."""

    values: Mapping[str, float]
    separation: bool
    start: tuple[float, float, float, float]


def draw_scene(rng: random.Random, *, belt: bool = False, law: bool = False) -> Scene:
    """A random run, optionally on a belt of finite speed and with a friction law."""
    # Some values and components of the start are exactly zero.
    values = {name: value * rng.uniform(0.3, 3.0) for name, value in _BASE.items()}
    values |= {"F": rng.uniform(-50.0, 300.0), "mu": rng.uniform(0.0, 1.5)}
    values["k3"] *= rng.random() < 0.9
    values["k_nl"] *= rng.random() < 0.85
    x, vx, y, vy = (rng.uniform(-1.5, 1.5) * size for size in (1.0, 3.0, 1.0, 3.0))
    y *= rng.random() < 0.8
    if belt:
        values["v_belt"] = rng.uniform(0.0, 4.0) * (rng.random() < 0.9)
        values["mu_s"] = values["mu"] * rng.uniform(1.0, 1.6)
        vx = values["v_belt"] if rng.random() < 0.2 else vx
    if law:
        values["v_s"] = rng.uniform(0.05, 2.0)
    return Scene(values, rng.random() < 0.9, (x, vx, y, vy))


def record_bits(kinds: Mapping[str, "Blocks"]) -> str:
    """Hashes of the blocks of kinds of runs."""
    lines = []
    for kind, (block_count, block_numbers) in kinds.items():
        for seed in range(block_count):
            # Zeros of both signs count as equal (−0.0 + 0.0 is 0.0), and so do all NaN.
            numbers = [
                math.nan if math.isnan(value) else value + 0.0 for value in block_numbers(seed)
            ]
            digest = hashlib.sha256(struct.pack(f"<{len(numbers)}d", *numbers)).hexdigest()
            lines += [f"{SECTION_MARK}{kind}, {RUNS} runs, seed {seed}", f"bits {digest[:20]}"]
    return "\n".join(lines) + "\n"


def _single_runs(
    seed: int, *, belt: bool = False, law: bool = False, runs: int = RUNS, **options: Any
) -> Iterator[float]:
    rng = random.Random(seed)
    for _ in range(runs):
        scene = draw_scene(rng, belt=belt, law=law)
        yield from _run_numbers(scene, options)


def _runs_over_time(seed: int) -> Iterator[float]:
    rng = random.Random(seed)
    for index in range(RUNS):
        # Of four runs three are on a belt, one of them with a friction law.
        on_belt, has_law = index % 4 > 0, index % 4 == 3
        scene = draw_scene(rng, belt=on_belt, law=has_law)
        tables = {"F": _draw_table(rng, 90.0)}
        if rng.random() < 0.5:
            tables["mu"] = _draw_table(rng, 0.9)
        if on_belt and rng.random() < 0.8:
            tables["v_belt"] = _draw_table(rng, 2.5)
        # The static coefficient exceeds all values of μ.
        values = {**scene.values, "mu": min(scene.values["mu"], 0.9)}
        values |= {"mu_s": 1.6} if on_belt else {}
        options = {"over_time": tables, "t_end": _T_END_OVER_TIME}
        yield from _run_numbers(Scene(values, scene.separation, scene.start), options)


def _draw_table(rng: random.Random, high: float) -> list[tuple[float, float]]:
    # A table over time with ramps, and occasionally a jump, of values up to `high`.
    rows: list[tuple[float, float]] = []
    for t in sorted(rng.uniform(0.0, _T_END_OVER_TIME) for _ in range(rng.randint(1, 4))):
        rows += [(t, rng.uniform(0.0, high)) for _ in range(1 + (rng.random() < 0.3))]
    return rows


def _run_numbers(scene: Scene, options: Mapping[str, Any]) -> Iterator[float]:
    # The numbers of a run's result; infinity for a run that fails.
    options = {"t_end": T_END, **options}
    try:
        run = simulate(
            Parameters(**scene.values),
            separation=scene.separation,
            start=scene.start,
            max_steps=100_000,
            **options,
        )
    except ComputationError:
        yield math.inf
        return
    final, peak, force, events = run.final, run.peak, run.contact_force, run.events
    # Half peak-to-peak of y in the second half of the run.
    y_half_range = run.steady.y_half_range
    yield from (final.t, final.x, final.vx, final.y, final.vy)
    yield from (peak.y_abs, peak.y_max, peak.y_min, peak.x_abs, peak.vx_max)
    yield from (y_half_range, force.min, force.max)
    yield from (events.separations, events.reattachments, events.separated_time)
    yield from (events.sticks, events.stick_time, run.stats.steps, *run.switch_times.tolist())


def _batch_runs(seed: int, *, belt: bool = False, law: bool = False) -> Iterator[float]:
    rng = random.Random(seed)
    scenes = [draw_scene(rng, belt=belt, law=law) for _ in range(RUNS)]
    batch = simulate_batch(
        {name: [scene.values[name] for scene in scenes] for name in scenes[0].values},
        separation=[scene.separation for scene in scenes],
        start=[scene.start for scene in scenes],
        t_end=T_END,
        max_steps=100_000,
        workers=1,
    )
    for values in batch.to_columns().values():
        yield from np.asarray(values, dtype=float).ravel().tolist()


@cache
def _fmu_folder() -> tempfile.TemporaryDirectory[str]:
    folder = tempfile.TemporaryDirectory(prefix="fivtui-net-")
    fmpy.extract(str(build_fmu(Path(folder.name) / "net.fmu", flavour="native")), folder.name)
    return folder


def _fmu_steps(seed: int, *, belt: bool = False, law: bool = False) -> Iterator[float]:
    rng = random.Random(seed)
    with FmuInstance(Path(_fmu_folder().name)) as instance:
        for _ in range(RUNS):
            scene = draw_scene(rng, belt=belt, law=law)
            start = {
                f"{name}_start": value for name, value in zip(_STATES, scene.start, strict=True)
            }
            values = {**scene.values, **start, "start_static": False, "finite_belt": belt}
            instance.begin(tol=1e-10, **values, separation=scene.separation)
            for _ in range(_FMU_STEPS):
                # Preload steps and ramps, and occasionally a jump of the friction.
                if rng.random() < 0.2:
                    instance.set(F=rng.uniform(-20.0, 150.0))
                instance.set_slopes(F=rng.uniform(-20.0, 20.0))
                instance.step(rng.uniform(0.01, 0.2))
                yield from instance.get(*_STATES, "P", "mode", "friction_slider")
            instance.fmi.reset()
            instance.t = 0.0


def _kinds(
    name: str, run: Callable[..., Iterable[float]], block_counts: tuple[int, int, int]
) -> Iterator[tuple[str, "Blocks"]]:
    # Runs on belts that are always faster than the slider, on belts of finite speed, and on those
    # with a friction law, by which friction falls with the sliding speed.
    always_faster_count, belt_count, law_count = block_counts
    yield name, (always_faster_count, run)
    yield f"{name} on belts", (belt_count, partial(run, belt=True))
    yield f"{name} on belts with a friction law", (law_count, partial(run, belt=True, law=True))


# The number of blocks of a kind of run, and the function that yields a block's numbers.
Blocks = tuple[int, Callable[[int], Iterable[float]]]
COMPILED_KINDS: Final[Mapping[str, Blocks]] = dict(
    itertools.chain(
        _kinds("single", _single_runs, (6, 3, 3)),
        # The compiled kernel computes the runs of a batch side by side, in the lanes of vectors.
        _kinds("lanes", _batch_runs, (10, 4, 4)),
        _kinds("native FMU", _fmu_steps, (3, 2, 2)),
        [("tables over time", (4, _runs_over_time))],
    )
)
_interpreted_runs = partial(_single_runs, kernel="interpreted", t_end=2.0)
INTERPRETED_KINDS: Final[Mapping[str, Blocks]] = {
    "interpreted": (1, _interpreted_runs),
    "interpreted on belts": (1, partial(_interpreted_runs, belt=True)),
}
