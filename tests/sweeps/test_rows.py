"""Designs and rows of sweeps."""

import dataclasses
import itertools
import pickle
import re
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, strategies as st
from scipy.stats import qmc

import fivtui.sweeps.rows as rows_module
from fivtui import Parameters, simulate, stability, sweep
from fivtui.batch.run import simulate_batch
from fivtui.cli import run
from fivtui.model import System
from fivtui.model.errors import Cancelled, ComputationError, InputError
from fivtui.scene.run import simulate_to
from fivtui.studies import build_command, load_study
from fivtui.sweeps.design import Design, DesignKind, Range
from fivtui.sweeps.rows import Rows, compute_rows, concatenate
from fivtui.sweeps.run import check_memory_limit, local_engine, sweep_in_memory
from fivtui.sweeps.study import DEFAULT_OUTPUTS, OUTPUTS, Study
from fivtui.transient.request import Request
from fivtui.transient.result import Transient


def values(design: Design, first: int, end: int) -> list[tuple[float, ...]]:
    """The points `first` to `end` - 1 of a design."""
    columns = design.columns(np.arange(first, end))
    return list(zip(*(column.tolist() for column in columns.values()), strict=True))


def test_a_product_has_every_value_with_every_other_the_last_varying_fastest() -> None:
    design = Design({"F": Range(10.0, 30.0, 3), "mu": (0.5, 0.1)})
    assert design.size == 6
    assert values(design, 0, 6) == list(itertools.product([10.0, 20.0, 30.0], [0.5, 0.1]))


def test_a_list_has_values_side_by_side() -> None:
    design = Design({"F": Range(10.0, 30.0, 3), "mu": (0.5, 0.1, 0.2)}, "list")
    assert values(design, 0, 3) == [(10.0, 0.5), (20.0, 0.1), (30.0, 0.2)]


@given(st.floats(1e-6, 1e6), st.floats(1e-6, 1e6), st.integers(2, 50), st.booleans())
def test_a_range_has_its_ends_exactly_and_even_spacing(
    start: float, stop: float, count: int, log: bool
) -> None:
    values = Range(start, stop, count, log).values_at(np.arange(count))
    assert (values[0], values[-1]) == (start, stop)
    expected = np.geomspace(start, stop, count) if log else np.linspace(start, stop, count)
    np.testing.assert_allclose(values, expected, rtol=1e-9)


DESIGNS = (
    Design({"F": Range(10.0, 120.0, 13), "mu": Range(0.1, 1.0, 7, log=True)}),
    Design({"F": Range(10.0, 120.0, 91)}, "list"),
    Design({"F": Range(10.0, 120.0), "mu": Range(0.1, 1.0), "y0": Range(-1.0, 1.0)}, "random", 91),
    Design({"F": Range(10.0, 120.0), "k_nl": Range(1.0, 500.0, None, True)}, "sobol", 91, 5),
)


@given(st.sampled_from(DESIGNS), st.integers(0, 90), st.integers(1, 91))
def test_a_member_depends_on_its_index_alone(design: Design, first: int, size: int) -> None:
    end = min(first + size, 91)
    assert values(design, first, end) == values(design, 0, 91)[first:end]


@pytest.mark.parametrize("size", [1, 3, 9])
def test_sobol_points_are_those_of_scipy(size: int) -> None:
    names = list(Parameters().as_dict())[:size]
    design = Design({name: Range(1.0, 2.0) for name in names}, "sobol", 256, 11)
    expected = 1.0 + qmc.Sobol(size, bits=32, rng=11).random(256)
    assert np.array_equal(values(design, 0, 256), expected)


def test_random_points_are_uniform_and_follow_the_seed() -> None:
    first, repeated, different = (
        Design({"F": Range(0.0, 1.0), "mu": Range(0.0, 1.0)}, "random", 4096, seed)
        for seed in (1, 1, 2)
    )
    points = np.array(values(first, 0, 4096))
    assert values(first, 0, 9) == values(repeated, 0, 9) != values(different, 0, 9)
    cells = np.floor(points * 8.0) @ np.array([8.0, 1.0])
    counts = np.bincount(cells.astype(int), minlength=64)
    # Chi-square of 63 degrees of freedom: 110 is its 99.98 % quantile.
    assert ((counts - 64.0) ** 2 / 64.0).sum() < 110.0


def test_a_billion_members_cost_nothing_until_they_are_computed() -> None:
    axes = {"F": Range(10.0, 120.0, 100_000), "mu": Range(0.1, 1.0, 10_000)}
    study = Study(Design(axes), Parameters(), cases=(True, False), t_end=1.0)
    assert study.members == 2_000_000_000
    rows = compute_rows(study, 1_999_999_998, 2_000_000_000)
    assert rows.numbers["F"].tolist() == [120.0, 120.0]
    assert rows.numbers["mu"].tolist() == [1.0, 1.0]
    assert rows.separation.tolist() == [True, False]
    assert len(pickle.dumps(study)) < 2000


@pytest.mark.parametrize(
    ("axes", "settings", "message"),
    [
        ({}, {}, "nothing varies"),
        ({"knl": (1.0,)}, {}, "did you mean k_nl"),
        ({"m": (0.0,)}, {}, "m = 0: must be from 1e-12"),
        ({"mu": Range(0.0, 101.0, 3)}, {}, "mu = 101"),
        ({"x0": Range(0.0, 1e10, 3)}, {}, "x0 = 1e"),
        ({"F": ()}, {}, "one or more values"),
        ({"F": Range(1.0, 2.0)}, {}, "count must be given"),
        ({"F": (1.0, 2.0), "mu": (0.1,)}, {"kind": "list"}, "F has 2, mu has 1"),
        ({"F": (1.0,)}, {"kind": "grid"}, "known: product"),
        ({"F": (1.0,)}, {"seed": 1}, "seed must not be given"),
        ({"F": (1.0, 2.0)}, {"kind": "random", "count": 3}, "two ends"),
        ({"F": Range(1.0, 2.0, 3)}, {"kind": "sobol", "count": 3}, "two ends"),
        ({"F": Range(1.0, 2.0)}, {"kind": "sobol"}, "count"),
        ({"F": Range(1.0, 2.0)}, {"kind": "sobol", "count": 2**32 + 1}, "count"),
        ({"F": Range(1.0, 2.0)}, {"kind": "random", "count": 1, "seed": -1}, "seed"),
        ({name: Range(1.0, 2.0, 10**7) for name in ("F", "k1", "k2")}, {}, "members"),
    ],
)
def test_a_wrong_design_is_refused(axes: Any, settings: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        Design(axes, **settings)


@pytest.mark.parametrize(
    ("start", "stop", "count", "log", "message"),
    [
        (np.nan, 1.0, 2, False, "finite"),
        (0.0, np.inf, 2, False, "finite"),
        (0.0, 1.0, 0, False, "count"),
        (0.0, 1.0, 1, False, "the same where count is 1"),
        (0.0, 1.0, 3, True, "above 0"),
    ],
)
def test_a_wrong_range_is_refused(
    start: float, stop: float, count: int, log: bool, message: str
) -> None:
    with pytest.raises(InputError, match=message):
        Range(start, stop, count, log)


def test_a_design_has_at_most_as_many_members_as_indices_have_room_for() -> None:
    limit = 2**62
    assert (
        Design({"F": Range(1.0, 2.0)}, "random", 4, limit - 1).columns(np.arange(4))["F"].size == 4
    )
    assert Design({"F": Range(1.0, 2.0, 2**31), "mu": Range(0.1, 0.2, 2**31)}).size == limit
    with pytest.raises(InputError, match="must be at most"):
        Design({"F": Range(1.0, 2.0, 2**31), "mu": Range(0.1, 0.2, 2**31 + 1)})
    with pytest.raises(InputError, match=f"must be from 0 to {limit - 1}"):
        Design({"F": Range(1.0, 2.0)}, "random", 4, limit)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"cases": ()}, "True, False, or both"),
        ({"cases": (True, True)}, "True, False, or both"),
        ({"outputs": ()}, "one or more names"),
        ({"outputs": ("y_abs", "y_abs")}, "each once"),
        ({"outputs": ("yabs",)}, "did you mean y_abs"),
        ({"t_end": 0.0}, "t_end"),
        ({"tol": 1.0}, "tol"),
        ({"start": (1.0, 2.0)}, "four"),
        (
            {"accuracy": (("events", 1e-3),)},
            "must be one of final, peak, half_range; a sweep does",
        ),
        ({"accuracy": (("peak", 0.0),)}, "must be above 0 and at most 1"),
    ],
)
def test_a_wrong_study_is_refused(settings: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        Study(Design({"F": (1.0,)}), Parameters(), **settings)


def output_of(run: Transient, name: str) -> Any:
    """The value of a run in an output column of sweeps."""
    return attrgetter(OUTPUTS[name].path)(run)


def test_rows_are_what_single_runs_give() -> None:
    names = [*DEFAULT_OUTPUTS, "growth_rate", "stable"]
    result = sweep(vary={"F": (60.0, 120.0)}, separation="both", t_end=20.0, outputs=names)
    assert result.columns == ["F", "separation", *names, "status", "reason"]
    for row in result.rows:
        named = dict(zip(result.columns, row, strict=True))
        p = Parameters(F=named["F"])
        run = simulate(p, t_end=20.0, separation=named["separation"], kernel="compiled")
        for name in DEFAULT_OUTPUTS:
            assert named[name] == pytest.approx(output_of(run, name), rel=1e-9, abs=1e-9), name
            assert type(named[name]) is type(output_of(run, name))
        verdict = stability(p)
        assert named["growth_rate"] == pytest.approx(verdict.growth_rate, abs=1e-12)
        assert named["stable"] is verdict.stable
        assert (named["status"], named["reason"]) == ("done", "")
    assert [row[:2] for row in result.rows] == [
        [60.0, True], [60.0, False], [120.0, True], [120.0, False]
    ]  # fmt: skip


@pytest.mark.parametrize("names", [(name,) for name in DEFAULT_OUTPUTS])
def test_an_output_does_not_depend_on_the_other_outputs(names: tuple[str, ...]) -> None:
    for separation in (True, False):
        vary = {"F": (60.0, 120.0), "k2": (40.0, 60.0)}
        together, alone = (
            sweep(vary=vary, separation=separation, t_end=20.0, outputs=outputs).table.numbers
            for outputs in (DEFAULT_OUTPUTS, names)
        )
        assert list(alone) == ["F", "k2", *names]
        np.testing.assert_allclose(alone[names[0]], together[names[0]], rtol=1e-9, atol=1e-12)


def test_a_component_of_the_start_replaces_that_of_the_scene() -> None:
    at_rest = simulate(t_end=0.5, kernel="compiled").start
    outputs = ("x_end", "y_end")
    for start in ("static", (0.1, 0.2, -0.3, 0.4)):
        rows = sweep(vary={"y0": (-0.7,)}, start=start, t_end=0.5, outputs=outputs).rows
        x, vx, _, vy = at_rest if start == "static" else (0.1, 0.2, -0.3, 0.4)
        exact = simulate(start=(x, vx, -0.7, vy), t_end=0.5, kernel="compiled").final
        assert rows[0][2:4] == pytest.approx([exact.x, exact.y], rel=1e-12)


def test_requested_errors_are_met_and_reported_for_each_member() -> None:
    tolerances = {"final": 1e-5, "peak": 1e-6, "half_range": 1e-6}
    vary = {"F": (20.0, 80.0), "c1": (0.0, 0.32)}
    result = sweep(
        vary=vary, separation="both", t_end=200.0, accuracy=tolerances, outputs=["y_abs"]
    )
    assert result.columns[3:-2] == ["y_abs", "final_error", "peak_error", "half_range_error"]
    assert result.table.failed == 0
    for row in result.rows:
        named = dict(zip(result.columns, row, strict=True))
        p = Parameters(F=named["F"], c1=named["c1"])
        truth = simulate(p, t_end=200.0, tol=1e-13, separation=named["separation"])
        assert named["y_abs"] == pytest.approx(truth.peak.y_abs, rel=tolerances["peak"])
        for name, error in tolerances.items():
            assert 0.0 <= named[f"{name}_error"] <= error


def test_the_errors_of_a_member_are_those_of_its_own_verified_run() -> None:
    tolerances = {"final": 1e-5, "peak": 1e-5, "half_range": 1e-5}
    result = sweep(vary={"mu": [0.5, 0.7, 0.9]}, t_end=40.0, accuracy=tolerances, outputs=["y_abs"])
    for row in result.rows:
        named = dict(zip(result.columns, row, strict=True))
        member_errors = simulate_to(
            tolerances, Request(System(Parameters(mu=named["mu"])), t_end=40.0)
        ).estimate
        for name in tolerances:
            assert named[f"{name}_error"] == pytest.approx(
                member_errors.of(name), rel=1e-3, abs=1e-14
            )


def test_members_are_refined_until_their_errors_are_met(monkeypatch: pytest.MonkeyPatch) -> None:
    sizes: list[tuple[float, int]] = []

    def record_and_simulate(parameters: Any, **options: Any) -> Any:
        # Count the runs over the full horizon. Shorter ones find out when two runs diverge.
        if options["t_end"] == 1000.0:
            sizes.append((options["tol"], len(parameters["F"])))
        return simulate_batch(parameters, **options)

    monkeypatch.setattr(rows_module, "simulate_batch", record_and_simulate)
    vary = {"F": (20.0, 80.0, 120.0), "c1": (0.0,), "c2": (0.0,)}
    result = sweep(vary=vary, t_end=1000.0, accuracy={"final": 1e-3}, outputs=["x_end"], workers=1)
    errors = [row[result.columns.index("final_error")] for row in result.rows]
    assert [error is None or error <= 1e-3 for error in errors] == [True] * 3
    tols = sorted({tol for tol, _ in sizes}, reverse=True)
    members_by_tol = [sum(size for run_tol, size in sizes if run_tol == tol) for tol in tols]
    assert tols[:2] == pytest.approx([1e-5, 1e-7])
    assert members_by_tol[:2] == [3, 3]
    assert members_by_tol == sorted(members_by_tol, reverse=True)
    # Without damping errors grow along a run, and more than one refinement is needed.
    assert len(tols) > 2


def test_a_member_without_an_error_estimate_gives_the_reason() -> None:
    vary = {"F": (80.0,), "c1": (0.0, 0.32)}
    base = Parameters(c2=0.0)
    result = sweep(base, vary=vary, t_end=300.0, accuracy={"final": 1e-12}, outputs=["y_abs"])
    sensitive = result.rows[0]
    assert sensitive[3:-1] == [None, None, "failed"]
    assert "the error of final is about" in sensitive[-1]
    assert "not 1e-12; allow a larger error" in sensitive[-1]


def test_a_member_whose_runs_diverge_fails_even_if_its_numbers_agree() -> None:
    tolerances, limit = {"half_range": 1.0}, 1000.0
    vary = {"F": (20.0, 80.0), "c1": (0.0, 0.32)}
    result = sweep(vary=vary, t_end=limit, accuracy=tolerances, outputs=["y_half_range"])
    assert [row[-2] for row in result.rows] == ["done"] * 4
    result = sweep(
        Parameters(c2=0.0), vary=vary, t_end=limit, accuracy=tolerances, outputs=["y_abs"]
    )
    for row in result.rows:
        p = Parameters(c2=0.0, F=row[0], c1=row[1])
        try:
            simulate_to(tolerances, Request(System(p), t_end=limit, kernel="compiled"))
        except ComputationError as error:
            match = re.search(r"diverge at t = ([\d.]+) s", error.why)
            row_match = re.search(r"diverge between t = ([\d.]+) and ([\d.]+) s", row[-1])
            assert match is not None
            assert row_match is not None
            # The single run names the first different switch; the row names an eighth of the
            # horizon, at whose end the divergence shows: up to an eighth later.
            assert float(row_match[1]) - 0.125 * limit <= float(match[1]) <= float(row_match[2])
            assert row[-2] == "failed"
        else:
            assert row[-2] == "done"
    assert [row[-2] for row in result.rows].count("failed") >= 1


def test_errors_do_not_depend_on_pieces() -> None:
    study = Study(
        DESIGNS[3], Parameters(), t_end=20.0, accuracy=(("peak", 1e-6),), outputs=("y_abs",)
    )
    complete = compute_rows(study, 0, study.members)
    middle = study.members // 3
    parts = concatenate(
        [compute_rows(study, *ends) for ends in ((0, middle), (middle, study.members))]
    )
    for name, numbers in complete.numbers.items():
        assert numbers.tobytes() == parts.numbers[name].tobytes(), name
    with pytest.raises(Cancelled):
        compute_rows(study, 0, 9, lambda fraction: fraction < 0.5)


UNBOUNDED = Parameters(k2=186.0, k_nl=0.0, mu=2.0)


def test_members_that_fail_are_rows_that_say_why() -> None:
    rows = sweep(
        UNBOUNDED, vary={"F": (20.0,)}, separation="both", t_end=1000.0, outputs=["y_abs"]
    ).rows
    computed, (*_, nothing, status, reason) = rows
    assert computed[2:] == [pytest.approx(4.3063932911, abs=1e-8), "done", ""]
    assert (nothing, status) == (None, "failed")
    assert "grows beyond" in reason
    assert "t = 47" in reason


def test_a_member_without_an_equilibrium_to_start_from_fails_alone() -> None:
    for vary in ({"F": (-1.0, 20.0)}, {"F": (-1.0, 20.0), "y0": (0.5,)}):
        result = sweep(Parameters(k3=0.0), vary=vary, t_end=1.0, outputs=["y_abs", "growth_rate"])
        failed, computed = result.rows
        assert failed[-4:-1] == [None, None, "failed"]
        assert "equilibrium" in failed[-1]
        assert computed[-2] == "done"
        assert result.table.failed == 1


def test_outputs_that_are_not_requested_are_not_computed(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_args: Any, **_options: Any) -> Any:
        raise AssertionError("computed an output that is not requested")

    monkeypatch.setattr(rows_module, "simulate_batch", refuse)
    rows = sweep(vary={"F": (20.0, 120.0)}, outputs=["stable"]).rows
    assert [row[2] for row in rows] == [False, True]
    monkeypatch.undo()
    monkeypatch.setattr(rows_module, "judge_stability", refuse)
    assert len(sweep(vary={"F": (20.0, 120.0)}, outputs=["y_abs"], t_end=1.0).rows) == 2


def test_rows_do_not_depend_on_pieces_or_threads() -> None:
    study = Study(DESIGNS[3], Parameters(), cases=(True, False), t_end=5.0)
    complete = compute_rows(study, 0, study.members)
    parts = concatenate([compute_rows(study, *ends) for ends in ((0, 1), (1, 130), (130, 182))])
    threaded = sweep_in_memory(study, local_engine(3)).table
    for rows in (parts, threaded):
        for name, numbers in complete.numbers.items():
            assert numbers.tobytes() == rows.numbers[name].tobytes(), name
        assert rows.reasons == complete.reasons
        assert np.array_equal(rows.separation, complete.separation)


def test_a_sweep_is_cancelled_by_its_progress() -> None:
    with pytest.raises(Cancelled):
        sweep(
            vary={"F": Range(1.0, 100.0, 50)}, t_end=1.0, progress=lambda fraction: fraction < 0.3
        )
    study = Study(DESIGNS[1], Parameters(), t_end=1.0)
    with pytest.raises(Cancelled):
        compute_rows(study, 0, 9, lambda _fraction: False)


def test_the_progress_of_safe_mu_does_not_fall_from_chunk_to_chunk(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(rows_module, "_CHUNK_MEMBERS", 4)
    study = Study(
        Design({"F": Range(60.0, 100.0, 10)}), Parameters(), outputs=("safe_mu",), t_end=1.0
    )
    fractions: list[float] = []

    def record(fraction: float) -> bool:
        fractions.append(fraction)
        return True

    rows = compute_rows(study, 0, 10, record)
    assert np.isfinite(rows.numbers["safe_mu"]).all()
    assert fractions == sorted(fractions)
    assert sorted({round(fraction, 9) for fraction in fractions}) == [n / 10 for n in range(10)]
    with pytest.raises(Cancelled):
        compute_rows(study, 0, 10, lambda fraction: fraction < 0.5)


def test_the_safe_mu_of_a_sweep_says_that_nothing_beside_the_branch_was_searched(
    capsys: pytest.CaptureFixture[str],
) -> None:
    remark = "safe_mu is the least μ on the branch of limit cycles from the Hopf point"
    assert run(["sweep", "--vary", "F=120", "--output", "safe_mu"]) == 0
    assert remark in capsys.readouterr().err
    assert run(["sweep", "--vary", "F=120", "--output", "critical_mu"]) == 0
    assert remark not in capsys.readouterr().err
    assert OUTPUTS["safe_mu"].meaning == "least μ on the branch from the Hopf point"


def test_sweeps_too_large_for_memory_are_refused() -> None:
    study = Study(Design({"F": Range(1.0, 2.0, 1_000_001)}), Parameters())
    with pytest.raises(InputError, match="--out"):
        check_memory_limit(study)
    check_memory_limit(dataclasses.replace(study, design=Design({"F": Range(1.0, 2.0, 1_000_000)})))


def test_workers_are_one_or_more() -> None:
    with pytest.raises(InputError, match="workers = 0"):
        local_engine(0)


def test_empty_values_are_none() -> None:
    study = Study(Design({"F": (1.0, 2.0)}), Parameters(), outputs=("separations", "stable"))
    rows = Rows(
        {
            "F": np.array([1.0, 2.0]),
            "separations": np.array([3.0, np.nan]),
            "stable": np.array([np.nan, 1.0]),
        },
        np.array([True, True]),
        ("", "why"),
    )
    columns = {column.name: rows.values(column) for column in study.columns}
    assert columns["separations"] == [3, None]
    assert columns["stable"] == [None, True]
    assert columns["status"] == ["done", "failed"]
    assert columns["reason"] == ["", "why"]


def test_the_type_of_kinds_of_design_has_all_kinds() -> None:
    from typing import get_args

    from fivtui.sweeps.design import DESIGN_KINDS

    assert get_args(DesignKind) == tuple(DESIGN_KINDS)


def test_all_rows_of_more_than_one_chunk_have_their_stability() -> None:
    # A chunk is what is computed between two reports of progress.
    count = rows_module._CHUNK_MEMBERS + 8
    design = Design({"F": Range(1.0, 150.0, count)})
    rows = compute_rows(Study(design, Parameters(), outputs=("growth_rate", "stable")), 0, count)
    growth, stable = (rows.numbers[name] for name in ("growth_rate", "stable"))
    assert growth.shape == (count,)
    assert np.isfinite(growth).all()
    assert np.array_equal(stable.astype(bool), growth < 0.0)


# The FMU in Python, and the native one in C.
@pytest.mark.parametrize("method", ["fmu", "fmu-native"])
def test_members_are_runs_of_the_fmu(method: str) -> None:
    outputs = ("y_abs", "vx_max", "P_max", "separations", "x_end", "vy_end", "stable")
    design = Design({"mu": (0.3, 0.9)})
    study = Study(design, Parameters(), (True, False), t_end=3.0, outputs=outputs, method=method)
    result = sweep_in_memory(study, local_engine(2))
    batch = sweep_in_memory(dataclasses.replace(study, method="taylor"), local_engine(2))
    assert result.table.reasons == batch.table.reasons == ("",) * 4
    for name in outputs:
        numbers = result.table.numbers[name]
        assert numbers == pytest.approx(batch.table.numbers[name], rel=1e-8), name
    run = simulate(Parameters(mu=0.9), t_end=3.0, method=method, separation=False)
    final_values = {name: values[-1] for name, values in result.table.numbers.items()}
    assert (final_values["y_abs"], final_values["x_end"]) == (run.peak.y_abs, run.final.x)
    assert (final_values["separations"], final_values["vy_end"]) == (0, run.final.vy)


def test_a_member_that_the_fmu_cannot_compute_has_the_reason() -> None:
    result = sweep(
        Parameters(F=-80.0), vary={"k3": [60.0, 0.0]}, t_end=0.5, method="fmu-native"
    ).table
    assert result.reasons[0] == ""
    assert "no equilibrium" in result.reasons[1]
    assert np.isnan(result.numbers["y_abs"]).tolist() == [False, True]


def test_a_sweep_by_the_fmu_is_stored_with_its_method(tmp_path: Path) -> None:
    out = tmp_path / "rows.csv"
    arguments = ["sweep", "--vary", "F=70,80", "--t-end", "0.5", "--method", "fmu-native"]
    assert run([*arguments, "--out", str(out)]) == 0
    study_read = load_study("sweep", out)
    assert study_read.study.method == "fmu-native"
    assert build_command("sweep", study_read.study).scene["method"] == "fmu-native"
    assert run([*arguments[:-1], "taylor", "--out", str(out)]) == 2


def test_the_fmu_is_refused_where_batches_are_needed() -> None:
    design = Design({"F": (70.0, 80.0)})
    with pytest.raises(InputError, match="method = rk4: must be taylor, fmu, fmu-native"):
        Study(design, Parameters(), method="rk4")
    with pytest.raises(InputError, match="method = fmu: must be taylor for error targets"):
        Study(design, Parameters(), accuracy=(("peak", 1e-3),), method="fmu")
