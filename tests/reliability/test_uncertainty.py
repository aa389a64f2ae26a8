"""Uncertainty studies: against closed forms, stored and continued, on the command line."""

import json
import math
import shlex
import tomllib
from collections.abc import Generator, Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from msgspec import structs

from fivtui import (
    Parameters,
    Scene,
    find_scene,
    load_scene,
    safe_friction,
    simulate,
    stability,
    uncertainty,
)
from fivtui.cli import run
from fivtui.model.errors import Cancelled, ComputationError, InputError
from fivtui.orbits import Explorer
from fivtui.reliability.report import UncertaintyProgress, print_uncertainty, study_warning
from fivtui.reliability.request import (
    add_safe_table,
    check_until,
    parse_inputs,
    scattered_study,
    truncated_distribution_warnings,
)
from fivtui.reliability.result import Uncertainty, evaluate
from fivtui.reliability.run import MembersFile, compute_uncertainty
from fivtui.reliability.statistics import mark_sampling_error
from fivtui.safety.table import safe_mus
from fivtui.scene.files import scene_from_dict
from fivtui.studies import build_command, kind_of, load_study
from fivtui.sweeps import rows as rows_of_sweeps, run as run_of_sweeps
from fivtui.sweeps.pieces import SweepPiece
from fivtui.sweeps.rows import Rows
from fivtui.sweeps.run import Engine, local_engine, sweep
from fivtui.sweeps.scatter import Scatter
from fivtui.sweeps.study import Study
from fivtui.tui.session.command_lines import study_command
from fivtui.tui.session.editing import Editing
from fivtui.tui.tabs.studies.uncertainty import UncertaintyPane, index_remark

# Critical and safe friction coefficient of the base set. Safe μ is the least μ of a limit cycle:
# between the two a stable equilibrium and a limit cycle coexist.
CRITICAL_MU = 0.439387619
SAFE_MU = 0.277876613
BASE = find_scene("base")
VARY = ["mu~uniform:0.2:0.8", "F~normal:80:8"]


def scene_study(samples: int = 512, *, outputs: tuple[str, ...] = ("critical_mu",)) -> Study:
    return scattered_study(BASE, parse_inputs(VARY), samples=samples, outputs=outputs)


def check_probabilities(result: Uncertainty, error: float) -> None:
    for name, threshold in (("unstable", CRITICAL_MU), ("squeal_possible", SAFE_MU)):
        probability = result.probabilities[name]
        assert probability.low <= 1.0 - threshold <= probability.high
        assert probability.error < error


def test_probabilities_for_uniform_friction_agree_with_critical_and_safe_mu() -> None:
    result = uncertainty(
        vary={"mu": "uniform:0:1"}, samples=2**17, indices=False, outputs=("safe_mu",)
    )
    check_probabilities(result, 4e-5)
    assert result.scatter.samples == 2**17


def test_samples_are_one_to_sixteen_million() -> None:
    # A study for Sobol indices has two samples per point, and 16 scramblings: at least 32 samples.
    # The number of points in a scrambling is rounded up to a power of two.
    limit = 2**24
    for samples, rounded in ((1, 32), (33, 64), (limit, limit)):
        design = scene_study(samples).design
        assert isinstance(design, Scatter)
        assert design.samples == rounded
    wrong: list[Any] = [0, -1, limit + 1, 10.5]
    for samples in wrong:
        allowed = "must be a whole number from 1 to"
        with pytest.raises(InputError, match=f"samples = {samples}: {allowed} {limit}"):
            scene_study(samples)


@pytest.mark.parametrize("until", [0.0, -0.1, 1.1, math.nan])
def test_a_required_error_is_above_0_and_at_most_1(until: float) -> None:
    with pytest.raises(InputError, match="until"):
        check_until(until)
    assert check_until(1.0) == 1.0
    assert check_until(1e-9) == 1e-9


def draw_values(scene: Scene, *inputs: str) -> dict[str, np.ndarray]:
    """Values of the members of a scattered study, by name."""
    study = scattered_study(
        scene, parse_inputs(inputs), samples=256, indices=False, outputs=("critical_mu",)
    )
    return study.design.columns(np.arange(study.members))


def test_scattered_friction_never_exceeds_a_static_friction_that_does_not_scatter() -> None:
    def scene(**values: float) -> Scene:
        # Static friction acts only if the slider can stick to the belt, which needs a belt speed.
        return BASE.with_values({"v_belt": 1.0, **values})

    mu = draw_values(scene(mu_s=0.75), "mu~normal:0.7:0.1")["mu"]
    assert 0.74 < mu.max() <= 0.75
    assert mu.min() < 0.6
    static_friction = draw_values(scene(mu=0.7), "mu_s~normal:0.75:0.1")["mu_s"]
    assert 0.7 <= static_friction.min() < 0.71
    assert static_friction.max() > 0.9
    # Without a separate static friction there is no upper bound of mu.
    assert draw_values(scene(), "mu~normal:0.7:0.1")["mu"].max() > 0.9
    # There is no bound either where both scatter.
    both = draw_values(scene(), "mu~uniform:0.5:0.65", "mu_s~uniform:0.65:0.9")
    assert both["mu_s"].min() < 0.66
    assert both["mu_s"].max() > 0.89


@pytest.mark.whole
def test_the_probabilities_of_a_million_samples() -> None:
    result = uncertainty(
        vary={"mu": "uniform:0:1"}, samples=10**6, indices=False, outputs=("safe_mu",)
    )
    check_probabilities(result, 1e-5)


def test_squeal_is_possible_above_the_safe_mu_of_each_sample() -> None:
    # At these preloads safe μ hardly varies, while critical μ does.
    vary = {"mu": "uniform:0.2:0.4", "F": "uniform:78:84", "k_nl": "uniform:95:105"}
    result = uncertainty(vary=vary, samples=2048, outputs=("critical_mu", "safe_mu"))
    # The table interpolates safe μ over the dimensionless groups of parameters that vary. F and
    # k_nl influence it only through k_nl F²/k1³, the group named after k_nl.
    table = result.study.safe
    assert table is not None
    assert table.groups == ("k_nl",)
    possible = result.probabilities["squeal_possible"]
    assert possible.value == pytest.approx((0.4 - SAFE_MU) / 0.2, abs=2e-3)
    # Folds are values of safe μ computed by continuation. Errors are those of the table at further
    # folds: the greatest, and the 95 % quantile.
    assert set(result.to_dict()["safe_mu"]) == {"folds", "error", "usual_error"}
    assert result.to_dict()["safe_mu_not_known_above"] is None
    # For few samples safe μ comes from a continuation per sample and must agree.
    small_study = uncertainty(vary=vary, samples=8, repeats=2, indices=False, outputs=("safe_mu",))
    assert small_study.study.safe is None
    members = {name: small_study.sweep.table.numbers[name] for name in vary}
    interpolated = safe_mus(Parameters(), members, np.ones(8, dtype=bool), table)
    np.testing.assert_allclose(small_study.sweep.table.numbers["safe_mu"], interpolated, atol=1e-9)
    regions = result.regions()
    assert list(regions) == ["no squeal known", "squeals after a knock", "squeals by itself"]
    np.testing.assert_array_equal(sum(region.astype(int) for region in regions.values()), 1)


def test_results_of_safe_mu_are_left_out_if_the_global_search_finds_a_lower_one(
    capsys: pytest.CaptureFixture[str],
) -> None:
    p = Parameters(m=3.17, k1=255.6, k2=22.84, k3=23.81, c1=0.1849, c2=0.1664, F=49.0, k_nl=19.3)
    result = uncertainty(
        p, vary={"F": "uniform:48:50"}, outputs=("safe_mu",), samples=64, repeats=4
    )
    unknown_above = safe_friction(p).safe_mu
    assert unknown_above is not None
    assert result.safe_mu_unknown_above == pytest.approx(unknown_above, rel=1e-3)
    assert result.to_dict()["safe_mu_not_known_above"] == result.safe_mu_unknown_above
    assert set(result.probabilities) == {"unstable"}
    assert "squeal_possible" not in result.indices
    reported = (result.means, result.quantiles, result.indices, result.local)
    assert not any("safe_mu" in numbers for numbers in reported)
    assert list(result.regions()) == ["stable", "squeals by itself"]
    print_uncertainty(result)
    assert "not known above μ = 0.060" in capsys.readouterr().out


def test_the_error_of_the_table_widens_the_interval() -> None:
    study = scattered_study(BASE, parse_inputs(["mu~uniform:0.2:0.4", "F~uniform:79:81"]),
                            samples=1024, outputs=("safe_mu",))  # fmt: skip
    study = add_safe_table(study)
    assert study.safe is not None
    estimated = compute_uncertainty(study, local_engine(1)).probabilities["squeal_possible"]
    # With errors of 0.01 in safe μ, the samples within them are 0.02/0.2 of all, for μ is uniform
    # over a range of 0.2. Half of these widen each side of the interval.
    study_with_errors = replace(study, safe=structs.replace(study.safe, errors=(0.01,)))
    widened = compute_uncertainty(study_with_errors, local_engine(1)).probabilities[
        "squeal_possible"
    ]
    assert widened.value == estimated.value
    assert estimated.low - widened.low == pytest.approx(0.05, abs=8e-3)
    assert widened.high - estimated.high == pytest.approx(0.05, abs=8e-3)


def test_four_inputs_explain_the_critical_friction_coefficient() -> None:
    base = Parameters().as_dict()
    names = ("k1", "k2", "k3", "c1", "c2", "F", "k_nl")
    result = uncertainty(
        vary={name: f"uniform:{0.9 * base[name]}:{1.1 * base[name]}" for name in names},
        outputs=("critical_mu",),
        samples=4096,
    )
    indices = result.indices["critical_mu"]
    for name, share in (("k1", 0.45), ("F", 0.395), ("k_nl", 0.10), ("k3", 0.05)):
        assert indices[name].first.value == pytest.approx(share, abs=0.03)
    assert sum(index.first.value for index in indices.values()) == pytest.approx(1.0, abs=0.03)


def test_local_sensitivities_agree_with_sobol_indices_and_differences() -> None:
    vary = {"mu": "uniform:0.65:0.75", "F": "uniform:79:81", "k_nl": "uniform:99:101"}
    outputs = ("critical_mu", "safe_mu", "y_half_range", "P_max")
    result = uncertainty(vary=vary, samples=512, outputs=outputs, t_end=20.0)
    assert set(result.local) == set(outputs)
    for output in ("critical_mu", "safe_mu"):
        for name, local in result.local[output].items():
            index = result.indices[output][name].first
            assert local.share == pytest.approx(index.value, abs=0.03 + index.error)
    force = result.local["P_max"]["F"]
    force_sd = 1.0 / np.sqrt(3.0)  # of the uniform distribution from 79 to 81 N
    assert force.per_sd == pytest.approx(force.derivative * force_sd, rel=1e-3)
    forces = [
        simulate(Parameters(F=preload), t_end=20.0).contact_force.max for preload in (79.99, 80.01)
    ]
    assert force.derivative == pytest.approx((forces[1] - forces[0]) / 0.02, rel=1e-3)
    data = result.to_dict()["local"]["y_half_range"]["mu"]
    assert set(data) == {"derivative", "per_sd", "share"}
    start_study = uncertainty(
        vary={"y0": "uniform:-1:0"}, samples=64, outputs=("P_max",), t_end=1.0
    )
    assert start_study.local == {}


def test_samples_follow_the_distributions() -> None:
    result = uncertainty(vary={"mu": "uniform:0.2:0.8", "F": "normal:80:8"}, samples=1024,
                        outputs=("critical_mu", "P_max"), t_end=1.0)  # fmt: skip
    assert result.samples("F").std() == pytest.approx(8.0, rel=0.02)
    critical, mu, force = (result.samples(name) for name in ("critical_mu", "mu", "F"))
    share = result.probabilities["unstable"].value
    assert share == pytest.approx(np.mean(mu > critical))
    expected = stability(Parameters(F=float(force[5]))).critical_mu[0].mu
    assert critical[5] == pytest.approx(expected, rel=1e-12)
    assert result.quantiles["P_max"]["0.5"].value == pytest.approx(
        np.median(result.samples("P_max")), rel=0.02
    )
    assert set(result.indices) == {"unstable", "growth_rate", "critical_mu", "P_max"}


def test_correlated_inputs_have_no_sobol_indices() -> None:
    settings = {"vary": {"mu": "uniform:0.2:0.8", "F": "normal:80:8"}, "samples": 256}
    pair = {("mu", "F"): -0.5}
    result = uncertainty(**settings, correlations=pair, outputs=())  # type: ignore[arg-type]
    assert result.indices == {}
    assert np.corrcoef(result.samples("mu"), result.samples("F"))[0, 1] < -0.4
    with pytest.raises(InputError, match="must be independent, but mu and F are correlated"):
        uncertainty(**settings, correlations=pair, indices=True)  # type: ignore[arg-type]


def test_a_scene_file_can_correlate_inputs(tmp_path: Path) -> None:
    text = Path("docs/how-to/uncertainty.md").read_text(encoding="utf-8")
    (block,) = (part.split("```")[0] for part in text.split("```{file} correlated.toml\n")[1:])
    scene = scene_from_dict(tomllib.loads(block), name="scene")
    assert scene.correlation == (("mu", "F", -0.4),)
    study = scattered_study(scene, parse_inputs(VARY), samples=64)
    assert study.design.size == 64
    command = build_command("uncertainty", study)
    assert command.arguments[:4] == ["--vary", VARY[0], "--vary", VARY[1]]
    for wrong in ({"mu": 1.0}, {"mu": {"G": 0.1}}, {"mu": {"mu": 0.1}}, {"mu": {"F": 2.0}}):
        with pytest.raises(InputError, match="correlat"):
            scene_from_dict({"fivtui_scene": 1, "correlation": wrong}, name="scene")


def test_truncation_is_reported() -> None:
    study = scattered_study(BASE, parse_inputs(["mu~normal:0.1:0.1", "F~normal:80:8"]))
    (message,) = truncated_distribution_warnings(study)
    assert message.startswith("mu~normal:0.1:0.1: truncated to 0 to 100, which leaves out 0.16")


def counting_engine(engine: Engine, sizes: list[int], stop_after: int = 10**9) -> Engine:
    """An engine that records the sizes of computed pieces, and cancels after some pieces.

    An engine is a function that computes pieces of a study, which are blocks of members.
    """

    def count_pieces(
        study: Study, pieces: Iterable[SweepPiece]
    ) -> Generator[tuple[SweepPiece, Rows]]:
        for piece, rows in engine(study, pieces):
            if len(sizes) == stop_after:
                raise Cancelled
            sizes.append(piece.stop - piece.first)
            yield piece, rows

    return count_pieces


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_a_stopped_study_continues_to_the_same_bytes(suffix: str, tmp_path: Path) -> None:
    complete, stopped = tmp_path / f"complete{suffix}", tmp_path / f"stopped{suffix}"
    study, engine = scene_study(), local_engine(1)
    expected = compute_uncertainty(study, engine, file=MembersFile(complete, 100))
    with pytest.raises(Cancelled):
        compute_uncertainty(study, counting_engine(engine, [], 4), file=MembersFile(stopped, 100))
    sizes: list[int] = []
    result = compute_uncertainty(
        study, counting_engine(engine, sizes), file=MembersFile(stopped, 100)
    )
    assert sum(sizes) == study.members - 400
    assert stopped.read_bytes() == complete.read_bytes()
    assert result.to_dict() == expected.to_dict() == compute_uncertainty(study, engine).to_dict()
    assert kind_of(complete) == "uncertainty"
    assert load_study("uncertainty", complete).to_dict() == expected.to_dict()


def test_samples_are_doubled_until_the_error_is_met(tmp_path: Path) -> None:
    piece_size = 1000
    file, engine = MembersFile(tmp_path / "rows.csv", piece_size), local_engine(1)
    sizes: list[int] = []
    messages: list[str] = []
    study = scene_study(64)
    result = compute_uncertainty(
        study, counting_engine(engine, sizes), until=0.012, file=file,
        on_estimates=lambda _members, message: messages.append(message),
    )  # fmt: skip
    assert (
        result.error
        <= 0.012
        < compute_uncertainty(scene_study(result.scatter.samples // 2), engine).error
    )
    assert messages[-1].startswith("P(unstable) = 0.59")
    # Members are computed once, except those of the incomplete piece at the end of each stage. The
    # samples are doubled at most 8 times.
    assert sum(sizes) <= result.study.members + 8 * piece_size
    assert result.to_dict() == compute_uncertainty(result.study, engine).to_dict()
    # Existing members are not computed again; a smaller target error continues from them.
    new_sizes: list[int] = []
    assert (
        compute_uncertainty(study, counting_engine(engine, new_sizes), until=0.012, file=file).error
        == result.error
    )
    assert new_sizes == []
    better = compute_uncertainty(study, counting_engine(engine, new_sizes), until=0.006, file=file)
    assert better.error <= 0.006
    assert 0 < sum(new_sizes) < better.study.members
    with pytest.raises(InputError, match="exists already"):
        compute_uncertainty(replace(study, t_end=7.0), engine, until=0.012, file=file)


def test_an_error_that_needs_too_many_samples_is_refused(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(run_of_sweeps, "_MAX_SCATTERED", 3000)
    with pytest.raises(ComputationError, match="with 1024 samples, not 1e-06; allow a larger"):
        compute_uncertainty(scene_study(256), local_engine(1), until=1e-6)


def test_progress_shows_the_present_estimate(capsys: pytest.CaptureFixture[str]) -> None:
    with UncertaintyProgress(1000) as progress:
        # As if no line had been printed for long: the next estimate is printed at once.
        progress._printed_s = -1e9
        progress.show_estimates(2000, "P(unstable) = 0.5 ± 0.01")
        assert progress(0.25)
    messages = capsys.readouterr().err
    assert messages == "fivtui: P(unstable) = 0.5 ± 0.01; 500 of 2000 members (25.0%)\n"


def test_more_samples_restart_the_measured_rate() -> None:
    with UncertaintyProgress(1000) as progress:
        progress(0.5)
        progress.show_estimates(1000, "the same number")
        assert progress._start is not None
        progress.show_estimates(2000, "twice the number")
        assert progress._start is None


def test_latin_hypercubes_cannot_be_extended() -> None:
    with pytest.raises(InputError, match="must be given with the design sobol"):
        uncertainty(vary={"mu": "uniform:0:1"}, design="lhs", until=0.1)


def test_a_sweep_that_is_not_scattered_is_refused() -> None:
    with pytest.raises(InputError, match="not scattered"):
        evaluate(sweep(vary={"F": [20.0]}, outputs=["stable"]))


def test_a_correlated_scene_says_why_there_are_no_indices(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    path = tmp_path / "scene.toml"
    path.write_text("fivtui_scene = 1\ncorrelation.mu.F = 0.5\n", encoding="utf-8")
    line = ["uncertainty", str(path), "--vary", VARY[0], "--vary", VARY[1], "--samples", "64"]
    assert run([*line, "--output", "critical_mu"]) == 0
    assert "inputs are correlated: no Sobol indices" in capsys.readouterr().err
    assert run([*line, "--indices"]) == 2
    assert "must be independent" in capsys.readouterr().err


def scattered_scene(folder: Path, text: str = "") -> Path:
    """A scene file that scatters mu and F."""
    path = folder / "scattered.toml"
    lines = "fivtui_scene = 1\n[scatter]\nmu = 'normal:0.42:0.01'\nF = 'uniform:78:82'\n"
    path.write_text(lines + text, encoding="utf-8")
    return path


def test_a_scene_gives_its_distributions_and_vary_adds_or_replaces(tmp_path: Path) -> None:
    scene = load_scene(scattered_scene(tmp_path))
    study = scattered_study(scene, {}, samples=64)
    assert {name: str(axis) for name, axis in study.design.axes.items()} == {
        "mu": "normal:0.42:0.01",
        "F": "uniform:78:82",
    }
    inputs = parse_inputs(["mu~uniform:0.1:0.2", "k_nl~normal:100:5"])
    changed = scattered_study(scene, inputs, samples=64).design.axes
    assert {name: str(axis) for name, axis in changed.items()} == {
        "mu": "uniform:0.1:0.2",
        "F": "uniform:78:82",
        "k_nl": "normal:100:5",
    }


def test_the_command_line_takes_the_distributions_of_the_scene(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    scene = str(scattered_scene(tmp_path, "[correlation]\nmu.F = -0.5\n"))
    line = ["uncertainty", scene, "--samples", "64", "--output", "critical_mu", "--json"]
    assert run([*line, "--set", "mu=0.3"]) == 0
    out, err = capsys.readouterr()
    data = json.loads(out)
    assert data["inputs"] == {"mu": "normal:0.42:0.01", "F": "uniform:78:82"}
    assert data["correlations"] == [["mu", "F", -0.5]]
    assert "--set mu has no effect: mu varies" in err
    assert run(["uncertainty", "--samples", "64"]) == 2
    message = capsys.readouterr().err
    assert "--vary NAME~DISTRIBUTION" in message
    assert "[scatter]" in message


def test_a_shown_command_does_not_scatter_what_its_scene_scatters_besides(tmp_path: Path) -> None:
    path = scattered_scene(tmp_path)
    scene = load_scene(path)
    origin = Editing(scene, str(path))
    command = study_command("uncertainty", scattered_study(scene, {}, samples=64), origin)
    assert shlex.split(command)[1:5] == ["uncertainty", str(path), "--vary", "mu~normal:0.42:0.01"]
    # The file would also scatter F.
    only_mu = UncertaintyPane.parse(scene, "mu~normal:0.42:0.01")
    command = study_command("uncertainty", only_mu, origin)
    assert shlex.split(command)[1:4] == ["uncertainty", "--vary", "mu~normal:0.42:0.01"]


def test_the_probability_of_vibration_is_that_of_mu_above_a_threshold() -> None:
    # From the static start the base scene vibrates above a μ between safe and critical μ.
    result = uncertainty(vary={"mu": "uniform:0.2:0.6"}, samples=512, outputs=["vibrates"])
    vibrates = result.probabilities["vibrates"]
    mu, flags = result.samples("mu"), result.samples("vibrates")
    assert SAFE_MU < mu[flags == 1.0].min() < CRITICAL_MU
    assert mu[flags == 0.0].max() < mu[flags == 1.0].min()
    assert vibrates.value > result.probabilities["unstable"].value
    assert vibrates.low < np.mean(flags) < vibrates.high
    assert result.missing == {}
    assert result.indices["vibrates"]["mu"].total.value > 0.9
    assert "vibrates" not in result.quantiles


def test_undecided_members_widen_the_interval_and_are_reported(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def flags_of(explorers: Sequence[Explorer], *_args: object, **_kwargs: object) -> np.ndarray:
        mus = np.array([explorer.system.parameters.mu for explorer in explorers])
        return np.where(mus < 0.3, 0.0, np.where(mus < 0.4, np.nan, 1.0))

    monkeypatch.setattr(rows_of_sweeps, "vibration_flags", flags_of)
    study = scattered_study(
        BASE, parse_inputs(["mu~uniform:0.2:0.6"]), samples=256, indices=False,
        outputs=("vibrates",),
    )  # fmt: skip
    result = compute_uncertainty(study, local_engine(1))
    estimate = result.probabilities["vibrates"]
    assert estimate.value == pytest.approx(2.0 / 3.0, abs=0.01)
    # All undecided members at rest, and all vibrating.
    assert estimate.low == pytest.approx(0.5, abs=0.02)
    assert estimate.low < 0.5
    assert estimate.high == pytest.approx(0.75, abs=0.02)
    assert estimate.high > 0.75
    assert result.missing == {"vibrates": 64}
    assert result.to_dict()["missing"] == {"vibrates": 64}
    assert str(study_warning(result)).startswith("64 members are undecided between rest and")
    print_uncertainty(result)
    assert "the run ends in vibration" in capsys.readouterr().out
    with pytest.raises(ComputationError, match="64 of 256 members are undecided"):
        compute_uncertainty(study, local_engine(1), until=0.01)


def test_a_scene_keeps_its_table_of_correlations() -> None:
    scene = Scene(name="a", description="", parameters=Parameters(),
                  correlation=(("mu", "F", 0.5),))  # fmt: skip
    assert scene.with_values({"F": 60.0}).correlation == scene.correlation


def test_an_index_above_1_is_marked_wherever_it_is_shown(
    capsys: pytest.CaptureFixture[str],
) -> None:
    result = uncertainty(vary={"mu": "uniform:0:1"}, samples=128, outputs=("critical_mu",))
    index = result.indices["unstable"]["mu"]
    assert index.first.value > 1.005
    remark = "(above 1: sampling error)"
    print_uncertainty(result)
    assert remark in capsys.readouterr().out
    assert index_remark(result) == ", indices above 1: sampling error"
    assert index_remark(replace(result, indices={})) == ""
    titles = [axes.get_title() for axes in result.figure().subfigs[1].axes]
    assert "beyond 0 to 1: sampling error" in titles[0]
    total = mark_sampling_error(f"{index.total.value:.2f}")
    assert ("drives unstable", f"mu {total}") in result._summary()
    # The critical μ does not vary with μ.
    assert "critical_mu" not in result.indices
    # No output lacks indices because of too few samples.
    assert result.unresolved == {}


def test_outputs_of_few_samples_have_a_warning_instead_of_indices() -> None:
    # The range ends just above the critical μ, so that few samples are unstable.
    result = uncertainty(vary={"mu": "uniform:0.2:0.441"}, samples=1024, outputs=("critical_mu",))
    assert 0.0 < result.unresolved["unstable"] < 30.0
    assert result.to_dict()["unresolved"] == result.unresolved
    assert "unstable" not in result.indices
    warning = study_warning(result)
    assert warning is not None
    assert warning.endswith("make up the variance of unstable: there are no Sobol indices of it")
    assert study_warning(replace(result, unresolved={})) is None
