"""Sweeps of the share of starts that end in vibration."""

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.stats import binomtest

from fivtui import Design, Parameters, sweep
from fivtui.cli import run
from fivtui.model.errors import Cancelled, InputError
from fivtui.studies import build_command
from fivtui.sweeps import Study, compute_rows, rows as rows_of_sweeps
from fivtui.sweeps.charts import sweep_chart
from fivtui.sweeps.design import parse_design
from fivtui.sweeps.files import read_sweep, save_sweep
from fivtui.sweeps.provenance import study_from_dict, study_to_dict
from fivtui.sweeps.rows import wilson_end
from fivtui.sweeps.run import local_engine, sweep_in_memory, sweep_to_file

SAFE_MU, CRITICAL_MU = 0.277876613, 0.439387619
COLUMNS = ["vibrates", "vibrates_low", "vibrates_high", "undecided"]


def study_of(*mus: float, starts: int | None = 24, seed: int | None = None, **values: Any) -> Study:
    design = Design({"mu": mus}, starts=starts, seed=seed)
    return Study(design, Parameters(), outputs=("vibrates",), **values)


def test_the_share_is_0_below_safe_mu_and_1_above_critical_mu() -> None:
    result = sweep(
        vary={"mu": (0.1, SAFE_MU - 1e-4, 0.3, 0.4, CRITICAL_MU + 1e-4, 0.9)},
        outputs=["vibrates"],
        starts=40,
    )
    assert result.columns == ["mu", "separation", *COLUMNS, "status", "reason"]
    share, low, high, undecided = (result.table.numbers[name] for name in COLUMNS)
    assert share[:2].tolist() == [0.0, 0.0]
    assert share[4:].tolist() == [1.0, 1.0]
    assert 0.0 < share[2] < share[3] < 1.0
    assert undecided.tolist() == [0.0] * 6
    assert np.all((low >= 0.0) & (low <= share) & (share <= high) & (high <= 1.0))


def test_a_single_start_is_that_of_the_scene() -> None:
    # The static start reaches the cycle at F = 120 N, a smaller offset does not.
    for start, share in (("static", 1.0), ((0.1, 0.0, -0.9, 0.0), 0.0)):
        result = sweep(
            Parameters(F=120.0),
            vary={"mu": (0.7,)},
            outputs=["vibrates"],
            start=start,  # type: ignore[arg-type]
        )
        assert result.rows[0][2] == share
    varied = sweep(vary={"y0": (-0.6, 3.0)}, outputs=["vibrates"], parameters=Parameters(mu=0.3))
    assert [row[2] for row in varied.rows] == [0.0, 1.0]


def test_ends_of_the_interval_are_those_of_wilson() -> None:
    for count in (1, 7, 100):
        hits = np.arange(count + 1.0)
        for index, sign in enumerate((-1.0, 1.0)):
            expected = [
                binomtest(int(hit), count).proportion_ci(method="wilson")[index] for hit in hits
            ]
            assert wilson_end(hits, count, sign) == pytest.approx(expected, abs=1e-12)


def test_undecided_starts_are_left_out_of_the_share_and_widen_its_interval(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    flags = np.array([1.0, 1.0, 0.0, math.nan, math.nan, *[math.nan] * 5])
    monkeypatch.setattr(rows_of_sweeps, "vibration_flags", lambda *_args, **_kwargs: flags)
    table = compute_rows(study_of(0.3, 0.4, starts=5), 0, 2)
    share, low, high, undecided = (table.numbers[name].tolist() for name in COLUMNS)
    assert share[0] == pytest.approx(2.0 / 3.0)
    assert low[0] == pytest.approx(binomtest(2, 5).proportion_ci(method="wilson").low)
    assert high[0] == pytest.approx(binomtest(4, 5).proportion_ci(method="wilson").high)
    # Without a decided start there is no share, and its interval has all values.
    assert math.isnan(share[1])
    assert (low[1], high[1]) == (0.0, 1.0)
    assert undecided == [2.0, 5.0]


def test_starts_depend_on_the_seed_and_are_the_same_for_all_members() -> None:
    shares = [compute_rows(study_of(0.3, 0.3, seed=seed), 0, 2).numbers for seed in (0, 0, 1)]
    first, again, other = (numbers["vibrates"].tolist() for numbers in shares)
    assert first == again
    assert first[0] == first[1]
    assert first != other


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_a_stopped_sweep_of_shares_continues_to_the_same_bytes(suffix: str, tmp_path: Path) -> None:
    study, engine = study_of(0.2, 0.3, 0.4, 0.5, cases=(True, False)), local_engine(1)
    complete, stopped = tmp_path / f"complete{suffix}", tmp_path / f"stopped{suffix}"
    sweep_to_file(study, complete, engine, size=3)
    with pytest.raises(Cancelled):
        sweep_to_file(study, stopped, engine, size=1, progress=lambda fraction: fraction < 0.3)
    sweep_to_file(study, stopped, engine, size=1)
    assert stopped.read_bytes() == complete.read_bytes()
    result = read_sweep(complete)
    assert result.study == study
    assert result.rows == sweep_in_memory(study, engine).rows
    again = tmp_path / f"again{suffix}"
    save_sweep(result, again)
    assert again.read_bytes() == complete.read_bytes()


def test_a_study_with_starts_has_a_command_that_computes_it() -> None:
    study = study_of(0.2, 0.3, seed=7)
    assert study_from_dict(study_to_dict(study)) == study
    arguments = build_command("sweep", study).arguments
    assert arguments[-2:] == ["--output", "undecided"]
    options = dict(zip(arguments[::2], arguments[1::2], strict=True))
    assert (options["--starts"], options["--seed"]) == ("24", "7")
    assert parse_design(["mu=0.2,0.3"], "product", seed=7, starts=24) == study.design


def test_a_member_without_equilibrium_fails_with_the_reason() -> None:
    for starts in (None, 5):
        study = replace(study_of(0.3, starts=starts), parameters=Parameters(F=-80.0, k3=0.0))
        table = compute_rows(study, 0, 1)
        assert table.reasons[0].startswith("no equilibrium: F = -80 N")
        assert all(math.isnan(table.numbers[name][0]) for name in study.outputs)


def test_unbounded_growth_is_vibration_although_its_transient_fails() -> None:
    p = Parameters(k_nl=0.0, mu=2.0)
    result = sweep(
        p, vary={"F": (80.0,)}, separation=False, t_end=1e5, outputs=["y_abs", "vibrates"]
    )
    assert result.rows[0][2:4] == [None, 1.0]
    assert "grows" in result.rows[0][5]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"starts": 0}, "starts = 0: must be from 1 to 100000"),
        ({"starts": 5, "seed": -1}, "seed = -1: must be from 0"),
        ({"seed": 1}, "count and seed must not be given for the design product"),
        ({"starts": 5, "method": "fmu"}, "vibrates: must be left out with method = fmu"),
        ({"over_time": {"F": [(0.0, 1.0), (1.0, 2.0)]}}, "vibrates: must be left out, as F over"),
    ],
)
def test_wrong_requests_are_refused(change: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        sweep(vary={"mu": (0.2, 0.3)}, **{"outputs": ["vibrates"], **change})


def test_the_chart_has_the_interval_and_lines_at_critical_and_safe_mu() -> None:
    result = sweep(vary={"mu": (0.2, 0.3, 0.5)}, outputs=["vibrates"], starts=10)
    chart = sweep_chart(result)
    assert [trace.role for trace in chart.traces] == [
        "output, considered",
        "limit, considered",
        "limit, considered",
    ]
    for name, trace in zip(COLUMNS, chart.traces, strict=False):
        assert trace.y.tolist() == result.table.numbers[name].tolist()
    assert [guide.value for guide in chart.guides] == pytest.approx([CRITICAL_MU, SAFE_MU])
    assert [guide.label for guide in chart.guides] == ["μ_c 0.4394", "cycles from 0.2779"]
    # No lines at μ where another quantity varies, and none that do not exist.
    forces = sweep(vary={"F": (60.0, 80.0)}, outputs=["vibrates"], starts=2)
    assert sweep_chart(forces).guides == ()
    # On a belt of finite speed there is no safe μ.
    belt = Parameters(v_belt=2.0)
    on_belt = sweep(belt, vary={"mu": (0.2, 0.4)}, outputs=["vibrates"], starts=2)
    assert [guide.role for guide in sweep_chart(on_belt).guides] == ["critical"]
    linear = sweep(
        Parameters(k_nl=0.0, k2=1e-6), vary={"mu": (0.2, 0.5)}, separation=False,
        outputs=["vibrates"], starts=2,
    )  # fmt: skip
    assert all(math.isfinite(guide.value) for guide in sweep_chart(linear).guides)


def test_the_command_line_gives_shares_as_table_json_and_plot(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    line = ["sweep", "--vary", "mu=0.2:0.5:4", "--output", "vibrates", "--starts", "8"]
    plot = tmp_path / "shares.svg"
    assert run([*line, "--json", "--plot", str(plot)]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["columns"][2:6] == COLUMNS
    assert [row[2] for row in data["rows"]][::3] == [0.0, 1.0]
    assert plot.stat().st_size > 0
    assert run(line) == 0
    assert "vibrates_low" in capsys.readouterr().out
