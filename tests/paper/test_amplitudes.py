"""Amplitudes of many scenes at once."""

import dataclasses

import pytest

from fivtui.model.errors import Cancelled, ComputationError, InputError
from fivtui.paper.amplitudes import Amplitude, compute_amplitudes
from fivtui.paper.results import PaperResults
from fivtui.scene.presets import PRESETS
from fivtui.scene.scene import Scene
from fivtui.simulation import simulate

BASE = dataclasses.replace(PRESETS["base"], t_end=4.0, tol=1e-9)


def short_scenes(count: int) -> list[Scene]:
    return [BASE.with_values({"F": 20.0 + number}) for number in range(count)]


def measure(scene: Scene) -> Amplitude:
    return compute_amplitudes([scene], workers=1)[0]


def unbounded_scene() -> Scene:
    scene = dataclasses.replace(PRESETS["linear"], name="soars", t_end=1e5)
    return scene.with_values({"k2": 186.0, "mu": 2.0})


def test_an_amplitude_is_that_of_the_run() -> None:
    run = simulate(BASE.parameters, t_end=4.0, tol=1e-9, kernel="interpreted")
    amplitude = measure(BASE)
    assert amplitude.y_peak == pytest.approx(run.peak.y_abs, rel=1e-12)
    assert amplitude.y_half_range == pytest.approx(run.steady.y_half_range, rel=1e-12)
    assert amplitude.separations == run.events.separations > 0
    assert amplitude.separated_time == pytest.approx(run.events.separated_time, rel=1e-12)


def test_several_threads_give_the_same_amplitudes_in_the_same_order() -> None:
    requested = short_scenes(40)
    fractions: list[float] = []

    def progress(fraction: float) -> bool:
        fractions.append(fraction)
        return True

    amplitudes = compute_amplitudes(requested, workers=2, progress=progress)
    assert amplitudes == [measure(scene) for scene in requested]
    assert fractions == sorted(fractions)
    assert fractions[-1] == 1.0


def test_scenes_of_different_lengths_and_tolerances_are_measured_in_their_order() -> None:
    requested = short_scenes(4)
    requested[1] = dataclasses.replace(requested[1], tol=1e-10)
    requested[2] = dataclasses.replace(requested[2], t_end=3.0)
    assert compute_amplitudes(requested, workers=2) == [measure(scene) for scene in requested]


# The kernel computes 8 runs at once: more scenes have to wait.
@pytest.mark.parametrize("count", [8, 40])
def test_work_can_be_cancelled(count: int) -> None:
    with pytest.raises(Cancelled):
        compute_amplitudes(short_scenes(count), workers=2, progress=lambda fraction: fraction < 0.2)


@pytest.mark.parametrize("count", [1, 40])
def test_an_error_names_the_scene_that_cannot_be_finished(count: int) -> None:
    with pytest.raises(ComputationError, match=r"soars \(m = 5, .*mu = 2\): .* at t = "):
        compute_amplitudes([unbounded_scene(), *short_scenes(count)], workers=2)


def test_no_workers_are_refused() -> None:
    with pytest.raises(InputError, match="workers = 0"):
        compute_amplitudes(short_scenes(1), workers=0)


def test_no_scenes_give_no_amplitudes() -> None:
    assert compute_amplitudes([]) == []


def test_paper_results_compute_the_amplitude_of_a_scene_once(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    batch_sizes: list[int] = []

    def record_batch_size(scenes: list[Scene], **options: object) -> object:
        batch_sizes.append(len(scenes))
        return compute_amplitudes(scenes, workers=1)

    monkeypatch.setattr("fivtui.paper.results.compute_amplitudes", record_batch_size)
    results = PaperResults()
    three = short_scenes(3)
    results.prepare(three[:2])
    assert results.amplitudes([three[2], three[0], three[2]]) == [
        measure(three[2]),
        measure(three[0]),
        measure(three[2]),
    ]
    # `prepare` computes two scenes, `amplitudes` only the third.
    assert batch_sizes == [2, 1]
