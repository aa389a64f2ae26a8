"""Screens of the laboratory as SVG, after steps that a reader can follow.

A step is `field NAME VALUE`, `press KEYS`, `wait TEXT` or `until-gone TEXT`.
"""

import asyncio
import re
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Final

from textual.pilot import Pilot
from textual.widgets import Checkbox, Input

from fivtui.tui.app import FivtuiApp

_LIMIT_S: Final = 120.0
_POLL_S: Final = 0.3
_SCREEN: Final = re.compile(r"^```\{screen\} [^\n]*\n(.*?)^```", flags=re.MULTILINE | re.DOTALL)
_SIZE: Final = re.compile(r"^:size: (\d+)x(\d+)$")
# Pages are read without network: no fonts from elsewhere.
_FONT_FACES: Final = re.compile(r"@font-face \{.*?\}", flags=re.DOTALL)


class StepError(Exception):
    """A text did not appear on the screen."""


def page_screens(text: str) -> list[str]:
    """The screens of a page, as SVG, in one session: each continues from the one before."""
    blocks = [block.splitlines() for block in _SCREEN.findall(text)]
    return asyncio.run(_draw([(*_SIZE.findall(lines[0])[0], lines[1:]) for lines in blocks]))


async def _draw(screens: Sequence[tuple[str, str, Sequence[str]]]) -> list[str]:
    pictures = []
    with tempfile.TemporaryDirectory() as folder:
        app = FivtuiApp(state=Path(folder) / "session.json")
        async with app.run_test() as pilot:
            for width, height, steps in screens:
                await pilot.resize_terminal(int(width), int(height))
                for step in filter(None, steps):
                    verb, _, argument = step.partition(" ")
                    await _follow(pilot, verb, argument)
                await pilot.pause()
                pictures.append(_FONT_FACES.sub("", app.export_screenshot(title="fivtui")))
    return pictures


async def _follow(pilot: Pilot[None], verb: str, argument: str) -> None:
    if verb == "press":
        await pilot.press(*argument.split())
    elif verb == "field":
        await _edit(pilot, *argument.split())
    elif verb == "wait":
        await _wait(pilot, argument, lambda text: argument in text)
    elif verb == "until-gone":
        await _wait(pilot, argument, lambda text: argument not in text)
    else:
        raise StepError(f"unknown step {verb!r}")
    await pilot.pause()


async def _edit(pilot: Pilot[None], name: str, value: str) -> None:
    # Type the last character of a value, or tick the box that ignores separation.
    row = pilot.app.screen.query_one(f"#row-{name}")
    if boxes := row.query(Checkbox):
        boxes.first().toggle()
        return
    editor = row.query_one(Input)
    editor.focus()
    await pilot.pause()
    editor.value = value[:-1]
    await pilot.press("end", value[-1])


async def _wait(pilot: Pilot[None], argument: str, check: Callable[[str], bool]) -> None:
    end = time.monotonic() + _LIMIT_S
    while not check(_text(pilot)):
        if time.monotonic() > end:
            raise StepError(f"waited in vain for {argument!r} in:\n{_text(pilot)}")
        # Reading the screen takes longer than most computations.
        await asyncio.sleep(_POLL_S)


def _text(pilot: Pilot[None]) -> str:
    strips = pilot.app.screen._compositor.render_strips()
    return "\n".join(strip.text for strip in strips)
