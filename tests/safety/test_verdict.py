"""Safe friction: known folds, isolated cycles, edges of the model, and transients that agree.

The basis of a verdict records how it was found: branches of cycles, rounds of the search, and a
proof. First rounds have few starts (scouts). `others` are the attractors beside the equilibrium.
"""

import json
import math
from collections.abc import Callable, Iterator

import numpy as np
import pytest

from fivtui import Cancelled, Parameters, safe_friction, simulate
from fivtui.model import System, equilibrium
from fivtui.safety import search
from fivtui.safety.phrases import largest_cycle_text, verdict_text
from fivtui.safety.verdict import SafeFriction


@pytest.fixture
def few_starts(monkeypatch: pytest.MonkeyPatch) -> None:
    """A faster search with a quarter of the starts."""
    monkeypatch.setattr(search, "STARTS", 32)


@pytest.fixture(scope="module")
def base() -> SafeFriction:
    return safe_friction(Parameters(mu=0.3))


def test_safe_mu_of_the_base_set_is_the_fold_of_its_branch(base: SafeFriction) -> None:
    assert base.critical_mu == pytest.approx(0.439387619, abs=1e-8)
    assert base.safe_mu == pytest.approx(0.277876613, abs=1e-8)
    assert base.found_by == "continuation"
    assert verdict_text(base) == (
        "stable to small disturbances below μ = 0.43938; "
        "to all disturbances found below μ = 0.27787"
    )
    # Scouts have 16 starts per value of μ, full rounds up to 128.
    scouts, final_round = base.basis.rounds
    assert scouts.died_out == scouts.starts < 0.2 * final_round.starts
    assert final_round.died_out == final_round.starts > 1000
    assert 0.95 * 0.277876613 < final_round.levels[-1] < 0.277876613
    # No limit of steps or of rounds ended the search.
    assert not base.basis.budget_ended
    assert "fold 0.2779" in repr(base)
    json.dumps(base.to_dict(), allow_nan=False)


def test_a_knock_leads_to_the_coexisting_cycle(base: SafeFriction) -> None:
    (cycle,) = base.coexisting
    knocked = simulate(base.parameters, start=(0.0, 0.0, 5.0, 0.0), t_end=1000.0)
    assert cycle.half_range == pytest.approx(knocked.steady.y_half_range, rel=1e-6)
    assert largest_cycle_text(base) == (
        f"a limit cycle coexists from μ = 0.2779: half peak-to-peak {cycle.half_range:#.4g} m"
    )


def test_motion_from_within_the_proved_offset_decays(base: SafeFriction) -> None:
    offset = base.basis.proved_offset
    assert offset is not None
    rest = equilibrium(System(base.parameters))
    for sign in (1.0, -1.0):
        start = (rest.x, 0.0, rest.y + sign * 0.999 * offset, 0.0)
        run = simulate(base.parameters, start=start, t_end=1000.0)
        assert 0.0 < run.steady.y_half_range < 1e-3 * offset
        assert run.events.separations == 0


@pytest.mark.usefixtures("few_starts")
def test_a_cycle_that_is_not_on_the_branch_from_the_hopf_point_is_found() -> None:
    verdict = safe_friction(Parameters(F=5.0))
    fold, other_motion = verdict.others
    assert verdict.found_by == fold.found_by == "global search"
    assert verdict.safe_mu == fold.mu
    assert other_motion.found_by == "continuation"
    assert fold.mu < 0.75 * other_motion.mu
    assert_confirmed(verdict)


@pytest.mark.usefixtures("few_starts")
def test_a_slider_off_the_belt_has_a_safe_mu_without_a_critical_mu() -> None:
    verdict = safe_friction(Parameters(F=-20.0, mu=0.2))
    assert verdict.critical_mu is None
    assert "stable to small disturbances at every μ; to all" in verdict_text(verdict)
    assert_confirmed(verdict)


@pytest.mark.usefixtures("few_starts")
def test_safe_and_critical_mu_are_equal_at_a_supercritical_hopf_point() -> None:
    verdict = safe_friction(Parameters(F=40.0))
    assert verdict.safe_mu == verdict.critical_mu
    assert verdict.found_by == "eigenvalues"
    assert verdict_text(verdict).endswith("to all disturbances found as well")


@pytest.mark.usefixtures("few_starts")
@pytest.mark.parametrize(
    ("values", "separation", "safe", "message"),
    [
        ({"k_nl": 0.0}, False, 1.0181, "the system is linear"),
        # The message begins with "small disturbances do not grow".
        ({"c1": 0.0, "c2": 0.0}, True, None, "without damping none dies out"),
        ({"c1": 1e-5, "c2": 1e-5}, True, None, "safe μ is not known, and is below μ = 0.277"),
        ({"c1": 1e9}, True, None, "safe μ is not known (motions die out too slowly"),
        ({"k3": 0.0, "c1": 0.0}, True, None, "safe μ is not known (motions die"),
        ({"k3": 0.0}, True, None, "to all disturbances found up to μ = 2 as well"),
    ],
)
def test_edge_cases_of_the_model_have_a_message(
    values: dict[str, float], separation: bool, safe: float | None, message: str
) -> None:
    verdict = safe_friction(Parameters(mu=0.2).with_values(values), separation=separation)
    assert verdict.safe_mu == (None if safe is None else pytest.approx(safe, abs=1e-4))
    assert message in verdict_text(verdict)
    # `unknown_above` is 0 if safe μ is not known at all, and None if it is known.
    is_unknown = "not known" in message or verdict.undamped
    assert (verdict.unknown_above == 0.0) == is_unknown
    assert verdict.to_dict()["safe_mu_not_known_above"] == verdict.unknown_above
    assert "proof" in repr(verdict)
    json.dumps(verdict.to_dict(), allow_nan=False)


@pytest.mark.usefixtures("few_starts")
def test_folds_without_separation_are_found() -> None:
    verdict = safe_friction(Parameters(F=20.0), separation=False)
    assert verdict.safe_mu == pytest.approx(0.27780057, abs=1e-7)


def test_decay_of_every_motion_of_a_linear_system_is_proved() -> None:
    verdict = safe_friction(Parameters(k_nl=0.0, mu=0.5), separation=False)
    assert verdict.basis.proved_offset == math.inf
    assert verdict.to_dict()["safe_mu_basis"]["proof"]["everywhere"] is True


def test_the_verdict_is_reproducible_and_can_be_cancelled(base: SafeFriction) -> None:
    first, second = base.to_dict(), safe_friction(base.parameters).to_dict()
    for result in (first, second):
        assert result["safe_mu_basis"].pop("cpu_s") > 0.0
    assert first == second
    for count in (0, 3):
        with pytest.raises(Cancelled):
            safe_friction(base.parameters, progress=stop_after(count))


def stop_after(count: int) -> Callable[[float], bool]:
    calls = iter(range(10**6))
    return lambda _fraction: next(calls) < count


def assert_confirmed(verdict: SafeFriction) -> None:
    """Assert that motion from each cycle persists above its least μ, and decays below safe μ."""
    for motion in verdict.others:
        if motion.cycle is None:
            assert motion.kind != "limit cycle"
            continue
        half_range_above, half_range_below = (
            simulate(
                verdict.parameters.with_values({"mu": motion.mu * (1.0 + change)}),
                separation=verdict.separation,
                start=motion.cycle.start,
                t_end=4000.0,
                tol=1e-8,
            ).steady.y_half_range
            for change in (2e-3, -2e-3)
        )
        assert half_range_above > 0.5 * motion.cycle.half_range
        if motion.mu == verdict.safe_mu:
            assert half_range_below < 0.25 * motion.cycle.half_range


def random_sets(count: int, seed: int) -> Iterator[Parameters]:
    random = np.random.default_rng(seed)
    low = [1.0, 50.0, 20.0, 20.0, 0.2, 0.2, 5.0, 1.0]
    high = [10.0, 300.0, 200.0, 150.0, 2.0, 2.0, 200.0, 500.0]
    names = ("m", "k1", "k2", "k3", "c1", "c2", "F", "k_nl")
    for _ in range(count):
        yield Parameters(**dict(zip(names, random.uniform(low, high).tolist(), strict=True)))


def count_confirmed(sets: Iterator[Parameters]) -> int:
    """Count the parameter sets with a further attractor; transients confirm each verdict."""
    count = 0
    for p in sets:
        verdict = safe_friction(p)
        assert_confirmed(verdict)
        count += any(motion.kind == "limit cycle" for motion in verdict.others)
    return count


@pytest.mark.usefixtures("few_starts")
def test_transients_confirm_the_verdict_on_random_parameters() -> None:
    assert count_confirmed(random_sets(6, seed=15)) > 2


@pytest.mark.whole
def test_transients_confirm_the_verdict_on_many_random_parameters() -> None:
    assert count_confirmed(random_sets(100, seed=16)) > 50
