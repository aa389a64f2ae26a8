"""Each recipe of CONTRIBUTING for adding something works on a copy of the sources."""

import re
import shutil
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Final

import pytest

from tests.support.processes import run_python

ROOT: Final = Path(__file__).parents[1]
CONTRIBUTING: Final = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")


@dataclass(frozen=True)
class Edit:
    """A change of a file: replace the regular expression `old` by `new`, or write a new file."""

    path: str
    old: str
    new: str

    def make(self, root: Path) -> None:
        path = root / self.path
        if not self.old:
            assert not path.exists(), self.path
            path.write_text(self.new, encoding="utf-8")
            return
        text, count = re.subn(self.old, self.new, path.read_text(encoding="utf-8"))
        assert count > 0, (self.path, self.old)
        path.write_text(text, encoding="utf-8")


def paragraph_on(subject: str) -> str:
    """The paragraph on adding a subject."""
    (text,) = re.findall(rf"^\*\*{subject}\.\*\*.*?\n\n", CONTRIBUTING, re.MULTILINE | re.DOTALL)
    assert text.count("\n") <= 7
    return str(text)


def apply_edits(subject: str, edits: Iterable[Edit], root: Path) -> None:
    """Apply edits of files that the paragraph names, or of new files in folders that it names."""
    text = paragraph_on(subject)
    # The paragraph on friction laws refers to that on parameters for the files of new parameters.
    naming_text = text + paragraph_on("A parameter") if subject == "A friction law" else text
    for edit in edits:
        folder = edit.path.rpartition("/")[0]
        is_new_in_folder = not edit.old and f"`{folder}/" in text
        assert f"`{edit.path}`" in naming_text or is_new_in_folder, edit.path
        edit.make(root)
    for path in re.findall(r"`((?:fivtui|fmu_src)/[\w/]+\.\w+)`", text):
        assert (root / path).exists(), path


# A parameter: gravity g presses the slider onto the belt. The load F + m g replaces the preload F:
# the vertical force is P − F − m g, with the contact force P.
PARAMETER: Final = (
    Edit(
        "fivtui/model/parameters.py",
        r"    mu: float = _spec\(.*\n",
        r'\g<0>    g: float = _spec("g", "m/s^2", 0.0, (0.0, 1e3), "gravity towards the belt")\n',
    ),
    Edit("fivtui/model/field.py", r"return p\.F\n", "return p.F + p.m * p.g\n"),
    Edit("fivtui/transient/steppers/rk4.py", r'p\["F"\]', '(p["F"] + p["m"] * p["g"])'),
    Edit("fivtui/transient/steppers/rk4_on_belts.py", r'p\["F"\]', '(p["F"] + p["m"] * p["g"])'),
    Edit("fivtui/tui/session/equations.py", r"= P − F\"", '= P − F − m g"'),
)
# On the mass of 5 kg, gravity of 2 m/s² has the same effect as a preload that is larger by 10 N.
# Tests define FLAVOURS first, the kinds of FMU to build; with "native" the kernel is compiled, too.
CHECK_PARAMETER: Final = """
import math
from fivtui import *
from fivtui.cli import run
import numpy as np
from fivtui.equilibrium import critical_mu_derivatives, critical_speeds
from fivtui.model import System
from fivtui.model.slider_belt import static_start_change
from fivtui.orbits import branch
from fivtui.safety.hopf_branch import GROUP_PARAMETERS, dimensionless_groups
from fivtui.tui.session.equations import equations_with
from fivtui.tui.session.fields import FIELDS
from fivtui.model.parameters import PARAMETERS
from fivtui.model.slider_belt import Mode, accelerations

def same(first, second, tol=1e-9):
    for a, b in zip(first, second, strict=True):
        assert math.isclose(a, b, rel_tol=tol, abs_tol=tol), (first, second)

light, heavy = Parameters(g=2.0), Parameters(F=90.0)
run_of_heavy = simulate(heavy, t_end=3.5)
for method in ("taylor", "rk4", "scipy-dop853"):
    run_of_light = simulate(light, t_end=3.5, method=method)
    same(run_of_light.final, run_of_heavy.final, 1e-6)
    assert run_of_light.events.separations == run_of_heavy.events.separations > 0
names = ["F", "m", "g"]
first, second = (simulate(p, t_end=2.0, sensitivities=names).sensitivities for p in (light, heavy))
same(first["F"].final, second["F"].final)
# The load F + m g changes by m with g, and by g with m.
m, g = light.m, light.g
same(first["g"].final, [m * by_F for by_F in second["F"].final])
same(
    first["m"].final,
    [by_m + g * by_F for by_m, by_F in zip(second["m"].final, second["F"].final)],
)
linear = [p.with_values({"k_nl": 0.0}) for p in (light, heavy)]
first, second = (simulate(p, t_end=2.0, separation=False) for p in linear)
assert first.stats.kernel == "exact"
same(first.final, second.final)
first, second = (stability(p) for p in (light, heavy))
same([first.growth_rate, first.critical_mu[0].mu], [second.growth_rate, second.critical_mu[0].mu])
found = stability_map(Parameters(), {"g": [0.0, 2.0], "mu": [0.7]})
same([found.values[1, 0]], [second.growth_rate])
batch = simulate_batch({"g": [0.0, 2.0]}, t_end=2.0)
x, vx, y, vy = batch.final[1]
same([y], [simulate(heavy, t_end=2.0).final.y])
columns = sweep(vary={"g": (0.0, 2.0)}, t_end=2.0, outputs=["y_end"]).to_columns()
same([columns["y_end"][1]], [y])
assert run(["simulate", "--set", "g=2", "--t-end", "2", "--json"]) == 0
save_scene(Scene(name="mine", description="", parameters=light), "mine.toml")
assert load_scene("mine.toml").parameters == light
assert FIELDS["g"].meaning and equations_with(PARAMETERS["g"])
belt = {"v_belt": 1.0, "mu_s": 0.9}
law = {**belt, "v_s": 0.4}
tables = [{"F": [(0.0, preload), (2.0, preload + 20.0)]} for preload in (80.0, 90.0)]
for values, methods in (
    (belt, ("taylor", "rk4")),
    (law, ("taylor", "rk4", "scipy-dop853")),
):
    pair = [p.with_values(values) for p in (light, heavy)]
    for method in methods:
        first, second = (simulate(p, t_end=1.0, method=method) for p in pair)
        same(first.final, second.final, 1e-6)
    first, second = (
        simulate(p, t_end=1.0, over_time=table) for p, table in zip(pair, tables, strict=True)
    )
    same(first.final, second.final, 1e-6)
    first, second = (simulate(p, t_end=1.0, kernel="interpreted") for p in pair)
    same(first.final, second.final, 1e-6)
    names = ["F", "m", "g", "v_belt"]
    first, second = (simulate(p, t_end=1.0, sensitivities=names).sensitivities for p in pair)
    same(first["F"].final, second["F"].final, 1e-6)
    same(first["g"].final, [m * by_F for by_F in second["F"].final], 1e-6)
    first, second = (stability(p) for p in pair)
    same([c.mu for c in first.critical_mu], [c.mu for c in second.critical_mu])
    same([first.growth_rate], [second.growth_rate])
pairs = zip((light, heavy), tables, strict=True)
first, second = (simulate(p, t_end=2.0, over_time=table) for p, table in pairs)
same(first.final, second.final, 1e-6)
# Friction that falls from mu_s to mu as the sliding velocity grows.
weakening = [p.with_values({**law, "mu": 0.3}) for p in (light, heavy)]
speeds = [[c.v_belt for c in critical_speeds(System(p))] for p in weakening]
assert len(speeds[0]) == 1
same(*speeds)
first, second = (critical_mu_derivatives(System(p)) for p in (light, heavy))
same([first["g"], first["F"]], [m * second["F"], second["F"]])
same([first["m"]], [second["m"] + g * second["F"]])
members = {"g": np.array([0.0, 2.0])}, {"F": np.array([80.0, 90.0])}
first, second = (dimensionless_groups(Parameters(), varied, 2).ravel() for varied in members)
same(first, second)
# The dimensionless group k_nl (F + m g)²/k1³ depends on g and m by the load.
assert "g" in GROUP_PARAMETERS["k_nl"] and "m" in GROUP_PARAMETERS["k_nl"]
# Derivatives of the static start by g and F.
by_g = static_start_change(System(light), "g")
same(by_g, [m * by_F for by_F in static_start_change(System(heavy), "F")])
if "native" in FLAVOURS:
    # These take minutes with the interpreted kernel. Below the safe μ all disturbances die out.
    first, second = (safe_friction(p) for p in (light, heavy))
    same([first.safe_mu], [second.safe_mu], 1e-7)
    curves = [branch(p, "v_belt", low=2.0, high=2.6) for p in weakening]
    first, second = ([point.value for point in curve.points] for curve in curves)
    same([min(first), max(first)], [min(second), max(second)], 1e-6)
for flavour in FLAVOURS:
    fmu = build_fmu(f"{flavour}.fmu", flavour=flavour)
    driven = run_fmu(fmu, t_end=0.5, start_values={"g": 2.0}, outputs=["x", "vx", "y", "vy", "ay"])
    *state, ay = (driven.columns[name][-1] for name in ("x", "vx", "y", "vy", "ay"))
    t, *expected = simulate(heavy, t_end=0.5).final
    same(state, expected)
    same([ay], [accelerations(heavy, state, Mode.CONTACT)[1]])
    start = {"g": 2.0, "finite_belt": True, "v_belt": 1.0, "mu_s": 0.9, "v_s": 0.4}
    driven = run_fmu(fmu, t_end=0.5, start_values=start, outputs=["x", "vx", "y", "vy"])
    state = [driven.columns[name][-1] for name in ("x", "vx", "y", "vy")]
    t, *expected = simulate(heavy.with_values(law), t_end=0.5).final
    same(state, expected)
"""


# A friction law: a viscous term, μ + μ_v v + (μ_s − μ) exp(−v/v_s) at a sliding speed v. In the RK4
# `p["v"]` is v_belt and `sign` is that of v_belt − ẋ, so that the speed is their product.
LAW: Final = (
    Edit(
        "fivtui/model/parameters.py",
        r"    mu: float = _spec\(.*\n",
        r'\g<0>    mu_v: float = _spec("μ_v", "s/m", 0.0, (0.0, 1e3), "viscous friction")\n',
    ),
    Edit(
        "fivtui/model/field.py",
        r"(?P<constant>return p\.mu) \+ (?P<exponential>.*/ p\.v_s\))",
        r"\g<constant> + p.mu_v * speed + \g<exponential>",
    ),
    Edit(
        "fivtui/transient/steppers/rk4_on_belts.py",
        r'friction = sign \* \(p\["mu"\] \+',
        r'\g<0> p["mu_v"] * sign * (p["v"] - vx) +',
    ),
)
CHECK_LAW: Final = """
import math
import numpy as np
from fivtui import *
from fivtui.equilibrium import critical_mu_on_belt, critical_speeds
from fivtui.model import System

from fivtui.model.slider_belt import Mode, accelerations, friction_force
from fivtui.orbits import branch

def same(first, second, tol=1e-9):
    for a, b in zip(first, second, strict=True):
        assert math.isclose(a, b, rel_tol=tol, abs_tol=tol), (first, second)

law = Parameters(v_belt=1.0, mu=0.3, mu_s=0.9, v_s=0.4, mu_v=0.02)
start = (0.3, 0.0, -0.5, 0.0)
x, vx, y, vy = state = (0.1, 0.2, -0.3, 0.4)
speed = law.v_belt - vx
mu = law.mu + (law.mu_s - law.mu) * math.exp(-speed / law.v_s) + law.mu_v * speed
contact_force = -law.k2 * y - law.k_nl * y**3
same([friction_force(law, state, Mode.FORWARD)], [mu * contact_force])
methods = ("taylor", "rk4", "scipy-dop853")
runs = [simulate(law, t_end=3.0, start=start, method=method) for method in methods]
for run in runs:
    same(run.final, runs[0].final, 1e-6)
    assert run.events.transitions == runs[0].events.transitions
assert {"forward-stick", "stick-forward"} <= {*runs[0].events.transitions}
same(simulate(law, t_end=3.0, start=start, kernel="interpreted").final, runs[0].final, 1e-7)
without = simulate(law.with_values({"mu_v": 0.0}), t_end=3.0, start=start)
assert abs(without.final.y - runs[0].final.y) > 1e-3
constant = {"F": [(0.0, 80.0)], "mu": [(0.0, 0.3)], "v_belt": [(0.0, 1.0)]}
for kernel in ("auto", "interpreted"):
    run = simulate(law, t_end=3.0, start=start, over_time=constant, kernel=kernel)
    same(run.final, runs[0].final, 1e-6)
changing = {"mu": [(0.0, 0.3), (3.0, 0.2)], "v_belt": [(0.0, 1.0), (3.0, 2.0)]}
first, second = (
    simulate(law, t_end=3.0, start=start, over_time=changing, kernel=kernel)
    for kernel in ("auto", "interpreted")
)
same(first.final, second.final, 1e-6)
members = {name: [value, value] for name, value in law.as_dict().items()}
many = simulate_batch({**members, "mu_v": [0.0, 0.02]}, t_end=3.0, start=start)
same(many.final[1], runs[0].final[1:])
same(many.final[0], without.final[1:])
rates = simulate(law, t_end=1.0, start=start, sensitivities=["mu_v", "v_s"]).sensitivities
for name, step in (("mu_v", 1e-6), ("v_s", 1e-6)):
    ends = [
        simulate(p, t_end=1.0, start=start).final.y
        for p in (law.with_values({name: getattr(law, name) + change}) for change in (-step, step))
    ]
    same([rates[name].final.y], [(ends[1] - ends[0]) / (2 * step)], 1e-5)
# A viscous term damps: sliding is stable from a lower speed of the belt on.
critical_speed_without, critical_speed = (
    critical_speeds(System(law.with_values({"mu_v": mu_v})))[0].v_belt for mu_v in (0.0, 0.02)
)
assert critical_speed < critical_speed_without
for v in (critical_speed * 0.999, critical_speed * 1.001):
    growth_rate = stability(law.with_values({"v_belt": v})).growth_rate
    assert (growth_rate > 0.0) is (v < critical_speed)
for critical in critical_mu_on_belt(System(law)):
    assert abs(stability(law.with_values({"mu": critical.mu})).growth_rate) < 1e-9
point = stability(law).equilibrium
ax, ay = accelerations(law, (point.x, 0.0, point.y, 0.0), point.mode)
assert abs(ax) + abs(ay) < 1e-12
if "native" in FLAVOURS:
    assert branch(law, "v_belt", low=critical_speed * 0.9, high=critical_speed * 1.1).points
for flavour in FLAVOURS:
    fmu = build_fmu(f"{flavour}.fmu", flavour=flavour)
    values = dict(
        finite_belt=True, v_belt=1.0, mu=0.3, mu_s=0.9, v_s=0.4, mu_v=0.02, start_static=False,
        x_start=0.3, y_start=-0.5,
    )
    outputs = ["x", "vx", "y", "vy", "friction_slider", "mode"]
    driven = run_fmu(fmu, t_end=3.0, start_values=values, outputs=outputs)
    *state, friction, mode = (driven.columns[name][-1] for name in outputs)
    same(state, runs[0].final[1:], 1e-7)
    same([friction], [friction_force(law, state, Mode(int(mode)))])
"""

# A mode: the damping doubles while a slider that is lifted by a negative preload is off the belt.
MODE_OFF_BELT: Final = '''def off_belt(p: Parameters) -> Mode:
    """The mode of a slider off the belt."""
    return Mode.LIFTED if p.F < 0.0 else Mode.SEPARATED


def accelerations'''
# A mode ends when a guard falls to zero: HEIGHT is y, DEPTH is −y.
LIFTED_ROW: Final = """    Mode.LIFTED: ModeRow(
        "lifted",
        friction="0",
        in_contact=False,
        friction_sign=0.0,
        finite_belt=False,
        ends=(Transition(Guard.HEIGHT, (Mode.CONTACT,)),),
    ),
"""
DAMPING_FACTOR: Final = "(2.0 if mode is Mode.LIFTED else 1.0)"
# In C `field.damping_y` is the factor of ẏ in ÿ in the current mode, and `drag` that in contact.
MODE: Final = (
    Edit("fivtui/model/modes.py", r"    STICK = 4\n", r"\g<0>    LIFTED = 5\n"),
    Edit("fivtui/model/modes.py", r"Guard\.DEPTH, \(", r"\g<0>Mode.LIFTED, "),
    Edit("fivtui/model/modes.py", r"    Mode\.CONTACT: ModeRow\(", LIFTED_ROW + r"\g<0>"),
    Edit("fivtui/model/field.py", r"(yvy = .*0\.0), 1\.0,", rf"\1, {DAMPING_FACTOR},"),
    Edit("fivtui/model/slider_belt.py", r"y, vy, force", f"y, {DAMPING_FACTOR} * vy, force"),
    Edit("fivtui/model/slider_belt.py", r"(return |mode=|0\.0, )Mode\.SEPARATED", r"\1off_belt(p)"),
    Edit("fivtui/model/slider_belt.py", r"def accelerations", MODE_OFF_BELT),
    Edit(
        "fivtui/transient/steppers/rk4.py",
        r"        ay = .*",
        r'        twice = ~contact & (p["F"] < 0.0)\n\g<0>',
    ),
    Edit(
        "fivtui/transient/steppers/rk4.py",
        r'p\["c2"\] \* vy',
        'p["c2"] * np.where(twice, 2.0, 1.0) * vy',
    ),
    Edit(
        "fivtui/transient/steppers/rk4.py",
        r"return Mode\(int\(contact\[0\]\)\)",
        "return Mode.CONTACT if contact[0] else mode_of_flight(self._p)",
    ),
    Edit(
        "fivtui/transient/steppers/rk4.py",
        r"class RungeKuttaStepper",
        "def mode_of_flight(p: Parameters) -> Mode:\n"
        "    return Mode.LIFTED if p.F < 0.0 else Mode.SEPARATED\n\n\n\\g<0>",
    ),
    Edit("fivtui/kernel/motion.h", r"V coupling, preload,", "V drag, coupling, preload,"),
    Edit(
        "fivtui/kernel/motion.h",
        r"CONTACT : SEPARATED",
        "CONTACT : get_lane(&w->preload, lane) < 0.0 ? LIFTED : SEPARATED",
    ),
    Edit(
        "fivtui/kernel/motion.h",
        r"    w->field\.d_x = .*\n",
        r"\g<0>    V twice = choose(is_separated & (w->preload < 0.0), splat(2.0), splat(1.0));\n"
        r"    w->field.damping_y = w->drag * twice;\n",
    ),
    Edit(
        "fivtui/kernel/problem.h",
        r"MEMBER\(w, field\.damping_y, lane\) =",
        r"MEMBER(w, drag, lane) = \g<0>",
    ),
)
# All methods have the same motion with the mode, whose damping is twice that of separation.
CHECK_MODE: Final = """
import math
import numpy as np
from fivtui import *
from fivtui.model import Mode
from fivtui.model.slider_belt import jacobian, mode_of

def same(first, second):
    for a, b in zip(first, second, strict=True):
        assert math.isclose(a, b, rel_tol=1e-7, abs_tol=1e-8), (first, second)

p, start = Parameters(F=-5.0), (0.5, 0.0, 0.4, -2.0)
runs = {
    method: simulate(p, t_end=5.0, start=start, method=method, samples=np.linspace(0.0, 5.0, 51))
    for method in ("taylor", "rk4", "scipy-dop853")
}
first = runs["taylor"]
assert first.events.reattachments > 1 and first.events.separations > 1
assert set(first.trajectory.mode.tolist()) == {Mode.CONTACT, Mode.LIFTED}
for run in runs.values():
    same(run.final, first.final)
    same(run.trajectory.P, first.trajectory.P)
    assert run.trajectory.mode.tolist() == first.trajectory.mode.tolist()
    assert (run.events.separations, run.first_mode) == (first.events.separations, Mode.LIFTED)
# The last entry of the Jacobian is the factor of ẏ in ÿ, independent of the height y.
lifted, separated = (
    jacobian(p, y=1.0, mode=mode)[3][3] for mode in (Mode.LIFTED, Mode.SEPARATED)
)
assert lifted == 2.0 * separated
rates = simulate(p, t_end=2.0, start=start, sensitivities=["c2"]).sensitivities["c2"]
step = 1e-5
ends = [
    simulate(p.with_values({"c2": p.c2 + change}), t_end=2.0, start=start).final.y
    for change in (-step, step)
]
assert math.isclose(rates.final.y, (ends[1] - ends[0]) / (2 * step), rel_tol=1e-5)
fmu = build_fmu("lifted.fmu", flavour="python")
values = dict(F=-5.0, x_start=0.5, y_start=0.4, vy_start=-2.0, start_static=False)
driven = run_fmu(fmu, t_end=5.0, start_values=values, outputs=["y", "mode"])
same([driven.columns["y"][-1]], [first.final.y])
assert set(driven.columns["mode"].tolist()) == {1.0, 5.0}
"""

# A method: the explicit midpoint rule.
MIDPOINT: Final = '''"""The explicit midpoint rule."""

from .request import Request
from .steppers.rk4 import FloatArray, RungeKutta4, RungeKuttaStepper


class MidpointSteps(RungeKutta4):
    """Second-order steps of fixed length."""

    def _step(self, state: FloatArray, contact, step: FloatArray) -> FloatArray:
        half = state + 0.5 * step * self._derivatives(state, contact)
        return state + step * self._derivatives(half, contact)


def midpoint_stepper(request: Request) -> RungeKuttaStepper:
    """The integrator of a request by the midpoint rule."""
    p, step = request.parameters, request.step or 1e-3
    steps = MidpointSteps([p], [request.initial], step=step, separation=request.separation)
    return RungeKuttaStepper(p, steps)
'''
METHOD: Final = (
    Edit("fivtui/transient/midpoint.py", "", MIDPOINT),
    Edit(
        "fivtui/transient/methods.py",
        r"from \.request",
        "from .midpoint import midpoint_stepper\n\\g<0>",
    ),
    Edit(
        "fivtui/transient/methods.py",
        r' +Method\("rk4", .*\n',
        r'\g<0>        Method("midpoint", "explicit midpoint rule", True, midpoint_stepper),\n',
    ),
    # Coarsest and finest step in units of √(m/stiffness), and the ratio of consecutive steps.
    Edit(
        "fivtui/tradeoffs/settings.py",
        r'    \("rk4", .*\n',
        r'\g<0>    ("midpoint", 0.1, 0.1 / 2.0**9, 0.5),\n',
    ),
    # Share of the CPU time of a trade-off.
    Edit("fivtui/tradeoffs/measure.py", r'    "rk4": 0.25,\n', r'\g<0>    "midpoint": 0.05,\n'),
    Edit(
        "fivtui/assessment/stress_tests.py",
        r'    "rk4": MethodUnderTest.*\n',
        r'\g<0>    "midpoint": MethodUnderTest("midpoint", max_steps=20_000),\n',
    ),
)
CHECK_METHOD: Final = """
from fivtui import *
from fivtui.assessment.stress_tests import METHODS_UNDER_TEST
from fivtui.cli import run
from fivtui.tradeoffs.measure import _SHARES
from fivtui.tradeoffs.settings import ladders
from fivtui.tui.session.fields import FIELDS

truth = simulate(t_end=4.0).final.y
errors = [
    abs(simulate(t_end=4.0, method="midpoint", step=step).final.y - truth) for step in (4e-3, 2e-3)
]
# Of second order.
assert 3.0 < errors[0] / errors[1] < 5.0 and errors[1] < 1e-3, errors
assert run(["methods"]) == 0
assert run(["simulate", "--method", "midpoint", "--t-end", "1"]) == 0
scene = Scene(name="mine", description="", parameters=Parameters(), method="midpoint")
save_scene(scene, "midpoint.toml")
assert load_scene("midpoint.toml") == scene
assert "midpoint" in FIELDS["method"].choices
# A ladder is the sequence of steps or tolerances of a method, from coarse to fine.
tried = {ladder.method for ladder in ladders(time_scale=0.1, t_end=10.0)}
assert "midpoint" in tried and tried == set(_SHARES)
assert "midpoint" in {entry.name for entry in METHODS_UNDER_TEST.values()}
"""

# A tab that shows the preload in words.
WORDS_TAB: Final = '''"""The words tab."""

from textual.app import ComposeResult
from textual.widgets import Static

from .pane import Pane


class WordsPane(Pane):
    """The preload in words."""

    def compose(self) -> ComposeResult:
        """The words."""
        yield Static("", id="words")

    def scene_changed(self) -> None:
        """Say the preload."""
        self.query_one("#words", Static).update(f"a preload of {self.session.texts['F']} newtons")
'''
# The tab of a study: stability of the edited scene at a given friction coefficient. Enter opens the
# point at the cursor of its chart: the form gets the values that `read_point` returns.
STUDY_TAB: Final = '''"""The tab of the stability at a friction coefficient."""

import numpy as np
from textual.containers import Vertical

from fivtui.charts import Chart, Trace
from fivtui.equilibrium import stability
from fivtui.tui.chart import ChartView

from .study_pane import ResultInputs, StudyPane


class FrictionPane(StudyPane):
    """Eigenvalues at a friction coefficient."""

    NAME, VERB, EXAMPLE = "stability", "Solve", "0.3"
    INPUT_FORMAT = "a number"
    VIEWS = {"roots": "Roots"}

    def compose_views(self):
        """One chart."""
        with Vertical(id="roots"):
            yield ChartView("roots-chart", empty_text="not solved yet", runs_points=True)

    def parse(self, scene, text):
        """The scene with the friction coefficient."""
        return scene.with_values({"mu": text})

    def compute(self, request, job):
        """The stability of a scene."""
        return stability(request.parameters, separation=request.separation)

    def inputs_of(self, result):
        """The parameters, except friction."""
        return ResultInputs(result.parameters, ["mu"], {"separation": result.separation})

    def answer_text(self, result):
        """The growth rate."""
        return f"grows by {result.growth_rate:.3g} 1/s"

    def draw_result(self, result):
        """Draw the eigenvalues."""
        roots = result.eigenvalues
        chart = Chart("Re", "Im", (Trace("roots", roots.real, roots.imag, look="points"),))
        self.query_one(ChartView).show(chart)

    def read_point(self, result, point):
        """Values for the form and their description: every point has the same friction."""
        return {"mu": self.text}, "the friction coefficient"
'''
TAB: Final = (
    Edit("fivtui/tui/tabs/words.py", "", WORDS_TAB),
    Edit("fivtui/tui/tabs/studies/friction.py", "", STUDY_TAB),
    Edit(
        "fivtui/tui/tabs/tab_book.py",
        r' +TabSpec\("log".*\n',
        r'    TabSpec("words", "Words", "", "f12", "words:WordsPane"),\n'
        r'    TabSpec("friction", "Friction", "", "f11", "studies.friction:FrictionPane"),\n'
        r"\g<0>",
    ),
)
# The laboratory, lab in names, is the terminal interface.
CHECK_TAB: Final = """
import asyncio
from fivtui.tui.app import FivtuiApp
from tests.support.laboratory import app_of, lab_of, show_tab, until, until_shown, type_into

async def check_tab():
    async with FivtuiApp().run_test(size=(100, 30)) as pilot:
        await pilot.pause()
        await pilot.press("f12")
        await until_shown(pilot, "a preload of 80 newtons")
        await type_into(pilot, "F", "60")
        await until_shown(pilot, "a preload of 60 newtons")
        await show_tab(pilot, "f11")
        await until_shown(pilot, "not solved yet")
        await pilot.press("f10")
        await until_shown(pilot, "grows by -0.0")
        command = lab_of(pilot).tab_book.pane.command_line()
        assert command == "fivtui stability --set F=60 --set mu=0.3"
        await pilot.press("f7")
        await until_shown(pilot, "Export the data of the stability")
        # Close the dialog, focus the chart, show its cursor and open the point there.
        await pilot.press("escape", "alt+p", "c", "enter")
        await until(pilot, lambda: app_of(pilot).session.texts["mu"] == "0.3")
        await pilot.press("ctrl+p")
        await until_shown(pilot, "Search for commands")

asyncio.run(check_tab())
"""

# A file format: one JSON line per row, after a header line.
JSONL: Final = '''"""Tables as lines of JSON: the header, the names with their units, the rows."""

import json

import numpy as np

from fivtui.model import InputError

# The format needs no package, so that no extra of fivtui has to install one.
package = extra = ""


def write(file, columns, values, header):
    """Write a table of numbers, its header and the units of its columns."""
    names = {column.name: column.unit for column in columns}
    rows = zip(*(values[name].tolist() for name in names), strict=True)
    file.write("".join(json.dumps(line) + "\\n" for line in (dict(header), names, *rows)).encode())


def read(file, selected=None, texts=(), *, missing=False):
    """Read columns, see `tables.Format`."""
    try:
        _, names, *rows = map(json.loads, file.read().decode().splitlines())
    except ValueError:
        raise InputError("not lines of JSON") from None
    columns = dict(zip(names, zip(*rows, strict=True), strict=True))
    return {
        name: np.array(columns[name], dtype=object if name in texts else float)
        for name in (columns if selected is None else selected)
        if name in columns
    }


def header(file):
    """Read the header alone."""
    try:
        return json.loads(file.readline())
    except ValueError:
        raise InputError("not lines of JSON") from None
'''
# A sweep is written in pieces, rows without a header, which are merged below two lines: provenance
# and units. `re.subn`, which inserts this text, makes one backslash of two.
JSONL_OF_SWEEPS: Final = r"""
def _write_lines(file, study, rows) -> None:
    cells = (rows.values(column) for column in study.columns)
    file.write("".join(json.dumps(row) + "\\n" for row in zip(*cells, strict=True)).encode())


def _merge_lines(file, study, pieces, provenance) -> None:
    units = {column.name: column.unit for column in study.columns}
    file.write((json.dumps(dict(provenance)) + "\\n" + json.dumps(units) + "\\n").encode())
    for piece in pieces:
        file.write(piece.read_bytes())


def _count_lines(path, study) -> int:
    return path.read_bytes().count(b"\\n") - 2


_LINES: Final = _write_lines, _merge_lines, _count_lines
SWEEP_FORMATS"""
FORMAT: Final = (
    Edit("fivtui/io/lines_format.py", "", JSONL),
    Edit("fivtui/io/tables.py", r"from \. import csv_format", r"\g<0>, lines_format"),
    Edit(
        "fivtui/io/tables.py",
        r'    "\.npz": npz_format,\n',
        r'\g<0>    ".jsonl": lines_format,\n',
    ),
    Edit("fivtui/sweeps/formats.py", r"import shutil\n", r"import json\n\g<0>"),
    Edit("fivtui/sweeps/formats.py", r"\nSWEEP_FORMATS", JSONL_OF_SWEEPS),
    Edit(
        "fivtui/sweeps/formats.py",
        r'    "\.csv": SweepFormat.*\n',
        r'\g<0>    ".jsonl": SweepFormat(FORMATS[".jsonl"], *_LINES),\n',
    ),
    Edit("fivtui/sweeps/kinds.py", r'\(".csv", ".parquet"', '(".csv", ".jsonl", ".parquet"'),
)
CHECK_FORMAT: Final = """
from pathlib import Path
from fivtui import *
from fivtui.cli import run
from fivtui.studies import STUDIES, kind_of, load_study, study

tables = {name for name in STUDIES if ".npz" in study(name).suffixes}
assert len(tables) >= 6
assert {name for name in STUDIES if ".jsonl" in study(name).suffixes} == {*tables, "sweep"}
for command, kind in (
    (["simulate", "--t-end=1", "--points=11"], "run"),
    (["map", "--over=F=10:20:3", "--over=mu=0.1:0.7:2"], "map"),
    (["sweep", "--vary=F=10:20:3", "--t-end=1", "--piece=2"], "sweep"),
):
    paths = [Path(f"{kind}{suffix}") for suffix in (".csv", ".jsonl")]
    for path in paths:
        assert run([*command, f"--out={path}"]) == 0
        assert kind_of(path) == kind
    first, second = (load_study(kind, path) for path in paths)
    assert repr(first) == repr(second)
# An existing file is read before it is replaced or continued; this one is not a sweep.
Path("bad.jsonl").write_text("{")
assert run(["sweep", "--vary=F=10:20:3", "--out=bad.jsonl"]) == 2
"""


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    root = tmp_path / "tree"
    for package in ("fivtui", "fmu_src"):
        # Include compiled files: they stay valid for all files that are not edited.
        shutil.copytree(ROOT / package, root / package)
    return root


def run_with_tree(root: Path, code: str) -> str:
    """Output of a program that imports the packages of a tree."""
    return run_python(
        "-c", code, cwd=root, environment={"PYTHONPATH": str(root), "PYTHONDONTWRITEBYTECODE": "1"}
    )


def test_a_parameter_can_be_added(tree: Path) -> None:
    apply_edits("A parameter", PARAMETER, tree)
    # Only the Python flavour: compiled files do not have the edit.
    run_with_tree(tree, f"FLAVOURS = ['python']\n{CHECK_PARAMETER}")


# `host`: the test needs a compiler on this machine.
@pytest.mark.slow
@pytest.mark.whole
@pytest.mark.host
@pytest.mark.parametrize(
    ("subject", "edits", "code"),
    [
        ("A parameter", PARAMETER, CHECK_PARAMETER),
        ("A friction law", LAW, CHECK_LAW),
        ("A mode", MODE, CHECK_MODE),
    ],
)
def test_additions_also_work_in_the_compiled_kernel(
    subject: str, edits: Sequence[Edit], code: str, tree: Path
) -> None:
    if find_spec("ziglang") is None and shutil.which("cc") is None:
        pytest.skip("there is no compiler")
    apply_edits(subject, edits, tree)
    shutil.copy(ROOT / "hatch_build.py", tree)
    run_with_tree(tree, "import runpy; runpy.run_path('hatch_build.py', run_name='__main__')")
    compiled = "from fivtui.kernel import stepping_kernel; assert stepping_kernel() == 'compiled'"
    run_with_tree(tree, f"{compiled}\nFLAVOURS = ['python', 'native']\n{code}")


def test_a_friction_law_can_be_added(tree: Path) -> None:
    apply_edits("A friction law", LAW, tree)
    run_with_tree(tree, f"FLAVOURS = ['python']\n{CHECK_LAW}")


# Check every file of the kernel without generating machine code, for one instruction set. An
# undeclared function is an error for all compilers. zig does not have the option -fsyntax-only.
CHECK_FILES: Final = """
import subprocess
from pathlib import Path
from hatch_build import FOLDER, _compilers, _kernel_plan

root, scratch = Path.cwd(), Path("scratch")
scratch.mkdir()
for compiler in _compilers(root):
    check = ["-fsyntax-only"]
    if compiler.is_zig:
        llvm = ["-emit-llvm", "-Xclang", "-disable-llvm-passes"]
        check = ["-c", *llvm, "-o", str(scratch / "unit")]
    for unit, options in _kernel_plan(root / FOLDER, scratch, compiler, scratch).objects.items():
        if unit.endswith(("loading", "_baseline")):
            strict = "-Werror=implicit-function-declaration"
            subprocess.run([*compiler.command, *options, strict, *check], check=True)
            print(compiler.name, unit)
"""


def test_every_file_of_the_kernel_compiles_with_another_friction_law(tree: Path) -> None:
    apply_edits("A friction law", LAW, tree)
    shutil.copy(ROOT / "hatch_build.py", tree)
    checked = run_with_tree(tree, CHECK_FILES)
    if not checked:
        pytest.skip("there is no compiler")
    if find_spec("ziglang") is not None:
        assert "ziglang belt_lanes_baseline" in checked


def test_a_mode_can_be_added(tree: Path) -> None:
    apply_edits("A mode", MODE, tree)
    run_with_tree(tree, CHECK_MODE)


def test_a_method_can_be_added(tree: Path) -> None:
    apply_edits("A method", METHOD, tree)
    # `fivtui methods` in the check prints all methods.
    assert "midpoint" in run_with_tree(tree, CHECK_METHOD)


def test_a_tab_can_be_added(tree: Path) -> None:
    apply_edits("A tab", TAB, tree)
    (tree / "tests").symlink_to(ROOT / "tests")
    run_with_tree(tree, CHECK_TAB)


def test_a_file_format_can_be_added(tree: Path) -> None:
    apply_edits("A file format", FORMAT, tree)
    run_with_tree(tree, CHECK_FORMAT)
