"""Batches and sweeps on belts of finite speed."""

import numpy as np
import pytest

from fivtui import Parameters, simulate, simulate_batch, stability, sweep
from fivtui.batch import run as batch_run
from fivtui.model.errors import InputError

SPEEDS = [0.0, 0.2, 1.0, 30.0]
FRICTION = {"mu_s": 0.9, "v_s": 0.4}


def test_a_member_of_a_batch_is_the_single_run_to_the_last_bit() -> None:
    base = Parameters().with_values(FRICTION)
    batch = simulate_batch({"v_belt": SPEEDS}, base=base, t_end=10.0)
    for place, speed in enumerate(SPEEDS):
        run = simulate(base.with_values({"v_belt": speed}), t_end=10.0)
        assert batch.final[place].tolist() == list(run.final[1:])
        assert batch.peak.y_max[place] == run.peak.y_max
        assert batch.events.separations[place] == run.events.separations
        assert batch.steps[place] == run.stats.steps
    given_up = simulate_batch({"v_belt": [1.0]}, t_end=10.0, max_steps=5)
    assert given_up.failed.tolist() == [0]


def test_an_interpreted_batch_is_that_of_the_kernel(monkeypatch: pytest.MonkeyPatch) -> None:
    compiled = simulate_batch({"v_belt": SPEEDS}, t_end=3.0)
    monkeypatch.setattr(batch_run, "why_interpreted", lambda: "no compiler")
    interpreted = simulate_batch({"v_belt": SPEEDS}, t_end=3.0)
    assert interpreted.final == pytest.approx(compiled.final, abs=1e-11)


def test_the_peak_over_the_speed_of_the_belt_ends_in_that_of_one_always_faster() -> None:
    found = sweep(vary={"v_belt": [0.2, 1.0, 40.0]}, outputs=["y_max", "growth_rate", "stable"])
    peaks = [row[2] for row in found.rows]
    assert peaks == sorted(peaks)
    assert peaks[-1] == simulate().peak.y_max
    assert [row[3] for row in found.rows] == pytest.approx([stability().growth_rate] * 3)
    assert [row[4] for row in found.rows] == [False] * 3


def test_what_has_no_effect_or_is_out_of_range_is_refused() -> None:
    with pytest.raises(InputError, match="mu_s: has no effect without v_belt"):
        simulate_batch({"mu_s": [1.0]})
    with pytest.raises(InputError, match=r"member 1: mu_s = 0\.5: must be at least mu = 0\.7"):
        simulate_batch({"mu_s": [1.0, 0.5], "v_belt": np.ones(2)})
    # What a base has beside the belt's speed is left out, as in a single run.
    base = Parameters().with_values(FRICTION)
    assert simulate_batch({"F": [80.0]}, base=base, t_end=1.0).failed.size == 0
    with pytest.raises(InputError, match="v_belt = -1"):
        simulate_batch({"v_belt": [-1.0]})
