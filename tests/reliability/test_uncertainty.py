"""Uncertainty studies: against closed forms, stored and continued, on the command line."""

import math
import tomllib
from collections.abc import Generator, Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from msgspec import structs

from fivtui import (
    Parameters,
    Scene,
    find_scene,
    safe_friction,
    simulate,
    stability,
    uncertainty,
)
from fivtui.cli import run
from fivtui.model.errors import Cancelled, ComputationError, InputError
from fivtui.reliability.report import UncertaintyProgress, print_uncertainty, warning_of
from fivtui.reliability.request import (
    check_until,
    parse_inputs,
    scattered_study,
    truncations,
    with_table,
)
from fivtui.reliability.result import Uncertainty, evaluate
from fivtui.reliability.run import MembersFile, compute_uncertainty
from fivtui.reliability.statistics import with_remark
from fivtui.safety.table import safe_mus
from fivtui.scene.files import scene_from_dict
from fivtui.studies import command_of, kind_of, load_study
from fivtui.sweeps import run as run_of_sweeps
from fivtui.sweeps.pieces import SweepPiece
from fivtui.sweeps.rows import Rows
from fivtui.sweeps.run import Engine, local_engine, sweep
from fivtui.sweeps.scatter import Scatter
from fivtui.sweeps.study import Study
from fivtui.tui.tabs.requests.uncertainty import index_remark

MU_C = 0.439387619
FOLD = 0.277876613
BASE = find_scene("base")
VARY = ["mu~uniform:0.2:0.8", "F~normal:80:8"]


def study_of(samples: int = 512, *, outputs: tuple[str, ...] = ("critical_mu",)) -> Study:
    return scattered_study(BASE, parse_inputs(VARY), samples=samples, outputs=outputs)


def check(found: Uncertainty, error: float) -> None:
    for name, least in (("unstable", MU_C), ("squeal_possible", FOLD)):
        told = found.probabilities[name]
        assert told.low <= 1.0 - least <= told.high
        assert told.error < error


def test_the_probabilities_where_friction_is_uniform() -> None:
    found = uncertainty(
        vary={"mu": "uniform:0:1"}, samples=2**17, indices=False, outputs=("safe_mu",)
    )
    check(found, 4e-5)
    assert found.scatter.samples == 2**17


def test_samples_are_one_to_sixteen_million() -> None:
    # Rounded up to a power of two in each of 16 scramblings, each point being a pair.
    limit = 2**24
    for samples, rounded in ((1, 32), (33, 64), (limit, limit)):
        design = study_of(samples).design
        assert isinstance(design, Scatter)
        assert design.samples == rounded
    for samples in (0, -1, limit + 1):
        with pytest.raises(InputError, match=f"samples = {samples}: must be from 1 to {limit}"):
            study_of(samples)


@pytest.mark.parametrize("until", [0.0, -0.1, 1.1, math.nan])
def test_a_wanted_error_is_above_0_and_at_most_1(until: float) -> None:
    with pytest.raises(InputError, match="until"):
        check_until(until)
    assert check_until(1.0) == 1.0
    assert check_until(1e-9) == 1e-9


def drawn(scene: Scene, *inputs: str) -> dict[str, np.ndarray]:
    """Values of the members of a scattered study, by name."""
    study = scattered_study(
        scene, parse_inputs(inputs), samples=256, indices=False, outputs=("critical_mu",)
    )
    return study.design.columns(np.arange(study.members))


def test_scattered_friction_never_exceeds_a_static_friction_that_does_not_scatter() -> None:
    def scene(**values: float) -> Scene:
        return BASE.with_values({"v_belt": 1.0, **values})

    mu = drawn(scene(mu_s=0.75), "mu~normal:0.7:0.1")["mu"]
    assert 0.74 < mu.max() <= 0.75
    assert mu.min() < 0.6
    static = drawn(scene(mu=0.7), "mu_s~normal:0.75:0.1")["mu_s"]
    assert 0.7 <= static.min() < 0.71
    assert static.max() > 0.9
    # Nothing bounds it where static friction is that of sliding.
    assert drawn(scene(), "mu~normal:0.7:0.1")["mu"].max() > 0.9
    # Nor where both scatter.
    both = drawn(scene(), "mu~uniform:0.5:0.65", "mu_s~uniform:0.65:0.9")
    assert both["mu_s"].min() < 0.66
    assert both["mu_s"].max() > 0.89


@pytest.mark.whole
def test_the_probabilities_of_a_million_samples() -> None:
    found = uncertainty(
        vary={"mu": "uniform:0:1"}, samples=10**6, indices=False, outputs=("safe_mu",)
    )
    check(found, 5e-6)


def test_squeal_is_possible_above_the_fold_of_each_sample() -> None:
    # Folds at these preloads are next to the same, critical μ are not.
    vary = {"mu": "uniform:0.2:0.4", "F": "uniform:78:84", "k_nl": "uniform:95:105"}
    found = uncertainty(vary=vary, samples=2048, outputs=("critical_mu", "safe_mu"))
    table = found.study.safe
    assert table is not None
    assert table.groups == ("k_nl",)
    possible = found.probabilities["squeal_possible"]
    assert possible.value == pytest.approx((0.4 - FOLD) / 0.2, abs=2e-3)
    assert set(found.to_dict()["safe_mu"]) == {"folds", "error", "usual_error"}
    assert found.to_dict()["safe_mu_not_known_above"] is None
    # Continued for each sample, where these are few, it is the same.
    few = uncertainty(vary=vary, samples=8, repeats=2, indices=False, outputs=("safe_mu",))
    assert few.study.safe is None
    members = {name: few.sweep.table.numbers[name] for name in vary}
    again = safe_mus(Parameters(), members, np.ones(8, dtype=bool), table)
    np.testing.assert_allclose(few.sweep.table.numbers["safe_mu"], again, atol=1e-9)
    regions = found.regions()
    assert list(regions) == ["no squeal known", "squeals after a knock", "squeals by itself"]
    np.testing.assert_array_equal(sum(each.astype(int) for each in regions.values()), 1)


def test_where_the_search_finds_less_than_continuation_nothing_rests_on_safe_mu(
    capsys: pytest.CaptureFixture[str],
) -> None:
    p = Parameters(m=3.17, k1=255.6, k2=22.84, k3=23.81, c1=0.1849, c2=0.1664, F=49.0, k_nl=19.3)
    found = uncertainty(p, vary={"F": "uniform:48:50"}, outputs=("safe_mu",), samples=64, repeats=4)
    unknown_above = safe_friction(p).safe_mu
    assert unknown_above is not None
    assert found.safe_mu_unknown_above == pytest.approx(unknown_above, rel=1e-3)
    assert found.to_dict()["safe_mu_not_known_above"] == found.safe_mu_unknown_above
    assert set(found.probabilities) == {"unstable"}
    assert "squeal_possible" not in found.indices
    stated = (found.means, found.quantiles, found.indices, found.local)
    assert not any("safe_mu" in numbers for numbers in stated)
    assert list(found.regions()) == ["stable", "squeals by itself"]
    print_uncertainty(found)
    assert "not known above μ = 0.060" in capsys.readouterr().out


def test_the_error_of_the_table_widens_the_interval() -> None:
    study = scattered_study(BASE, parse_inputs(["mu~uniform:0.2:0.4", "F~uniform:79:81"]),
                            samples=1024, outputs=("safe_mu",))  # fmt: skip
    study = with_table(study)
    assert study.safe is not None
    found = compute_uncertainty(study, local_engine(1)).probabilities["squeal_possible"]
    # All folds tried were missed by 0.01: a tenth of the samples is as near.
    wide = replace(study, safe=structs.replace(study.safe, errors=(0.01,)))
    wider = compute_uncertainty(wide, local_engine(1)).probabilities["squeal_possible"]
    assert wider.value == found.value
    assert found.low - wider.low == pytest.approx(0.05, abs=8e-3)
    assert wider.high - found.high == pytest.approx(0.05, abs=8e-3)


def test_what_drives_the_critical_friction_coefficient() -> None:
    base = Parameters().as_dict()
    names = ("k1", "k2", "k3", "c1", "c2", "F", "k_nl")
    found = uncertainty(
        vary={name: f"uniform:{0.9 * base[name]}:{1.1 * base[name]}" for name in names},
        outputs=("critical_mu",),
        samples=4096,
    )
    indices = found.indices["critical_mu"]
    for name, share in (("k1", 0.45), ("F", 0.395), ("k_nl", 0.10), ("k3", 0.05)):
        assert indices[name].first.value == pytest.approx(share, abs=0.03)
    assert sum(index.first.value for index in indices.values()) == pytest.approx(1.0, abs=0.03)


def test_local_sensitivities_stand_beside_the_global_ones() -> None:
    vary = {"mu": "uniform:0.65:0.75", "F": "uniform:79:81", "k_nl": "uniform:99:101"}
    outputs = ("critical_mu", "safe_mu", "y_half_range", "P_max")
    found = uncertainty(vary=vary, samples=512, outputs=outputs, t_end=20.0)
    assert set(found.local) == set(outputs)
    for output in ("critical_mu", "safe_mu"):
        for name, local in found.local[output].items():
            index = found.indices[output][name].first
            assert local.share == pytest.approx(index.value, abs=0.03 + index.error)
    force = found.local["P_max"]["F"]
    assert force.per_sd == pytest.approx(force.derivative / np.sqrt(3.0), rel=1e-3)
    ends = [simulate(Parameters(F=each), t_end=20.0).contact_force.max for each in (79.99, 80.01)]
    assert force.derivative == pytest.approx((ends[1] - ends[0]) / 0.02, rel=1e-3)
    data = found.to_dict()["local"]["y_half_range"]["mu"]
    assert set(data) == {"derivative", "per_sd", "share"}
    started = uncertainty(vary={"y0": "uniform:-1:0"}, samples=64, outputs=("P_max",), t_end=1.0)
    assert started.local == {}


def test_samples_are_members_that_follow_the_distributions() -> None:
    found = uncertainty(vary={"mu": "uniform:0.2:0.8", "F": "normal:80:8"}, samples=1024,
                        outputs=("critical_mu", "P_max"), t_end=1.0)  # fmt: skip
    assert found.samples("F").std() == pytest.approx(8.0, rel=0.02)
    critical, mu, force = (found.samples(name) for name in ("critical_mu", "mu", "F"))
    share = found.probabilities["unstable"].value
    assert share == pytest.approx(np.mean(mu > critical))
    at = stability(Parameters(F=float(force[5]))).critical_mu[0].mu
    assert critical[5] == pytest.approx(at, rel=1e-12)
    assert found.quantiles["P_max"]["0.5"].value == pytest.approx(
        np.median(found.samples("P_max")), rel=0.02
    )
    assert set(found.indices) == {"unstable", "growth_rate", "critical_mu", "P_max"}


def test_correlated_inputs_have_no_sobol_indices() -> None:
    given = {"vary": {"mu": "uniform:0.2:0.8", "F": "normal:80:8"}, "samples": 256}
    pair = {("mu", "F"): -0.5}
    found = uncertainty(**given, correlations=pair, outputs=())  # type: ignore[arg-type]
    assert found.indices == {}
    assert np.corrcoef(found.samples("mu"), found.samples("F"))[0, 1] < -0.4
    with pytest.raises(InputError, match="must be independent, but mu and F are correlated"):
        uncertainty(**given, correlations=pair, indices=True)  # type: ignore[arg-type]


def test_a_table_of_a_scene_correlates(tmp_path: Path) -> None:
    text = Path("examples/uncertainty.md").read_text(encoding="utf-8")
    (block,) = (part.split("```")[0] for part in text.split("```toml\n")[1:])
    scene = scene_from_dict(tomllib.loads(block), name="scene")
    assert scene.correlation == (("mu", "F", -0.4),)
    study = scattered_study(scene, parse_inputs(VARY), samples=64)
    assert study.design.size == 64
    said = command_of("uncertainty", study)
    assert said.arguments[:4] == ["--vary", VARY[0], "--vary", VARY[1]]
    for wrong in ({"mu": 1.0}, {"mu": {"G": 0.1}}, {"mu": {"mu": 0.1}}, {"mu": {"F": 2.0}}):
        with pytest.raises(InputError, match="correlat"):
            scene_from_dict({"fivtui_scene": 1, "correlation": wrong}, name="scene")


def test_truncation_is_told() -> None:
    study = scattered_study(BASE, parse_inputs(["mu~normal:0.1:0.1", "F~normal:80:8"]))
    (words,) = truncations(study)
    assert words.startswith("mu~normal:0.1:0.1: truncated to 0 to 100, which leaves out 0.16")


def counting(engine: Engine, seen: list[int], stop_after: int = 10**9) -> Engine:
    def counted(study: Study, pieces: Iterable[SweepPiece]) -> Generator[tuple[SweepPiece, Rows]]:
        for piece, rows in engine(study, pieces):
            if len(seen) == stop_after:
                raise Cancelled
            seen.append(piece.stop - piece.first)
            yield piece, rows

    return counted


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_a_stopped_study_continues_to_the_same_bytes(suffix: str, tmp_path: Path) -> None:
    whole, stopped = tmp_path / f"whole{suffix}", tmp_path / f"stopped{suffix}"
    study, engine = study_of(), local_engine(1)
    expected = compute_uncertainty(study, engine, file=MembersFile(whole, 100))
    with pytest.raises(Cancelled):
        compute_uncertainty(study, counting(engine, [], 4), file=MembersFile(stopped, 100))
    seen: list[int] = []
    found = compute_uncertainty(study, counting(engine, seen), file=MembersFile(stopped, 100))
    assert sum(seen) == study.members - 400
    assert stopped.read_bytes() == whole.read_bytes()
    assert found.to_dict() == expected.to_dict() == compute_uncertainty(study, engine).to_dict()
    assert kind_of(whole) == "uncertainty"
    assert load_study("uncertainty", whole).to_dict() == expected.to_dict()


def test_samples_are_doubled_until_the_error_is_met(tmp_path: Path) -> None:
    file, engine = MembersFile(tmp_path / "rows.csv", 1000), local_engine(1)
    seen: list[int] = []
    told: list[str] = []
    study = study_of(64)
    found = compute_uncertainty(
        study, counting(engine, seen), until=0.012, file=file,
        on_estimates=lambda _members, words: told.append(words),
    )  # fmt: skip
    assert (
        found.error
        <= 0.012
        < compute_uncertainty(study_of(found.scatter.samples // 2), engine).error
    )
    assert told[-1].startswith("P(unstable) = 0.59")
    # Every member is computed once, but for pieces that the number of samples before had not whole.
    assert sum(seen) <= found.study.members + 1000 * 8
    assert found.to_dict() == compute_uncertainty(found.study, engine).to_dict()
    # What is there already is not computed again, and a smaller error continues from it.
    again: list[int] = []
    assert (
        compute_uncertainty(study, counting(engine, again), until=0.012, file=file).error
        == found.error
    )
    assert again == []
    better = compute_uncertainty(study, counting(engine, again), until=0.006, file=file)
    assert better.error <= 0.006
    assert 0 < sum(again) < better.study.members
    with pytest.raises(InputError, match="exists already"):
        compute_uncertainty(replace(study, t_end=7.0), engine, until=0.012, file=file)


def test_an_error_that_takes_too_many_samples_is_not_met_silently(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(run_of_sweeps, "_MAX_SCATTERED", 3000)
    with pytest.raises(ComputationError, match="with 1024 samples, not 1e-06; allow a larger"):
        compute_uncertainty(study_of(256), local_engine(1), until=1e-6)


def test_progress_says_the_present_estimate(capsys: pytest.CaptureFixture[str]) -> None:
    with UncertaintyProgress(1000) as progress:
        progress._shown = -1e9
        progress.show_estimates(2000, "P(unstable) = 0.5 ± 0.01")
        assert progress(0.25)
    told = capsys.readouterr().err
    assert told == "fivtui: P(unstable) = 0.5 ± 0.01; 500 of 2000 members (25.0%)\n"


def test_hypercubes_are_not_added_to() -> None:
    with pytest.raises(InputError, match="must be given with the design sobol"):
        uncertainty(vary={"mu": "uniform:0:1"}, design="lhs", until=0.1)


def test_a_sweep_that_is_not_scattered_is_no_study() -> None:
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


def test_a_scene_keeps_its_table_of_correlations() -> None:
    scene = Scene(name="a", description="", parameters=Parameters(),
                  correlation=(("mu", "F", 0.5),))  # fmt: skip
    assert scene.with_values({"F": 60.0}).correlation == scene.correlation


def test_an_index_above_1_is_marked_wherever_it_is_shown(
    capsys: pytest.CaptureFixture[str],
) -> None:
    found = uncertainty(vary={"mu": "uniform:0:1"}, samples=128, outputs=("critical_mu",))
    index = found.indices["unstable"]["mu"]
    assert index.first.value > 1.005
    remark = "(above 1: sampling error)"
    print_uncertainty(found)
    assert remark in capsys.readouterr().out
    assert index_remark(found) == ", indices above 1: sampling error"
    assert index_remark(replace(found, indices={})) == ""
    titles = [axes.get_title() for axes in found.figure().subfigs[1].axes]
    assert "beyond 0 to 1: sampling error" in titles[0]
    total = with_remark(f"{index.total.value:.2f}")
    assert ("drives unstable", f"mu {total}") in found._summary()
    # The critical μ does not vary with μ.
    assert "critical_mu" not in found.indices
    assert found.unresolved == {}


def test_what_few_samples_make_up_has_no_indices_and_a_warning() -> None:
    found = uncertainty(vary={"mu": "uniform:0.2:0.441"}, samples=1024, outputs=("critical_mu",))
    assert 0.0 < found.unresolved["unstable"] < 30.0
    assert found.to_dict()["unresolved"] == found.unresolved
    assert "unstable" not in found.indices
    said = warning_of(found)
    assert said is not None
    assert said.endswith("make up the variance of unstable: there are no Sobol indices of it")
    assert warning_of(replace(found, unresolved={})) is None
