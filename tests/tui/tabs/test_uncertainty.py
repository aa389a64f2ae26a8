"""The uncertainty tab: its charts, its table of Sobol indices, and a study started in the app.

Samples are in three regions by friction: no squeal below the safe μ, squeal after a knock (a large
disturbance) up to the critical μ, and squeal by itself above it. There the equilibrium is unstable.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from textual.pilot import Pilot
from textual.widgets import Input

from fivtui.distributions import parse_distribution
from fivtui.model.errors import InputError
from fivtui.reliability.charts import (
    histogram_chart,
    probability_text,
    quantity_name,
    samples_chart,
)
from fivtui.reliability.result import Uncertainty
from fivtui.reliability.run import compute_uncertainty
from fivtui.scene.files import load_scene, save_scene
from fivtui.scene.presets import PRESETS
from fivtui.sweeps.run import local_engine
from fivtui.tui.session.session import DisplayedStudy, Session
from fivtui.tui.tabs.studies import uncertainty
from fivtui.tui.tabs.studies.uncertainty import UncertaintyPane, index_bar, index_rows
from fivtui.tui.tabs.tab_book import TabBook
from tests.support.laboratory import app_of, click_view, show_tab, until_shown

DISTRIBUTION = "mu~uniform:0.2:0.8"
# Of the scene `base`.
SAFE_MU, CRITICAL_MU = 0.278, 0.4394
# Squeal is possible above SAFE_MU: a probability of 0.87, of which this text has the first digit.
SQUEAL_POSSIBLE = "P(squeal possible) = 0.8"


@pytest.fixture(autouse=True)
def _use_few_samples(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(uncertainty, "SAMPLES", 256)


@pytest.fixture(scope="module")
def result() -> Uncertainty:
    # `_use_few_samples` applies only during a test.
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(uncertainty, "SAMPLES", 256)
        study = UncertaintyPane.parse(PRESETS["base"], DISTRIBUTION)
    # On this machine, with one thread.
    return compute_uncertainty(study, local_engine(1))


def test_a_histogram_has_a_step_line_for_each_region(result: Uncertainty) -> None:
    chart = histogram_chart(result, "growth_rate")
    assert chart is not None
    assert [trace.name for trace in chart.traces] == list(result.regions())
    # The step line has two points per bin: every second point counts each bin once.
    assert sum(trace.y[::2].sum() for trace in chart.traces) == pytest.approx(1.0)
    unstable = chart.traces[-1]
    assert unstable.y[::2].sum() == pytest.approx(result.probabilities["unstable"].value)
    assert [guide.label for guide in chart.guides] == ["5%", "50%", "95%"]
    assert SQUEAL_POSSIBLE in probability_text(result)
    safe_mu_chart = histogram_chart(result, "safe_mu")
    assert safe_mu_chart is not None
    assert safe_mu_chart.x_label == "safe μ"


def test_the_chart_of_samples_has_a_trace_for_each_region(result: Uncertainty) -> None:
    chart = samples_chart(result, "growth_rate")
    assert chart is not None
    assert chart.x_label == "μ"
    assert sum(trace.x.size for trace in chart.traces) == 256
    no_squeal, knock, unstable = chart.traces
    assert no_squeal.x.max() < SAFE_MU < knock.x.min()
    assert knock.x.max() < CRITICAL_MU < unstable.x.min()
    assert np.all(unstable.y > 0.0)


def test_the_table_shows_sobol_indices_as_numbers_and_bars(result: Uncertainty) -> None:
    rows = index_rows(result)
    assert [row[0] for row in rows] == [quantity_name(name) for name in result.indices]
    assert rows[0][1] == "μ"
    assert rows[0][2].startswith("1.0")
    # Twelve characters for 0 to 1: dark up to the first-order index, light up to the total one.
    assert index_bar(0.5, 0.75) == "█" * 6 + "░" * 3
    # By sampling errors indices may be below 0 or above 1, where the bar ends.
    assert index_bar(-0.1, 1.3) == "░" * 12


def pane_of(pilot: Pilot[None]) -> UncertaintyPane:
    pane = app_of(pilot).screen_stack[0].query_one(TabBook).pane
    assert isinstance(pane, UncertaintyPane)
    return pane


async def test_f10_starts_the_study_and_the_views_show_its_results(
    pilot: Pilot[None], tmp_path: Path
) -> None:
    await show_tab(pilot, "alt+7")
    pane = pane_of(pilot)
    with pytest.raises(InputError, match="press Scatter"):
        pane.export("data")
    distribution_input = pane.query_one("#uncertainty-input", Input)
    distribution_input.value = "mu~uniform:0.8:0.2"
    await pilot.press("f10")
    await until_shown(pilot, "LOW must be below HIGH")
    distribution_input.value = DISTRIBUTION
    await pilot.press("f10")
    await until_shown(pilot, "256 samples")
    await until_shown(pilot, SQUEAL_POSSIBLE)
    assert not pane.has_class("-outdated")
    await until_shown(pilot, "squeals after a knock")
    await click_view(pilot, "critical_mu")
    await until_shown(pilot, "critical μ")
    pane.show_view("indices")
    # The heading of total indices: effects of an input together with others.
    await until_shown(pilot, "with others")
    await until_shown(pilot, "256 samples, indices above 1: sampling error")
    await until_shown(pilot, "████")
    export = pane.export("data")
    export.write(tmp_path / "rows.csv")
    assert pane.command_line() == ("fivtui uncertainty --vary 'mu~uniform:0.2:0.8' --samples 256")
    loaded_study = DisplayedStudy(load_result(tmp_path / "rows.csv"), name="a", source="rows.csv")
    app_of(pilot).session.studies["uncertainty"] = loaded_study
    pane.scene_changed()
    await until_shown(pilot, "read from rows.csv; 256 samples")


def test_the_input_begins_with_the_distributions_of_the_scene(tmp_path: Path) -> None:
    assert UncertaintyPane(Session()).initial_text == UncertaintyPane.EXAMPLE
    scatter = tuple(
        (name, parse_distribution(text))
        for name, text in (("mu", "normal:0.42:0.01"), ("y0", "uniform:-1:0"))
    )
    session = Session(replace(PRESETS["base"], scatter=scatter))
    text = UncertaintyPane(session).initial_text
    assert text == "μ~normal:0.42:0.01 y0~uniform:-1:0"
    study = UncertaintyPane.parse(session.scene(), text)
    assert [str(axis) for axis in study.design.axes.values()] == [str(axis) for _, axis in scatter]
    # A name that is left out of the input does not scatter.
    assert list(UncertaintyPane.parse(session.scene(), DISTRIBUTION).design.axes) == ["mu"]
    session.set_text("F", "90")
    save_scene(session.scene(), tmp_path / "saved.toml")
    assert load_scene(tmp_path / "saved.toml").scatter == scatter


def load_result(path: Path) -> Uncertainty:
    from fivtui.studies import load_study

    result = load_study("uncertainty", path)
    assert isinstance(result, Uncertainty)
    return result


def test_an_engine_without_uncertainty_studies_is_refused_with_the_method_that_can() -> None:
    with pytest.raises(InputError, match="method = fmu: must be taylor"):
        UncertaintyPane.parse(replace(PRESETS["base"], method="fmu"), UncertaintyPane.EXAMPLE)
