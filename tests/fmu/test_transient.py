"""Transients by the FMU equal direct transients and leave no files behind.

A direct transient is computed by this package without an FMU. Python FMUs (the method "fmu")
contain its interpreted kernel, native FMUs ("fmu-native") its compiled one. `interpreted` is
`simulate` with the interpreted kernel.
"""

import os
import signal
import sys
import tempfile
import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings

from fivtui import Parameters, simulate
from fivtui.fmu import master
from fivtui.fmu.instance import defer_interrupts
from fivtui.fmu.run import run_fmu
from fivtui.fmu.transient import integrate_fmu
from fivtui.model import System
from fivtui.model.errors import Cancelled, ComputationError, InputError
from fivtui.transient.request import KernelChoice, Request
from fivtui.transient.result import Transient
from tests.support.fmu_tools import build_accumulator, modified_copy, simulate_interpreted
from tests.support.strategies import moderate_parameters

# With these parameters and separation ignored, vibration grows until numbers overflow.
UNBOUNDED = Parameters(k2=186.0, k_nl=0.0, mu=100.0)
# The float below the time of the first switch of the default run, s.
JUST_BEFORE_A_SWITCH = 2.860607592369662


def assert_same(fmu_run: Transient, direct: Transient, rel: float = 1e-9) -> None:
    assert fmu_run.final == direct.final
    assert np.array_equal(fmu_run.switch_times, direct.switch_times)
    assert fmu_run.first_mode is direct.first_mode
    assert fmu_run.events.separations == direct.events.separations
    assert fmu_run.events.separated_time == pytest.approx(direct.events.separated_time)
    for name in ("y_abs", "y_max", "y_min", "x_abs", "vx_max"):
        peak = getattr(direct.peak, name)
        assert getattr(fmu_run.peak, name) == pytest.approx(peak, rel=rel, abs=rel)
    half_range = direct.steady.y_half_range
    assert fmu_run.steady.y_half_range == pytest.approx(half_range, rel=rel, abs=rel)
    assert fmu_run.contact_force.max == pytest.approx(direct.contact_force.max, rel=rel, abs=rel)


@pytest.mark.parametrize("separation", [True, False])
@pytest.mark.parametrize(
    ("step", "t_end"),
    [
        # All runs include the first switches, at 2.9 s and 3.3 s. Runs with long steps may last
        # 20 s, because such steps are cheap. The step None is the default.
        *((None, 5.0), (0.003, 5.0), (0.1, 5.0), (1.0, 20.0), (20.0, 20.0)),
        # Runs of 100 s are computed only by `pytest -m whole`.
        *(pytest.param(step, 100.0, marks=pytest.mark.whole) for step in (None, 0.001, 0.01, 0.1)),
    ],
)
@pytest.mark.parametrize(("method", "kernel"), [("fmu", "interpreted"), ("fmu-native", "compiled")])
def test_any_communication_step_gives_the_direct_result(
    method: str, kernel: KernelChoice, step: float | None, t_end: float, separation: bool
) -> None:
    fmu_run = simulate(separation=separation, t_end=t_end, method=method, step=step)
    assert_same(fmu_run, simulate(separation=separation, t_end=t_end, kernel=kernel))
    assert fmu_run.method == method
    assert fmu_run.stats.steps > 0


@settings(max_examples=6, deadline=None)
@given(moderate_parameters())
def test_other_parameters_give_the_direct_result(p: Parameters) -> None:
    assert_same(
        simulate(p, t_end=10.0, method="fmu"), simulate_interpreted(p, t_end=10.0), rel=1e-8
    )


def test_several_switches_within_a_communication_step_are_counted() -> None:
    # A stiff contact: the shortest time between two switches is below 7 ms.
    p = Parameters(F=60.0, k_nl=1e8, mu=0.5)
    options: dict[str, Any] = {"t_end": 10.0, "start": (0.0, 0.0, 2.0, 0.0)}
    direct = simulate_interpreted(p, **options)
    assert direct.events.separations == 8
    assert np.diff(direct.switch_times).min() < 0.007
    for step in (0.008, 0.01, 5.0):
        fmu_run = simulate(p, method="fmu", step=step, **options)
        assert_same(fmu_run, direct, rel=1e-8)


def test_samples_are_the_outputs_at_the_requested_times(fmu: Path) -> None:
    times = [0.0, 0.1, 0.1, 1.0 / 3.0, JUST_BEFORE_A_SWITCH, 4.0, 10.0]
    fmu_run = integrate_fmu(
        Request(System(Parameters()), t_end=10.0, method="fmu", samples=times), fmu=fmu
    )
    direct = simulate_interpreted(t_end=10.0, samples=times)
    assert fmu_run.trajectory is not None
    assert direct.trajectory is not None
    assert fmu_run.trajectory.t.tolist() == times
    for name in ("x", "vx", "y", "vy", "P", "mode"):
        actual, expected = getattr(fmu_run.trajectory, name), getattr(direct.trajectory, name)
        assert actual.dtype == expected.dtype
        assert actual == pytest.approx(expected, rel=1e-12, abs=1e-12)
    # Samples have the bits of a run that ends at their time. At the first time, 0, no run can end.
    for t, y in zip(times[1:], fmu_run.trajectory.y[1:], strict=True):
        assert simulate_interpreted(t_end=t).final.y == y
    assert_same(fmu_run, direct)


def test_a_dense_solution_agrees_with_the_direct_solution() -> None:
    fmu_run = simulate(t_end=10.0, method="fmu", samples="dense")
    direct = simulate_interpreted(t_end=10.0, samples="dense")
    assert fmu_run.solution is not None
    assert direct.solution is not None
    times = np.linspace(0.0, 10.0, 997)
    assert fmu_run.solution(times).y == pytest.approx(direct.solution(times).y, abs=1e-8)


@pytest.mark.parametrize("samples", [[1.0, 0.5], [-1.0], [11.0], []])
def test_invalid_times_of_samples_are_refused(samples: list[float]) -> None:
    with pytest.raises(InputError, match="samples"):
        simulate(t_end=10.0, method="fmu", samples=samples)


def test_progress_rises_to_one_and_can_cancel(fmu: Path) -> None:
    fractions: list[float] = []

    def store_fraction(fraction: float) -> bool:
        fractions.append(fraction)
        return True

    request = Request(System(Parameters()), t_end=30.0, method="fmu")
    integrate_fmu(request, fmu=fmu, progress=store_fraction)
    assert fractions == sorted(fractions)
    assert fractions[-1] == 1.0
    assert len(fractions) > 5
    with pytest.raises(Cancelled):
        integrate_fmu(request, fmu=fmu, progress=lambda fraction: fraction < 0.3)
    with pytest.raises(Cancelled):
        integrate_fmu(request, progress=lambda _fraction: False)


@pytest.mark.parametrize("outcome", ["finished", "cancelled", "failed"])
def test_no_files_or_output_remain_and_the_process_is_unchanged(
    outcome: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    options: dict[str, Any] = {"t_end": 5.0, "method": "fmu"}
    if outcome == "failed":
        options |= {"parameters": UNBOUNDED, "separation": False, "t_end": 1e4, "step": 100.0}
    process_state = sys.path[:], Path.cwd()
    try:
        simulate(progress=lambda _fraction: outcome != "cancelled", **options)
    except (Cancelled, ComputationError) as error:
        assert outcome == ("cancelled" if isinstance(error, Cancelled) else "failed")  # noqa: PT017
    assert list(tmp_path.iterdir()) == []
    assert (sys.path, Path.cwd()) == process_state
    assert capfd.readouterr() == ("", "")


def test_unbounded_growth_ends_with_the_direct_diagnosis() -> None:
    options: dict[str, Any] = {"separation": False, "t_end": 1e4}
    with pytest.raises(ComputationError) as direct:
        simulate_interpreted(UNBOUNDED, **options)
    with pytest.raises(ComputationError) as fmu_run:
        simulate(UNBOUNDED, method="fmu", step=100.0, **options)
    assert direct.value.why in fmu_run.value.why
    assert fmu_run.value.advice == direct.value.advice


def test_too_many_communication_steps_are_refused_at_once() -> None:
    with pytest.raises(ComputationError, match="communication steps"):
        simulate(t_end=1e7, method="fmu", step=1e-3)


def test_a_communication_step_split_too_often_is_refused(
    fmu: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # The requested step of 5 s contains switches: `Master` repeats it in ever shorter parts.
    monkeypatch.setattr(master, "MAX_STEPS", 20)
    with pytest.raises(ComputationError, match="more than 20 communication steps"):
        integrate_fmu(Request(System(Parameters()), t_end=5.0, method="fmu", step=5.0), fmu=fmu)


def test_a_file_that_is_not_this_fmu_is_wrong_input(fmu: Path, tmp_path: Path) -> None:
    request = Request(System(Parameters()), t_end=1.0, method="fmu")
    for path, message in (
        (tmp_path / "absent.fmu", "there is no such file"),
        # An FMU of another model.
        (build_accumulator(tmp_path), "unknown FMU variable"),
        (
            modified_copy(fmu, tmp_path / "m.fmu", {"modelDescription.xml": b"<a/>"}),
            "is not an FMU",
        ),
    ):
        with pytest.raises(InputError, match=message):
            integrate_fmu(request, fmu=path)


@pytest.mark.parametrize("name", ["für", "a#b", "a%b", "a%20b", "a+b", "a(b)"])
def test_a_temporary_folder_that_fmus_cannot_handle_is_not_used(
    name: str, fmu: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder, fallback = tmp_path / name, tmp_path / "plain"
    folder.mkdir()
    fallback.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    monkeypatch.setattr("fivtui.fmu.folders._FALLBACKS", (str(fallback),))
    request = Request(System(Parameters()), t_end=1.0, method="fmu")
    assert integrate_fmu(request, fmu=fmu).final == simulate_interpreted(t_end=1.0).final
    monkeypatch.setattr("fivtui.fmu.folders._FALLBACKS", ())
    # Both hosts of FMUs: of this project's FMU as a method of integration, and of any FMU.
    for run in (lambda: integrate_fmu(request, fmu=fmu), lambda: run_fmu(fmu, t_end=1.0)):
        with pytest.raises(ComputationError, match="set TMPDIR"):
            run()
    assert [*folder.iterdir(), *fallback.iterdir()] == []


def test_a_temporary_folder_with_spaces_works(
    fmu: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "with a space"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    request = Request(System(Parameters()), t_end=1.0, method="fmu")
    assert integrate_fmu(request, fmu=fmu).final == simulate_interpreted(t_end=1.0).final


def test_runs_in_threads_do_not_disturb_each_other() -> None:
    frictions = (0.5, 0.6, 0.7, 0.8)
    finals: dict[float, Any] = {}

    def run(mu: float) -> None:
        finals[mu] = simulate(Parameters(mu=mu), t_end=3.0, method="fmu").final

    threads = [threading.Thread(target=run, args=(mu,)) for mu in frictions]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert finals == {
        mu: simulate_interpreted(Parameters(mu=mu), t_end=3.0).final for mu in frictions
    }


def test_an_interrupt_waits_until_the_fmu_has_returned(fmu: Path) -> None:
    previous = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        fractions_at_interrupts = []

        def interrupt(fraction: float) -> bool:
            os.kill(os.getpid(), signal.SIGINT)
            fractions_at_interrupts.append(fraction)
            return True

        with pytest.raises(KeyboardInterrupt):
            integrate_fmu(Request(System(Parameters()), method="fmu"), fmu=fmu, progress=interrupt)
        # The interrupted call returned, and the run ended before another one.
        assert len(fractions_at_interrupts) == 1
        with pytest.raises(KeyboardInterrupt), defer_interrupts():
            os.kill(os.getpid(), signal.SIGINT)
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    finally:
        signal.signal(signal.SIGINT, previous)
