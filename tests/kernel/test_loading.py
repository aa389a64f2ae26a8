"""The compiled kernel is available from the first run on, or the program gives the reason.

In the context INTERPRETED the library seems to be missing.
"""

import math
import os
import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import fivtui
import hatch_build
from fivtui import Parameters, simulate, simulate_batch
from fivtui.cli import options, run
from fivtui.kernel import Kernel, native, runs, why_interpreted
from fivtui.model import ComputationError
from tests.support.kernels import INTERPRETED, NO_COMPILER

PACKAGE = Path(fivtui.__file__).parent
KERNEL = PACKAGE / "kernel"


@pytest.fixture
def without_cache(monkeypatch: pytest.MonkeyPatch) -> None:
    """Load the kernel without the cache during the test."""
    monkeypatch.setattr(native, "_load_or_error", native._load_or_error.__wrapped__)


def test_the_first_run_of_a_process_is_compiled() -> None:
    process = subprocess.run(
        [sys.executable, "-c", "import fivtui; print(fivtui.simulate(t_end=1.0).stats.kernel)"],
        env={**os.environ, "PYTHONPATH": str(PACKAGE.parent)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert (process.stdout, process.stderr) == ("compiled\n", "")


def test_pauses_for_progress_and_full_buffers_change_no_bit() -> None:
    uninterrupted, paused = (
        simulate(t_end=400.0, samples=999, progress=progress)
        for progress in (None, lambda _fraction: True)
    )
    assert uninterrupted.final == paused.final
    assert uninterrupted.peak == paused.peak
    assert uninterrupted.events == paused.events
    # The kernel fills its buffer of switches several times.
    assert uninterrupted.events.separations > runs._SWITCHES
    assert uninterrupted.trajectory is not None
    assert paused.trajectory is not None
    columns = paused.trajectory.to_columns()
    for name, values in uninterrupted.trajectory.to_columns().items():
        assert (values == columns[name]).all(), name


def test_the_choice_of_samples_changes_no_bit() -> None:
    without, dense, few = (
        simulate(t_end=300.0, samples=samples) for samples in ("none", "dense", 7)
    )
    assert without.final == dense.final == few.final
    assert without.peak == dense.peak == few.peak
    solution, sampled = dense.solution, few.trajectory
    assert solution is not None
    assert sampled is not None
    states = solution(sampled.t)
    assert states.y == pytest.approx(sampled.y, rel=1e-12, abs=1e-12)
    assert states.vx == pytest.approx(sampled.vx, rel=1e-11, abs=1e-11)


@pytest.mark.usefixtures("without_cache")
def test_without_a_library_the_reason_is_reported_and_runs_are_interpreted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    reason = tmp_path / "reason.txt"
    monkeypatch.setattr(native, "_LIBRARY", tmp_path / "none.so")
    monkeypatch.setattr(native, "_REASON", reason)
    assert why_interpreted() == "the kernel is not compiled: not installed"
    reason.write_text("there is no compiler\n", encoding="utf-8")
    assert why_interpreted() == "the kernel is not compiled: there is no compiler"
    assert simulate(t_end=1.0).stats.kernel == "interpreted"
    with pytest.raises(ComputationError, match=r"there is no compiler; install fivtui anew"):
        simulate(t_end=1.0, kernel="compiled")


@pytest.mark.usefixtures("without_cache")
def test_a_library_compiled_from_other_sources_is_not_loaded(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for path in (*KERNEL.glob("*.c"), *KERNEL.glob("*.h")):
        shutil.copy(path, tmp_path)
    monkeypatch.setattr(native, "_FOLDER", tmp_path)
    assert why_interpreted() is None
    with (tmp_path / "search.h").open("a") as file:
        file.write("\n")
    assert why_interpreted() == "the compiled kernel does not match its sources"


def test_a_file_that_is_no_library_is_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    broken = tmp_path / "broken.so"
    broken.write_text("nothing")
    monkeypatch.setattr(native, "_LIBRARY", broken)
    with pytest.raises(ComputationError, match="cannot be loaded"):
        Kernel()


def test_an_instruction_set_that_the_processor_lacks_is_refused() -> None:
    with pytest.raises(ComputationError, match="'vliw': this processor has baseline"):
        Kernel("vliw")


def test_the_command_line_reports_once_why_runs_are_interpreted(
    capsys: pytest.CaptureFixture[str],
) -> None:
    options._warn_if_interpreted.cache_clear()
    with INTERPRETED:
        assert run(["simulate", "--t-end", "1"]) == 0
        assert run(["simulate", "--t-end", "1"]) == 0
    options._warn_if_interpreted.cache_clear()
    assert capsys.readouterr().err.count(NO_COMPILER) == 1


# So short a run does not move: its final state is the static start, the equilibrium for μ = 0.
NO_TIME = 1e-300


def test_static_starts_of_batches_equal_those_of_single_runs() -> None:
    rng = np.random.default_rng(5)
    forces = rng.uniform(-60.0, 300.0, 300)
    cubic_stiffnesses = 10.0 ** rng.uniform(-3.0, 9.0, 300)
    batch = simulate_batch(
        {"F": forces, "k_nl": cubic_stiffnesses}, t_end=NO_TIME, require={"final"}
    )
    for row in range(300):
        p = Parameters(F=forces[row], k_nl=cubic_stiffnesses[row])
        final = simulate(p, t_end=NO_TIME).final
        assert batch.final[row].tolist() == [final.x, final.vx, final.y, final.vy]


def read_table(table: str) -> np.ndarray:
    # The numbers of a C table, up to the commas, spaces or braces that separate them.
    text = (KERNEL / "tables.h").read_text(encoding="utf-8")
    match = re.search(rf"double {table}(?:\[[^=]*)? = (.*?);", text, re.DOTALL)
    assert match is not None
    return np.array([float(number) for number in re.findall(r"-?\d[^,\s}]*", match[1])])


def test_the_tabulated_bounds_hold_and_are_tight() -> None:
    # The search for roots replaces θⁿ by the cubic with its values and slopes at 0 and 1. Tables
    # begin at n = 2. CUBIC_BOUND bounds the difference, CUBIC_SLOPE_BOUND its slope; DIVIDED_BOUND
    # times CUBIC_BOUND bounds the difference divided by θ.
    theta = np.linspace(0.0, 1.0, 20_001)[1:]
    cubic, slope = read_table("CUBIC_BOUND"), read_table("CUBIC_SLOPE_BOUND")
    # The distance of the second derivative n (n − 1) θⁿ⁻² from its mean n is greatest at θ = 1.
    assert (read_table("CURVATURE_BOUND") == [n * (n - 2.0) for n in range(2, 26)]).all()
    divided_ratios = []
    for n in range(4, 26):
        # The cubic is θ² (3 − 2 θ + n (θ − 1)).
        residual = theta**n - theta**2 * ((3.0 - 2.0 * theta) + n * (theta - 1.0))
        residual_slope = (
            n * theta ** (n - 1) - 6.0 * theta * (1.0 - theta) - n * theta * (3.0 * theta - 2.0)
        )
        for bound, deviation in ((cubic, residual), (slope, residual_slope)):
            assert 0.999 * bound[n - 2] < np.abs(deviation).max() <= bound[n - 2]
        divided_ratios.append(np.abs(residual / theta).max() / cubic[n - 2])
    (divided_bound,) = read_table("DIVIDED_BOUND")
    assert 0.999 * divided_bound < max(divided_ratios) <= divided_bound


# Greatest degree of the polynomials: 21 for constant friction, 25 with a friction law.
@pytest.mark.parametrize(
    ("name", "degree", "padded_size"), [("TO_BERNSTEIN", 21, 24), ("TO_BERNSTEIN_WITH_LAW", 25, 32)]
)
def test_the_bernstein_tables_hold_ratios_of_binomials(
    name: str, degree: int, padded_size: int
) -> None:
    rows = degree + 1
    table = read_table(name).reshape(rows, padded_size)
    for n in range(rows):
        expected = [math.comb(i, n) / math.comb(degree, n) for i in range(rows)]
        assert table[n].tolist() == [*expected, *[0.0] * (padded_size - rows)]


@pytest.fixture
def earlier_libraries(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[Path]:
    """Libraries in a tree of sources in which compilation is replaced by the tests."""
    libraries = [
        tmp_path / hatch_build.FOLDER / hatch_build.LIBRARY,
        *(
            tmp_path / hatch_build.FMU_FOLDER / f"{model}{hatch_build.LIBRARY_SUFFIX}"
            for model in hatch_build.FMU_MODELS
        ),
    ]
    for library in libraries:
        library.parent.mkdir(parents=True, exist_ok=True)
        library.write_text("compiled earlier")
    monkeypatch.setattr(hatch_build, "ROOT", tmp_path)
    return libraries


def fail_to_compile(*_: object) -> None:
    raise hatch_build.CompilerError("a broken compiler")


def test_libraries_stay_if_they_cannot_be_compiled_in_place(
    earlier_libraries: list[Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(hatch_build, "compile_all", fail_to_compile)
    with pytest.raises(SystemExit, match="the kernel is not compiled: a broken compiler"):
        hatch_build.compile_in_place()
    assert {library.read_text() for library in earlier_libraries} == {"compiled earlier"}


@pytest.mark.parametrize("why", [None, "no headers"])
def test_reasons_are_removed_where_libraries_are_compiled_in_place(
    why: str | None, earlier_libraries: list[Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    kernel_reason = earlier_libraries[0].with_name(hatch_build.REASON)
    fmu_reason = earlier_libraries[1].with_name(hatch_build.FMU_REASON)
    for reason in (kernel_reason, fmu_reason):
        reason.write_text("an earlier failure")
    compiler = hatch_build._Compiler("cc", ["cc"], hatch_build.LIBRARY_SUFFIX, is_x86=True)
    monkeypatch.setattr(hatch_build, "compile_all", lambda *_: (compiler, why))
    hatch_build.compile_in_place()
    assert not kernel_reason.exists()
    assert (fmu_reason.read_text() if fmu_reason.exists() else None) == (why and f"{why}\n")
    assert all(library.exists() for library in earlier_libraries)


def test_a_failed_installation_leaves_the_reason_in_place_of_libraries(
    earlier_libraries: list[Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    app: Any = SimpleNamespace(display_warning=str)
    metadata: Any = None
    hook = hatch_build.KernelBuildHook(
        str(tmp_path), {}, None, metadata, str(tmp_path), "wheel", app
    )
    errors: list[BaseException] = [
        KeyboardInterrupt(),
        hatch_build.CompilerError("a broken compiler"),
    ]

    def fail_after_check(*_: object) -> None:
        # Nothing is removed before compilation has failed, nor if it is interrupted.
        assert all(library.exists() for library in earlier_libraries)
        raise errors.pop(0)

    monkeypatch.setattr(hatch_build, "compile_all", fail_after_check)
    with pytest.raises(KeyboardInterrupt):
        hook.initialize("editable", {})
    hook.initialize("editable", {})
    assert not any(library.exists() for library in earlier_libraries)
    kernel, *fmus = earlier_libraries
    for reason in (kernel.with_name(hatch_build.REASON), fmus[0].with_name(hatch_build.FMU_REASON)):
        assert reason.read_text() == "a broken compiler\n"


# A slow test. With a library it needs a compiler of this machine; only `pytest -m whole` runs it.
@pytest.mark.slow
@pytest.mark.host
@pytest.mark.parametrize("is_compiled", [pytest.param(True, marks=pytest.mark.whole), False])
def test_a_wheel_contains_the_library_or_the_reason_why_it_is_missing(
    is_compiled: bool, tmp_path: Path
) -> None:
    source = tmp_path / "source"
    ignored = shutil.ignore_patterns(".venv", ".git", "*.so", "__pycache__", ".*_cache")
    shutil.copytree(PACKAGE.parent, source, ignore=ignored)
    if is_compiled and not hatch_build._compilers(hatch_build.ROOT):
        pytest.skip("there is no compiler")
    if not is_compiled:
        (source / "fivtui" / "kernel" / "motion.h").write_text("#error broken\n")
    subprocess.run(
        [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(tmp_path)],
        cwd=source,
        check=True,
        capture_output=True,
    )
    (wheel,) = tmp_path.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        names = {name.rpartition("/")[2] for name in archive.namelist()}
        assert (native._LIBRARY.name in names) == is_compiled
        assert (native._REASON.name in names) != is_compiled
        assert (f"SliderBelt{hatch_build.LIBRARY_SUFFIX}" in names) == is_compiled
        assert (hatch_build.FMU_REASON in names) != is_compiled
        if not is_compiled:
            assert b"broken" in archive.read("fivtui/kernel/libfivtui.txt")
    # The name ends with the platform: a library is for one platform, Python code alone for `any`.
    tag = r"-py3-none-(?!any)" if is_compiled else r"-(py2\.)?py3-none-any"
    assert re.search(tag, wheel.name)
    assert not list(source.rglob("libfivtui*"))
    assert not list(source.rglob(f"SliderBelt{hatch_build.LIBRARY_SUFFIX}"))
