"""The stepping of the native FMU on a belt of finite speed, compiled without the FMU around it."""

import ctypes
import random
import shutil
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator, Mapping
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Self

import pytest

from fivtui import Parameters, simulate
from fivtui.kernel.field_text import FLAGS, headers
from fivtui.model import TIMED, Course, Mode, State, System, course_of, static_start
from fivtui.taylor import local_tolerance
from fivtui.transient import Transient
from fmu_src.build.native_text import KERNEL, NATIVE

HERE = Path(__file__).parent
RUNNING = 5
SEEN = ("mode", "lifts", "landings", "sticks", "slips", "reversals", "changed_at", "end")
SCENES = {
    "slow": Parameters(v_belt=0.2),
    "static friction": Parameters(v_belt=1.0, mu_s=0.9),
    "friction law": Parameters(v_belt=1.0, mu_s=0.9, v_s=0.4),
    "at rest": Parameters(v_belt=0.0, mu=0.1, F=20.0),
    "fast": Parameters(v_belt=50.0),
    "always faster": Parameters(),
}
START = (0.5, 1.0, -1.5, 2.0)


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> ctypes.CDLL:
    """The functions of `stepping.c` beside this file."""
    target = tmp_path_factory.mktemp("stepping") / "stepping.so"
    if shutil.which("cc") is None and find_spec("ziglang") is None:
        pytest.skip("there is no compiler")
    cc = ["cc"] if shutil.which("cc") else [sys.executable, "-m", "ziglang", "cc"]
    flags = [flag for flag in FLAGS if flag not in ("-O3", "-Wall")]
    for header, content in headers().items():
        (target.parent / header).write_text(content, encoding="utf-8")
    includes = [f"-I{NATIVE}", f"-I{KERNEL}", f"-I{target.parent}"]
    text = [str(HERE / "stepping.c"), "-lm"]
    subprocess.run([*cc, *flags, "-Og", *includes, "-shared", "-o", str(target), *text], check=True)
    found = ctypes.CDLL(str(target))
    number, count, room = ctypes.c_double, ctypes.c_int64, ctypes.c_void_p
    for name, result, arguments in (
        ("size", count, []),
        ("begin", None, [room, room, count, count, room, number, number]),
        ("move", count, [room, number, number, room, count, room]),
        ("state", None, [room, number, room]),
        ("look", None, [room, room]),
        ("restore", count, [room, room]),
    ):
        function = getattr(found, f"motion_{name}")
        function.restype, function.argtypes = result, arguments
    return found


def floats(*values: float) -> Any:
    return (ctypes.c_double * len(values))(*values)


class Motion:
    """A motion under inputs that are given for every move."""

    def __init__(self, library: ctypes.CDLL, p: Parameters, state: State, tol: float) -> None:
        self.library, self.t, self.p = library, 0.0, p
        self.memory = ctypes.create_string_buffer(library.motion_size())
        belt = (p.v_belt, -1.0 if p.mu_s is None else p.mu_s, p.speed_law or 0.0)
        given = floats(*p.values(), *(value or 0.0 for value in belt))
        finite = p.v_belt is not None
        tol = local_tolerance(tol)
        library.motion_begin(self.memory, given, True, finite, floats(*state), 0.0, tol)

    def copy(self) -> Self:
        """The same motion from what of it is saved."""
        other = object.__new__(type(self))
        other.library, other.t, other.p = self.library, self.t, self.p
        other.memory = ctypes.create_string_buffer(len(self.memory))
        assert self.library.motion_restore(self.memory, other.memory) == RUNNING
        return other

    def move(
        self, t: float, slopes: Mapping[str, float] | None = None, *, to_switch: bool = False
    ) -> bool:
        """Move on; whether a switch ended it."""
        ramps, reached = [], floats(0.0, 0.0)
        for name in ("F", "mu", "v_belt"):
            ramps += [getattr(self.p, name) or 0.0, (slopes or {}).get(name, 0.0)]
        status = self.library.motion_move(
            self.memory, self.t, t, floats(*ramps), to_switch, reached
        )
        assert status == RUNNING
        self.t = reached[0]
        return bool(reached[1])

    @property
    def state(self) -> list[float]:
        found = floats(0.0, 0.0, 0.0, 0.0)
        self.library.motion_state(self.memory, self.t, found)
        return list(found)

    @property
    def seen(self) -> dict[str, float]:
        found = floats(*[0.0] * len(SEEN))
        self.library.motion_look(self.memory, found)
        return dict(zip(SEEN, found, strict=True))


def counts(run: Transient) -> dict[str, int]:
    """What the stepping counts, of a run."""
    found: Counter[str] = Counter()
    for name, count in run.events.transitions.items():
        first, then = name.split("-")
        found["lifts"] += count * (then == "separated")
        found["landings"] += count * (first == "separated")
        found["sticks"] += count * (then == "stick")
        found["slips"] += count * (first == "stick")
        found["reversals"] += count * ({first, then} == {"forward", "backward"})
    return {name: found[name] for name in ("lifts", "landings", "sticks", "slips", "reversals")}


@pytest.mark.parametrize("name", SCENES)
def test_constant_inputs_give_the_bits_of_simulate(name: str, library: ctypes.CDLL) -> None:
    p, given = SCENES[name], random.Random(1)
    motion, times = Motion(library, p, START, 1e-9), [0.0]
    while times[-1] < 20.0:
        times.append(times[-1] + given.choice([1e-3, 0.1, 0.7]))
        motion.move(times[-1])
    run = simulate(p, t_end=times[-1], start=START, tol=1e-9)
    assert motion.state == list(run.final[1:])
    if p.v_belt is not None:
        seen = motion.seen
        assert {key: seen[key] for key in counts(run)} == counts(run)
        changes = run.mode_changes
        assert seen["mode"] == (changes[-1].then if changes else Mode.FORWARD)
        assert seen["changed_at"] == (changes[-1].t if changes else 0.0)


def switches(motion: Motion, t_end: float) -> Iterator[tuple[float, float]]:
    """Times of switches, and modes after them."""
    while motion.move(t_end, to_switch=True):
        yield motion.t, motion.seen["mode"]


def test_a_move_ends_at_every_switch(library: ctypes.CDLL) -> None:
    p = SCENES["friction law"]
    run = simulate(p, t_end=20.0, start=START, tol=1e-9)
    found = list(switches(Motion(library, p, START, 1e-9), 20.0))
    assert found == [(change.t, change.then) for change in run.mode_changes]
    assert {mode for _, mode in found} == {0, 2, 3, 4}


def drive(motion: Motion, course: Course, t_end: float, step: float) -> None:
    """Move to t_end in communication steps over which the inputs are the course's ramps."""
    while motion.t < t_end:
        motion.p, rates = course.after(motion.t)
        motion.move(min(motion.t + step, t_end), {name: getattr(rates, name) for name in TIMED})


@pytest.mark.parametrize("step", [0.5, 0.125])
def test_ramps_give_the_answer_of_tables(step: float, library: ctypes.CDLL) -> None:
    tables = {
        "F": [(0.0, 20.0), (2.0, 80.0)],
        "mu": [(3.0, 0.3), (5.0, 0.5)],
        "v_belt": [(0.0, 2.0), (8.0, 0.0)],
    }
    for belt in ({"mu_s": 0.8, "v_s": 0.3}, {"mu_s": 0.9}, {}):
        course = course_of(Parameters(v_belt=1.0, k3=30.0, **belt), tables)
        p, _ = course.after(0.0)
        motion = Motion(library, p, static_start(System(p)), 1e-12)
        drive(motion, course, 12.0, step)
        run = simulate(p, t_end=12.0, over_time=tables, tol=1e-12)
        assert motion.state == pytest.approx(list(run.final[1:]), abs=1e-9)
        seen = motion.seen
        assert {key: seen[key] for key in counts(run)} == counts(run)
        assert run.events.sticks > 0


def test_steps_of_the_inputs_are_jumps_of_tables(library: ctypes.CDLL) -> None:
    speeds = [1.0, 0.6, 0.6, 1.4, 0.0, 0.8]
    rows = [(2.0 * n + part, v) for n, v in enumerate(speeds) for part in (0.0, 2.0)]
    p = Parameters(v_belt=1.0, mu_s=0.9)
    motion = Motion(library, p, START, 1e-12)
    for n, speed in enumerate(speeds):
        motion.p = p.with_values({"v_belt": speed})
        motion.move(2.0 * (n + 1))
    run = simulate(p, t_end=12.0, start=START, over_time={"v_belt": rows}, tol=1e-12)
    assert motion.state == pytest.approx(list(run.final[1:]), abs=1e-9)


def test_a_slider_sticks_on_over_ramps_of_the_speed_of_its_belt(library: ctypes.CDLL) -> None:
    # The values of the ramps do not fit together to the last bit.
    fixed = Parameters(k1=0.01, k3=1.0, F=60.0, v_belt=0.3)
    course = course_of(fixed, {"v_belt": [(0.0, 0.3), (3.0, 0.1), (7.0, 0.0)]})
    motion = Motion(library, fixed, (0.0, 0.3, static_start(System(fixed))[2], 0.0), 1e-9)
    speeds = []
    for n in range(1, 81):
        drive(motion, course, 0.1 * n, 0.1)
        speeds.append(motion.state[1])
    seen = motion.seen
    assert (seen["mode"], seen["sticks"], seen["slips"], seen["changed_at"]) == (4, 0, 0, 0)
    expected = [course.after(0.1 * n)[0].v_belt for n in range(1, 81)]
    assert speeds == pytest.approx(expected, abs=1e-15)


@pytest.mark.parametrize("slopes", [{}, {"v_belt": -0.03, "F": 2.0}])
def test_a_motion_is_restored_to_the_last_bit(
    slopes: dict[str, float], library: ctypes.CDLL
) -> None:
    for name in ("slow", "friction law", "always faster"):
        p = SCENES[name]
        speed = slopes if p.v_belt is not None else {}
        motion = Motion(library, p, START, 1e-9)
        for n in range(1, 21):
            motion.t = 0.25 * (n - 1)
            motion.move(0.25 * n, speed)
            if p.v_belt is not None:
                motion.p = motion.p.with_values(
                    {key: getattr(motion.p, key) + 0.25 * slope for key, slope in speed.items()}
                )
            other = motion.copy()
            assert other.state == motion.state
            assert other.seen == motion.seen
            motion.move(0.25 * n + 0.1, speed)
            other.move(0.25 * n + 0.1, speed)
            assert other.state == motion.state
            assert other.seen == motion.seen
            motion = other
