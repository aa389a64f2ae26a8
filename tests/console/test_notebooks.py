"""Figures and progress bars in a notebook; stand-ins take the place of IPython."""

import sys
import types
from typing import Any

import pytest

import fivtui
from fivtui.console import printing


class Display:
    """Stands in for the output of a cell: records what it shows."""

    shown: list[str]

    def __init__(self) -> None:
        displays.append(self)

    def display(self, html: str) -> None:
        self.shown = [html]

    def update(self, html: str) -> None:
        self.shown.append(html)


displays: list[Display] = []


@pytest.fixture
def notebook(monkeypatch: pytest.MonkeyPatch) -> None:
    """A notebook in which bars appear and change at once."""
    ipython: Any = types.ModuleType("IPython")
    display: Any = types.ModuleType("IPython.display")
    ipython.get_ipython = lambda: types.SimpleNamespace(kernel=object())
    display.HTML, display.DisplayHandle = str, Display
    monkeypatch.setitem(sys.modules, "IPython", ipython)
    monkeypatch.setitem(sys.modules, "IPython.display", display)
    monkeypatch.setattr(printing, "_DELAY_S", 0.0)
    monkeypatch.setattr(printing, "_NOTEBOOK_INTERVAL_S", 0.0)
    displays.clear()


@pytest.mark.usefixtures("notebook")
def test_a_bar_in_a_notebook_is_replaced_and_removed() -> None:
    bar = fivtui.ProgressBar("a <study>")
    assert bar(0.25)
    assert bar(0.5)
    assert bar(1.0)
    (display,) = displays
    assert display.shown[0] == ""
    assert 'value="0.2500"' in display.shown[1]
    assert "a &lt;study&gt;: 25%" in display.shown[1]
    assert "s left" in display.shown[1]
    assert display.shown[-1] == ""


@pytest.mark.usefixtures("notebook")
def test_the_end_of_a_block_removes_the_bar() -> None:
    with fivtui.ProgressBar("study", remaining=False) as bar:
        bar(0.5)
    (display,) = displays
    assert "left" not in display.shown[1]
    assert display.shown[-1] == ""


@pytest.mark.usefixtures("notebook")
def test_a_long_study_reports_to_a_bar() -> None:
    bar = fivtui.ProgressBar("sweep")
    fivtui.sweep(vary={"F": [20.0, 80.0]}, t_end=5.0, progress=bar)
    assert all(display.shown[-1] == "" for display in displays)


def test_a_figure_displays_itself_as_a_picture() -> None:
    figure: Any = fivtui.stability().figure()
    assert figure._repr_png_().startswith(b"\x89PNG")
