"""Amplitudes of many scenes, in one process and in several."""

import dataclasses
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from fivtui.model.errors import Cancelled, ComputationError, InputError
from fivtui.paper.amplitudes import measure, measure_all
from fivtui.paper.results import PaperResults
from fivtui.scene.presets import PRESETS
from fivtui.scene.scene import Scene
from fivtui.simulation import simulate

ROOT = Path(__file__).parents[2]
BASE = dataclasses.replace(PRESETS["base"], t_end=4.0, tol=1e-9)


def scenes(count: int) -> list[Scene]:
    return [BASE.with_values({"F": 20.0 + place}) for place in range(count)]


def unbounded() -> Scene:
    scene = dataclasses.replace(PRESETS["linear"], name="soars", t_end=1e5)
    return scene.with_values({"k2": 186.0, "mu": 2.0})


def test_an_amplitude_is_that_of_the_run() -> None:
    run = simulate(BASE.parameters, t_end=4.0, tol=1e-9, kernel="interpreted")
    amplitude = measure(BASE)
    assert amplitude.y_peak == pytest.approx(run.peak.y_abs, rel=1e-12)
    assert amplitude.y_half_range == pytest.approx(run.steady.y_half_range, rel=1e-12)
    assert amplitude.separations == run.events.separations > 0
    assert amplitude.separated_time == pytest.approx(run.events.separated_time, rel=1e-12)


@pytest.mark.slow
def test_several_processes_give_the_same_in_the_same_order() -> None:
    asked = scenes(40)
    seen: list[float] = []

    def progress(fraction: float) -> bool:
        seen.append(fraction)
        return True

    several = measure_all(asked, workers=2, progress=progress)
    assert several == [measure(scene) for scene in asked]
    assert seen == sorted(seen)
    assert seen[-1] == 1.0


def test_every_method_is_measured_in_its_place() -> None:
    asked = scenes(4)
    asked[1] = dataclasses.replace(asked[1], method="scipy-dop853", tol=1e-10)
    asked[2] = dataclasses.replace(asked[2], t_end=3.0)
    found = measure_all(asked, workers=2)
    assert found == [measure(scene) for scene in asked]
    assert found[1].y_peak == pytest.approx(measure(scenes(4)[1]).y_peak, rel=1e-6)


@pytest.mark.parametrize("count", [8, 40])
def test_work_can_be_cancelled(count: int) -> None:
    with pytest.raises(Cancelled):
        measure_all(scenes(count), workers=2, progress=lambda fraction: fraction < 0.2)


@pytest.mark.parametrize("count", [1, 40])
def test_a_run_that_cannot_be_finished_is_named(count: int) -> None:
    with pytest.raises(ComputationError, match=r"soars \(m = 5, .*mu = 2\): .* at t = "):
        measure_all([unbounded(), *scenes(count)], workers=2)


def test_no_workers_are_refused() -> None:
    with pytest.raises(InputError, match="workers = 0"):
        measure_all(scenes(1), workers=0)


def test_no_scenes_give_no_amplitudes() -> None:
    assert measure_all([]) == []


def test_a_script_that_workers_cannot_import_is_told_what_to_do(tmp_path: Path) -> None:
    script = tmp_path / "unguarded.py"
    script.write_text(
        "from dataclasses import replace\n"
        "from fivtui.paper.amplitudes import measure_all\n"
        "from fivtui.scene.presets import PRESETS\n"
        "from fivtui.model.errors import ComputationError\n"
        "base = replace(PRESETS['base'], method='scipy-lsoda', t_end=0.1)\n"
        "scenes = [base.with_values({'F': 20.0 + k}) for k in range(40)]\n"
        "try:\n"
        "    measure_all(scenes, workers=2)\n"
        "except ComputationError as error:\n"
        "    print(error)\n"
    )
    done = subprocess.run(
        [sys.executable, str(script)],
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=600,
        check=True,
    )
    assert 'if __name__ == "__main__"' in done.stdout


def test_a_study_computes_a_scene_once(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[int] = []

    def counting(given: list[Scene], **more: object) -> object:
        asked.append(len(given))
        return measure_all(given, workers=1)

    monkeypatch.setattr("fivtui.paper.results.measure_all", counting)
    results = PaperResults()
    three = scenes(3)
    results.prepare(three[:2])
    assert results.amplitudes([three[2], three[0], three[2]]) == [
        measure(three[2]),
        measure(three[0]),
        measure(three[2]),
    ]
    assert asked == [2, 1]


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="process groups are POSIX")
def test_an_interrupt_ends_all_processes_without_traceback(tmp_path: Path) -> None:
    # A parent that ignores the interrupt, as a shell's background job does, hands that on.
    code = (
        "import signal, sys\n"
        "from dataclasses import replace\n"
        "from pathlib import Path\n"
        "from fivtui.paper.amplitudes import measure_all\n"
        "from fivtui.scene.presets import PRESETS\n"
        "if __name__ == '__main__':\n"
        "    signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "    base = replace(PRESETS['base'], method='rk4', t_end=0.5)\n"
        "    scenes = [base.with_values({'F': 20.0 + k}) for k in range(400)]\n"
        "    def begun(done):\n"
        "        if done:\n"
        "            Path(sys.argv[1]).touch()\n"
        "        return True\n"
        "    try:\n"
        "        measure_all(scenes, workers=2, progress=begun)\n"
        "    except KeyboardInterrupt:\n"
        "        sys.exit('cancelled')\n"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", code, str(tmp_path / "begun")],
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    while not (tmp_path / "begun").exists() and process.poll() is None:
        time.sleep(0.01)
    os.killpg(process.pid, signal.SIGINT)
    out, error = process.communicate(timeout=600)
    assert process.returncode == 1
    assert out == ""
    assert error.strip() == "cancelled"
