"""Sensitivities against differences of 25-digit runs and of runs, in Python and by the command."""

import dataclasses
import json
from pathlib import Path
from typing import Any, Final

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given, settings

import tests.references
from fivtui import Parameters, simulate
from fivtui.cli import commands
from fivtui.model import System
from fivtui.model.errors import ComputationError, InputError
from fivtui.model.parameters import PARAMETERS
from fivtui.model.slider_belt import equilibrium, static_start, static_start_change
from fivtui.transient.derivatives.sensitivity import Sensitivity
from fivtui.transient.files import restore_transient, store_transient
from tests.support.kernels import INTERPRETED
from tests.support.strategies import moderate_parameters

REFERENCES: Final[dict[str, Any]] = json.loads(
    Path(tests.references.__file__).with_name("derivatives.json").read_text(encoding="utf-8")
)


def flat_derivatives(sensitivity: Sensitivity) -> np.ndarray:
    """The derivatives in the order of the quantities of a reference."""
    return np.array(
        [*sensitivity.final, *sensitivity.peak, *sensitivity.steady, *sensitivity.contact_force]
    )


@pytest.mark.parametrize("name", REFERENCES)
def test_sensitivities_are_differences_of_25_digit_runs(name: str) -> None:
    reference = REFERENCES[name]
    run = simulate(
        Parameters(**reference["parameters"]),
        t_end=reference["t_end"],
        tol=1e-13,
        separation=reference["separation"],
        start=reference["start"],
        sensitivities=list(PARAMETERS),
    )
    assert run.sensitivities is not None
    assert list(run.sensitivities) == list(PARAMETERS)
    for parameter, sensitivity in run.sensitivities.items():
        expected = np.array(reference["by"][parameter])
        # The first ten quantities, the final state and the extremes and amplitude of motion, have
        # a common scale; the least and the greatest contact force have one each.
        scale = np.concatenate([np.full(10, np.abs(expected[:10]).max()), np.abs(expected[10:])])
        assert (np.abs(flat_derivatives(sensitivity) - expected) <= 1e-11 * scale + 1e-13).all(), (
            parameter
        )


def test_without_a_compiled_kernel_sensitivities_are_interpreted() -> None:
    compiled = simulate(t_end=1.0, sensitivities=["mu"])
    with INTERPRETED:
        run = simulate(t_end=1.0, sensitivities=["mu"])
    assert run.stats.kernel == "interpreted"
    assert run.sensitivities is not None
    assert compiled.sensitivities is not None
    compiled_derivatives = flat_derivatives(compiled.sensitivities["mu"])
    assert flat_derivatives(run.sensitivities["mu"]) == pytest.approx(
        compiled_derivatives, rel=1e-9, abs=1e-12
    )


@settings(max_examples=20)
@given(moderate_parameters())
def test_changes_of_the_static_start_agree_with_differences(p: Parameters) -> None:
    for separation in (True, False):
        for name in PARAMETERS:
            nudge = 1e-6 * (1.0 + abs(getattr(p, name)))
            starts = [
                static_start(
                    System(
                        dataclasses.replace(p, **{name: getattr(p, name) + offset * nudge}),
                        separation,
                    ),
                )
                for offset in (0, 1, 2)
            ]
            first, second, third = map(np.array, starts)
            difference = (4.0 * second - 3.0 * first - third) / 2 / nudge
            change = static_start_change(System(p, separation), name)
            assert change == pytest.approx(difference, rel=1e-5, abs=1e-7), name


def test_a_start_in_numbers_does_not_depend_on_parameters() -> None:
    # In a time too short for motion, the derivatives are those of the start.
    p = Parameters()
    start = static_start(System(p))
    sensitivities_of_fixed_start = simulate(
        p, t_end=1e-9, start=start, sensitivities=["F", "k1"]
    ).sensitivities
    sensitivities_of_static_start = simulate(p, t_end=1e-9, sensitivities=["F", "k1"]).sensitivities
    assert sensitivities_of_fixed_start is not None
    assert sensitivities_of_static_start is not None
    for name in ("F", "k1"):
        assert sensitivities_of_fixed_start[name].final == pytest.approx((0.0,) * 4, abs=1e-9)
        assert sensitivities_of_static_start[name].final == pytest.approx(
            static_start_change(System(p), name), abs=1e-9
        )


def test_growth_of_deviations_determines_the_reliable_digits() -> None:
    fine = simulate(t_end=20.0, tol=1e-13, sensitivities=["F"]).sensitivities
    coarse = simulate(t_end=20.0, tol=1e-6, sensitivities=["F"]).sensitivities
    assert fine is not None
    assert coarse is not None
    relative_error = np.abs(np.array(coarse["F"].final) / np.array(fine["F"].final) - 1.0).max()
    assert fine.growth == pytest.approx(68.687397, rel=1e-6)
    assert (fine.digits(1e-13), coarse.digits(1e-6)) == (11, 4)
    assert relative_error < 10.0 ** -coarse.digits(1e-6)


def test_at_a_kink_the_derivatives_are_those_towards_greater_values() -> None:
    # At rest on the switch without preload; a preload presses the slider down.
    run = simulate(Parameters(F=0.0, mu=0.0), t_end=2.0, sensitivities=["F"])
    heavier = simulate(Parameters(F=1e-6, mu=0.0), t_end=2.0)
    assert run.sensitivities is not None
    sensitivity = run.sensitivities["F"]
    assert run.peak.y_abs == run.contact_force.min == 0.0
    assert sensitivity.peak.y_abs == pytest.approx(heavier.peak.y_abs / 1e-6, rel=1e-3)
    assert sensitivity.contact_force.min == pytest.approx(
        heavier.contact_force.min / 1e-6, rel=1e-3
    )
    assert sensitivity.contact_force.max > 0.0


def test_decayed_deviations_are_zero_and_cost_no_time() -> None:
    # A deviation of the start decays at 160 1/s: within the run it underflows to zero.
    run = simulate(Parameters(m=1e-3, mu=0.2), t_end=10.0, sensitivities=["mu"])
    assert run.sensitivities is not None
    assert run.sensitivities.growth == 0.0
    rest = equilibrium(System(run.parameters))
    moved_rest = equilibrium(System(Parameters(m=1e-3, mu=0.2 + 1e-6)))
    expected = ((moved_rest.x - rest.x) / 1e-6, 0.0, (moved_rest.y - rest.y) / 1e-6, 0.0)
    assert run.sensitivities["mu"].final == pytest.approx(expected, rel=1e-5, abs=1e-9)


def test_progress_rises_through_the_run_and_its_derivatives() -> None:
    fractions: list[float] = []

    def record_fraction(fraction: float) -> bool:
        fractions.append(fraction)
        return True

    plain = simulate(t_end=50.0)
    run = simulate(t_end=50.0, sensitivities=["mu"], progress=record_fraction)
    assert fractions == sorted(fractions)
    # The computation may end after its last report.
    assert fractions[-1] > 0.5
    assert run.final == plain.final
    assert run.stats.kernel == plain.stats.kernel


@pytest.mark.parametrize("method", ["rk4", "scipy-dop853", "fmu"])
def test_methods_without_sensitivities_refuse_them(method: str) -> None:
    with pytest.raises(InputError, match=f"the method must be taylor, not {method}"):
        simulate(t_end=1.0, method=method, sensitivities=["mu"])


def test_unknown_and_repeated_names_are_refused() -> None:
    with pytest.raises(InputError, match="did you mean k_nl"):
        simulate(sensitivities=["knl"])
    with pytest.raises(InputError, match="every name must be given once"):
        simulate(sensitivities=["mu", "mu"])
    with pytest.raises(InputError, match=r"must be a list of names, such as \['mu'\]"):
        simulate(sensitivities="mu")


def test_an_unbounded_motion_has_no_sensitivities() -> None:
    growing = Parameters(k_nl=0.0, mu=3.0)
    with pytest.raises(ComputationError, match="beyond the floating-point range"):
        simulate(growing, t_end=5000.0, separation=False, sensitivities=["mu"])


def test_a_stored_transient_keeps_its_sensitivities(tmp_path: Path) -> None:
    run = simulate(t_end=1.0, samples=3, sensitivities=["mu"])
    store_transient(run, tmp_path / "run.npz")
    assert restore_transient(tmp_path / "run.npz").sensitivities == run.sensitivities


def test_the_command_prints_sensitivities_in_a_table_and_as_data() -> None:
    arguments = ["simulate", "--t-end", "20", "--sensitivity", "mu", "--sensitivity", "F"]
    table = CliRunner().invoke(commands, arguments).stdout
    assert "small deviations grow 68.7 times until the end; about 10 digits are reliable" in table
    row = next(line for line in table.splitlines() if line.startswith("peak |y|, m"))
    assert row.split()[-2:] == ["10.6029", "0.347463"]
    data = json.loads(CliRunner().invoke(commands, [*arguments, "--json"]).stdout)
    assert set(data["sensitivities"]["by"]) == {"mu", "F"}
    assert data["sensitivities"]["by"]["F"]["peak"]["y_abs"] == pytest.approx(0.347462548667)
    assert set(data["sensitivities"]["by"]["F"]["final"]) == {"x", "vx", "y", "vy"}
    assert "sensitivities" not in json.loads(
        CliRunner().invoke(commands, [*arguments[:3], "--json"]).stdout
    )
