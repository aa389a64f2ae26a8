"""The paper's claims and their verdicts.

Claims have the ids of `fivtui/paper/claims/statements.toml`, which states them in full. Words in
ids: "ignored" and "considered" refer to separation. "cases" are motions with separation considered
(Case 1) and ignored (Case 2). "example" is the base set, and "1-2" is μ = 1.2.
"""

import dataclasses
import json
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fivtui.model.errors import Cancelled, InputError
from fivtui.paper.amplitudes import Amplitude
from fivtui.paper.claims import stability, vibration
from fivtui.paper.claims.check import (
    CLAIMS,
    check_claims,
    claims,
    claims_to_list,
    claims_to_stored,
    stored_claims,
)
from fivtui.paper.claims.claim import CheckedClaim, Claim, Verdict, check
from fivtui.paper.claims.report import claims_markdown, print_claims
from fivtui.paper.claims.trends import crossing, falls, falls_then_rises, rises
from fivtui.paper.results import PaperResults
from fivtui.scene.scene import Scene
from tests.cli.test_cli import run_fivtui

DO_NOT_HOLD = {
    "reattachment-at-the-static-position",
    "stabilised-at-1-2",
    "stable-returns-to-equilibrium",
    "critical-friction-of-the-example",
    "separations-are-short",
}
NOT_TESTABLE = {"impact-matters-little", "flexible-belt-matters", "simple-models-under-predict"}
HOLD = {
    "proportional-damping",
    "contact-means-negative-y",
    "reattachment-without-force",
    "one-real-equilibrium",
    "equilibrium-sinks-with-preload",
    "stiffness-resists-displacement",
    "no-preload-no-displacement",
    "preload-brings-stiffness-into-the-jacobian",
    "one-critical-friction",
    "frequencies-merge",
    "critical-friction-falls-at-small-preload",
    "below-linear-at-small-preload",
    "critical-friction-rises-at-large-preload",
    "strong-nonlinearity-above-linear",
    "weak-nonlinearities-below-linear",
    "no-coalescence",
    "one-real-part-passes-zero",
    "preload-destabilises-then-stabilises",
    "stiffness-destabilises-then-stabilises",
    "preload-leaves-the-linear-system",
    "preload-destabilises-at-first",
    "preload-stabilises-later",
    "preload-stabilises-beyond-linear",
    "same-trend-with-other-damping",
    "stiffness-needs-preload",
    "stiffness-destabilises-at-first",
    "stiffness-stabilises-at-large-preload",
    "small-preload-stays-below-linear",
    "linear-unstable-at-1-2",
    "soft-horizontal-more-stable",
    "soft-horizontal-monotonic",
    "linear-contact-unbounded",
    "stable-seldom-separates",
    "ignored-contact-force-becomes-negative",
    "contact-force-falls-to-zero-repeatedly",
    "no-force-off-the-belt",
    "stretched-spring-holds-back",
    "separation-changes-both-motions",
    "vibration-asymmetric",
    "contact-force-asymmetric",
    "separation-under-preload",
    "reattachment-follows-separation",
    "separation-under-large-preload",
    "figures-show-unstable-motion",
    "ignored-barely-depends-on-preload",
    "considered-grows-with-preload",
    "cases-cross-along-preload",
    "same-trends-with-stronger-nonlinearity",
    "stronger-nonlinearity-crosses-sooner",
    "ignoring-separation-underestimates",
    "ignored-falls-with-stiffness",
    "considered-grows-with-stiffness",
    "cases-cross-along-stiffness",
    # The amplitude of Case 1 is greater than that of Case 2 at F = 60 N.
    "greater-even-at-small-stiffness",
    "amplitude-depends-on-preload",
    # Along k_nl the amplitudes of both cases change in opposite directions.
    "opposite-trends",
}


def equal_amplitudes(scenes: Sequence[Scene], **options: Any) -> list[Amplitude]:
    # Constant amplitudes: claims about amplitudes must then fail.
    progress = options.get("progress")
    if progress is not None and not progress(1.0):
        raise Cancelled
    amplitude = Amplitude(y_peak=2.0, y_half_range=1.0, separations=0, separated_time=0.0)
    return [amplitude for _ in scenes]


@pytest.fixture(scope="module")
def claims_without_amplitudes() -> list[CheckedClaim]:
    # Claims that need no amplitudes.
    results = PaperResults(workers=1)
    return [check(claim, results) for claim in CLAIMS if claim.id in stability.TESTS]


@pytest.mark.slow
def test_every_claim_has_its_verdict_on_the_command_line() -> None:
    process = run_fivtui("claims", "--json")
    assert process.returncode == 0, process.stderr
    assert process.stderr == ""
    rows = {row["id"]: row for row in json.loads(process.stdout)}
    verdicts = {name: row["verdict"] for name, row in rows.items()}
    assert verdicts == (
        dict.fromkeys(HOLD, "holds")
        | dict.fromkeys(DO_NOT_HOLD, "does not hold")
        | dict.fromkeys(NOT_TESTABLE, "not testable")
    )
    for row in rows.values():
        keys = {"id", "section", "statement", "stated", "computed", "verdict"}
        assert keys <= set(row) <= keys | {"reason"}
        assert all(isinstance(value, str) and value for value in row.values())
        assert "nan" not in row["computed"]
    for name in DO_NOT_HOLD | NOT_TESTABLE:
        assert rows[name]["reason"]
    # By claim: what the paper states, and computed quantities that disagree with it.
    parts = {
        "critical-friction-of-the-example": (
            "0.28",
            "μ_c(F = 80 N) = 0.4394",
            "μ_c(F = 50 N) = 0.2799",
            "limit cycles (F = 80 N) = 0.2779",
        ),
        "stabilised-at-1-2": ("1.2", "μ_c(100 N, 300 N/m³) = 1.184", "k_nl needed = 307.2"),
        "separations-are-short": ("short", "time off the belt of 100 s = 71.01 %"),
        "stable-returns-to-equilibrium": (
            "returns",
            "growth rate (F = 120 N) = -0.032 1/s",
            "half peak-to-peak, second half, static start = 7.4",
        ),
        "reattachment-at-the-static-position": ("y_static", "y_static(F = 80 N) = -0.6746 m"),
    }
    for name, (stated, *computed) in parts.items():
        assert stated in rows[name]["stated"]
        for quantity in computed:
            assert quantity in rows[name]["computed"]


def test_a_notebook_displays_claims_as_a_table() -> None:
    html = claims(["critical-friction-of-the-example"])._repr_html_()
    assert html.count("<tr>") == 2
    assert "does not hold" in html
    assert "0.4394" in html


def test_claims_have_unique_ids_statements_and_sections() -> None:
    names = [claim.id for claim in CLAIMS]
    assert set(names) == HOLD | DO_NOT_HOLD | NOT_TESTABLE
    assert len(names) == len(set(names)) >= 25
    assert len({claim.statement for claim in CLAIMS}) == len(CLAIMS)
    tests = [*stability.TESTS, *vibration.TESTS]
    assert sorted(tests) == sorted(claim.id for claim in CLAIMS if claim.test is not None)
    assert set(vibration.SCENES) <= set(vibration.TESTS)
    for claim in CLAIMS:
        assert re.fullmatch(r"[a-z0-9]+(-[a-z0-9]+)+", claim.id)
        assert re.match(r"Abstract|[1-6]", claim.section)
        assert claim.stated
        assert (claim.test is None) == bool(claim.untestable)
        assert (claim.test is None) == (not claim.names)


def test_all_claims_without_amplitudes_hold_except_two(
    claims_without_amplitudes: list[CheckedClaim],
) -> None:
    failing = {e.claim.id for e in claims_without_amplitudes if e.verdict is Verdict.DOES_NOT_HOLD}
    assert failing == {"reattachment-at-the-static-position", "stabilised-at-1-2"}


def test_computed_values_agree_with_known_values(
    claims_without_amplitudes: list[CheckedClaim],
) -> None:
    values = {
        (e.claim.id, q.name): q.value for e in claims_without_amplitudes for q in e.quantities
    }
    expected = {
        ("critical-friction-falls-at-small-preload", "μ_c(linear)"): 1.0181,
        ("critical-friction-falls-at-small-preload", "μ_c(k_nl = 50 N/m³)"): 0.7650,
        ("critical-friction-falls-at-small-preload", "μ_c(k_nl = 100 N/m³)"): 0.5985,
        ("critical-friction-falls-at-small-preload", "μ_c(k_nl = 500 N/m³)"): 0.2794,
        ("strong-nonlinearity-above-linear", "μ_c(k_nl = 50 N/m³)"): 0.3738,
        ("strong-nonlinearity-above-linear", "μ_c(k_nl = 100 N/m³)"): 0.5976,
        ("strong-nonlinearity-above-linear", "μ_c(k_nl = 500 N/m³)"): 1.5473,
        ("one-real-part-passes-zero", "μ_c(linear)"): 0.9434,
        ("soft-horizontal-more-stable", "μ_c(linear)"): 0.5091,
    }
    for key, value in expected.items():
        assert values[key] == pytest.approx(value, abs=5e-5)
    needed = values["stabilised-at-1-2", "k_nl needed"]
    assert needed == pytest.approx(307.2, abs=0.05)


def test_claims_about_amplitudes_fail_if_all_amplitudes_are_equal(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("fivtui.paper.results.compute_amplitudes", equal_amplitudes)
    results = PaperResults()
    # Claims about amplitudes follow this one, which is about the equilibria of the figures.
    unaffected = [claim.id for claim in CLAIMS].index("figures-show-unstable-motion")
    for claim in CLAIMS[unaffected + 1 :]:
        if claim.test is not None:
            checked = check(claim, results)
            assert checked.verdict is Verdict.DOES_NOT_HOLD, claim.id
            assert all(np.isfinite(quantity.value) for quantity in checked.quantities)


@pytest.mark.parametrize(("holds", "verdict"), [(True, "holds"), (False, "does not hold")])
def test_the_verdict_is_that_of_the_test(holds: bool, verdict: str) -> None:
    claim = Claim(
        "it-holds-so",
        "9",
        "It holds",
        "x = 1",
        test=lambda _: (holds, (1.23456, None, 3)),
        names=("x [m]", "y [m]", "n"),
        reason="because",
    )
    checked = check(claim, PaperResults())
    assert claims_to_list([checked]) == [
        {
            "id": "it-holds-so",
            "section": "9",
            "statement": "It holds",
            "stated": "x = 1",
            "computed": "x = 1.235 m; n = 3",
            "verdict": verdict,
            "reason": "because",
        }
    ]


def test_a_claim_without_a_test_is_not_testable_and_has_a_reason() -> None:
    claim = Claim("some-id", "9", "It matters", "much", untestable="no law of it")
    (row,) = claims_to_list([check(claim, PaperResults())])
    assert (row["verdict"], row["reason"], row["computed"]) == ("not testable", "no law of it", "–")


def test_a_row_without_reason_has_no_such_key() -> None:
    claim = Claim("some-id", "9", "It holds", "x", test=lambda _: (True, ()))
    assert "reason" not in claims_to_list([check(claim, PaperResults())])[0]


def test_checking_can_be_cancelled(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("fivtui.paper.results.compute_amplitudes", equal_amplitudes)
    with pytest.raises(Cancelled):
        check_claims(progress=lambda _: False)


def test_the_markdown_table_has_seven_cells_a_row(
    claims_without_amplitudes: list[CheckedClaim],
) -> None:
    lines = claims_markdown(claims_without_amplitudes).splitlines()
    assert len(lines) == len(claims_without_amplitudes) + 2
    for line in lines:
        assert len(re.split(r"(?<!\\)\|", line)) == 9
    assert lines[1] == "| --- | --- | --- | --- | --- | --- | --- |"


def test_markdown_keeps_bars_and_underscores_as_they_are() -> None:
    claim = Claim("some-id", "9", "|y_e| < 1", "a * b", test=lambda _: (True, ()))
    row = claims_markdown([check(claim, PaperResults())]).splitlines()[-1]
    assert r"\|y\_e\| \< 1" in row
    assert r"a \* b" in row
    assert "`some-id`" in row


def test_the_printed_table_has_every_claim_and_ends_with_the_count(
    claims_without_amplitudes: list[CheckedClaim], capsys: pytest.CaptureFixture[str]
) -> None:
    odd = dataclasses.replace(
        claims_without_amplitudes[0].claim, statement="[bold]|x| is shown as it is"
    )
    print_claims(
        [*claims_without_amplitudes, dataclasses.replace(claims_without_amplitudes[0], claim=odd)]
    )
    printed = capsys.readouterr()
    for entry in claims_without_amplitudes:
        assert entry.claim.id in printed.out
        assert str(entry.quantities[0])[:12] in printed.out
    assert "[bold]|x| is shown" in printed.out
    assert "does not hold" in printed.out
    holding = sum(entry.verdict is Verdict.HOLDS for entry in claims_without_amplitudes) + 1
    assert (
        f"{len(claims_without_amplitudes) + 1} claims: holds {holding}, does not hold 2"
        in printed.err
    )


def test_rules_of_trends_recognise_rising_and_falling_values() -> None:
    line = np.array([3.0, 1.0, 2.0, 4.0])
    assert falls_then_rises(line)
    assert not falls_then_rises(line[1:])
    assert not falls_then_rises(line[:2])
    assert not falls_then_rises(np.array([3.0, 1.0, 1.0, 4.0]))
    assert rises(line[1:])
    assert falls(line[:2])
    assert not rises(np.array([1.0, 1.0]))
    assert not falls(np.array([1.0, 1.0]))


@pytest.mark.parametrize(
    ("excess", "expected"),
    [
        ([-1.0, -1.0, 1.0, 2.0], 15.0),
        ([0.0, -1.0, 3.0, 2.0], 12.5),
        ([0.0, 1.0, 2.0, 3.0], 0.0),
        ([-1.0, 1.0, -1.0, 1.0], None),
        ([-1.0, -1.0, -1.0, 0.0], None),
        ([1.0, 1.0, 1.0, 1.0], None),
        ([1.0, -1.0, -1.0, -1.0], None),
    ],
)
def test_a_crossing_is_found_if_it_exists(excess: list[float], expected: float | None) -> None:
    # The excess must become positive exactly once, and stay so.
    assert crossing(np.array([0.0, 10.0, 20.0, 30.0]), np.array(excess)) == expected


def test_stored_claims_are_read_back_unless_their_text_changed(tmp_path: Path) -> None:
    checked = claims(["critical-friction-of-the-example"])
    path = tmp_path / "claims.json"
    # `claims_to_stored` makes the data of the file that `stored_claims` reads.
    path.write_text(json.dumps(claims_to_stored(checked)))
    assert stored_claims(path) == checked
    path.write_text(path.read_text().replace('"stated": "', '"stated": "about '))
    assert stored_claims(path) == []
    path.write_text("[{}]")
    with pytest.raises(InputError, match="damaged"):
        stored_claims(path)


def test_counts_are_stored_as_plain_numbers() -> None:
    # The claim counts by NumPy, whose integers JSON does not have.
    claim = next(candidate for candidate in CLAIMS if candidate.id == "contact-means-negative-y")
    stored = claims_to_stored([check(claim, PaperResults(workers=1))])
    assert json.loads(json.dumps(stored)) == stored
