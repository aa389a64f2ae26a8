"""Every example is short and runs from anywhere."""

import re
import runpy
from importlib.util import find_spec
from pathlib import Path
from typing import Literal

import pytest
from hypothesis import given, strategies as st

from fivtui import simulate, stability
from fivtui.model import Mode, Parameters, State, accelerations
from fivtui.model.modes import ALWAYS_SLIDING
from tests.support.processes import run_python
from tests.support.strategies import magnitudes, moderate_parameters, states

ROOT = Path(__file__).parents[1]
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))
# Command-line arguments of examples. `extremes` takes names of stress tests: three are enough here,
# as `pytest -m whole` in tests/assessment runs all. The switch is y = 0, where contact is lost.
ARGUMENTS = {"extremes": ["lifted", "start-on-switch", "tol-too-small"]}
# Replaced text of an example, rate, N/s, and end, s, of a ramp: the same preloads in a fifth of the
# time.
SHORTENED = {"fmu_ramp": ("0.25, 200.0", "1.25, 40.0")}
RUN_ALL = """
import runpy, sys
for line in sys.stdin.read().splitlines():
    sys.argv = line.split()
    print("\f" + sys.argv[0], flush=True)
    runpy.run_path(sys.argv[0], run_name="__main__")
"""


def test_examples_are_short_and_run_from_any_folder(tmp_path: Path) -> None:
    folder, lines = tmp_path / "empty", []
    folder.mkdir()
    for example in EXAMPLES:
        text = example.read_text(encoding="utf-8")
        assert len(text.splitlines()) < 50, example
        optional = re.search(r"^from (libcosimpy)\b", text, flags=re.MULTILINE)
        if optional and find_spec(optional[1]) is None:
            continue
        path = example
        if example.stem in SHORTENED:
            long, short = SHORTENED[example.stem]
            assert long in text
            path = tmp_path / example.name
            path.write_text(text.replace(long, short), encoding="utf-8")
        lines.append(" ".join([str(path), *ARGUMENTS.get(example.stem, [])]))
    out = run_python("-c", RUN_ALL, cwd=folder, stdin="\n".join(lines))
    _, *printed = out.split("\f")
    assert len(printed) == len(lines)
    # Separation is part of the results that every example prints.
    assert not [text for text in printed if "separation" not in text]
    assert list(folder.iterdir()) == []


def test_there_is_a_native_and_an_fmu_example() -> None:
    assert {"native_run", "fmu_run"} <= {example.stem for example in EXAMPLES}


@given(
    p=moderate_parameters(),
    state=states(),
    # Factors of mass, length and time, from 10^-1 to 10^1.
    factors=st.tuples(*[magnitudes(-1.0, 1.0)] * 3),
    # The modes on a belt that is always faster than the slider: contact and separation.
    mode=st.sampled_from(ALWAYS_SLIDING),
)
def test_scaled_parameters_have_the_same_motion_in_other_units(
    p: Parameters, state: State, factors: tuple[float, float, float], mode: Mode
) -> None:
    mass, length, time = factors
    scaled = runpy.run_path(str(ROOT / "examples" / "brake_scale.py"))["scaled"]
    x, vx, y, vy = state
    scaled_state = (x * length, vx * length / time, y * length, vy * length / time)
    actual = accelerations(scaled(p, mass, length, time), scaled_state, mode)
    expected = accelerations(p, state, mode)
    # Size of the terms of an acceleration at displacements of about 1 m, for rounding errors.
    largest = max(map(abs, (*expected, p.F / p.m, p.k1 / p.m, p.k_nl / p.m)))
    for actual_value, expected_value in zip(actual, expected, strict=True):
        assert actual_value * time**2 / length == pytest.approx(
            expected_value, rel=1e-12, abs=1e-13 * largest
        )


@pytest.mark.parametrize("length", [1e-6, 2e-8])
# Both kernels of the Taylor method, and RK4.
@pytest.mark.parametrize("integrator", ["compiled", "interpreted", "rk4"])
def test_a_motion_of_micrometres_is_as_accurate_as_one_of_metres(
    length: float, integrator: Literal["compiled", "interpreted", "rk4"]
) -> None:
    scaled = runpy.run_path(str(ROOT / "examples" / "brake_scale.py"))["scaled"]
    base, time = Parameters(), 5e-4
    pad = scaled(base, 0.1, length, time)
    if integrator == "rk4":
        base_run = simulate(base, t_end=5.0, method="rk4", step=2e-3)
        pad_run = simulate(pad, t_end=5.0 * time, method="rk4", step=2e-3 * time)
    else:
        base_run = simulate(base, t_end=20.0, kernel=integrator)
        pad_run = simulate(pad, t_end=20.0 * time, kernel=integrator)
    assert pad_run.events.separations == base_run.events.separations > 1
    assert pad_run.final.y / length == pytest.approx(base_run.final.y, rel=1e-9)
    assert pad_run.peak.y_abs / length == pytest.approx(base_run.peak.y_abs, rel=1e-12)
    growth = stability(pad).growth_rate * time
    assert growth == pytest.approx(stability(base).growth_rate, rel=1e-12)


def test_the_pad_moves_like_the_base_set_in_other_units(capsys: pytest.CaptureFixture[str]) -> None:
    runpy.run_path(str(ROOT / "examples" / "brake_scale.py"), run_name="__main__")
    setting, *runs = capsys.readouterr().out.splitlines()
    assert "--set m=0.5 " in setting
    assert "--set F=1e+04 " in setting
    # Peak of |y|, m, dimensionless peak and number of separations, and least belt speed, m/s.
    line = re.compile(r"peak \|y\| (\S+) m, (.+ separations), belt above (\S+) m/s")
    (_, base_motion, _), (peak, pad_motion, speed) = (line.findall(run)[0] for run in runs)
    assert pad_motion == base_motion
    page = (ROOT / "docs" / "how-to" / "own-scenes.md").read_text(encoding="utf-8")
    k1 = float(re.search(r"k1=(\S+)", setting)[1])  # type: ignore[index]
    assert f"{k1 / 1e6:.0f} kN/mm" in page
    assert f"{1e3 * float(peak):.1f} mm" in page
    assert f"{float(speed):.0f} m/s" in page
