"""Nothing is cut at any size, and the README's picture is of the laboratory as it is."""

import html
import re
from pathlib import Path

import pytest

from fivtui.model import PARAMETERS
from fivtui.tui.app import FivtuiApp
from fivtui.tui.session import FIELDS
from fivtui.tui.tabs import TABS
from tests.support.laboratory import text_of, until_shown

PICTURE = Path(__file__).parents[2] / "examples" / "laboratory.svg"
SIZES = [(80, 24), (100, 30), (120, 35), (140, 40), (200, 60)]


@pytest.mark.parametrize("size", SIZES)
async def test_panes_are_whole_and_units_and_gauge_are_there(size: tuple[int, int]) -> None:
    async with FivtuiApp().run_test(size=size) as pilot:
        await until_shown(pilot, "Im λ/(2π) (Hz)")
        lines = text_of(pilot).splitlines()
        # Every line ends in an edge but the keys', and that of the last run.
        ends = {line.rstrip()[-1] for line in lines[:-1] if len(line.rstrip()) == size[0]}
        assert ends <= set("╮│╯")
        short = [line for line in lines[:-1] if len(line.rstrip()) < size[0]]
        assert len(short) == 1
        assert "no run yet: press F5" in short[0]
        (gauge,) = (line for line in lines if line.startswith("│ μ ") and "●" in line)
        assert "squeals by itself" in gauge
        assert any(line.split() == ["│", "0", "0.439", "0.7", "1.5", "│"] for line in lines)
        for name, spec in PARAMETERS.items():
            symbol = FIELDS[name].symbol
            (row,) = (
                line[: line.index("│", 1)]
                for line in lines
                if re.match(rf"│ {symbol} .*−  \+", line)
            )
            assert row.rstrip().endswith(spec.unit or "+"), row
        (tabs,) = (line for line in lines if "Stability" in line)
        shown = tabs[tabs.index("Stability") :].rstrip("─╮").removesuffix("› ").split()
        assert shown == [tab.title for tab in TABS][: len(shown)]
        if size[1] >= 30:
            assert any("↑↓ step  F8 reset ─╯" in line for line in lines)
            assert "μ_c 0.4394" in text_of(pilot)
        if size[1] >= 36:
            assert "F (N) " in text_of(pilot)


def test_the_picture_shows_what_is_there() -> None:
    texts = re.findall(r"<text[^>]*>(.*?)</text>", PICTURE.read_text(encoding="utf-8"))
    shown = " ".join(html.unescape(" ".join(texts)).split())
    for words in (
        *(tab.title for tab in TABS),
        *(FIELDS[name].symbol for name in PARAMETERS),
        "Parameters",
        "Runs",
        "squeals by itself",
        "a global search",
        "0.278",
        "separation considered",
        "F5 Run F1 Help",
    ):
        assert words in shown, words
