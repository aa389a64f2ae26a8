"""Fixtures shared by tests of the laboratory."""

from collections.abc import AsyncIterator
from pathlib import Path

import pytest
from textual.pilot import Pilot

from fivtui.model import Cancelled
from fivtui.tui.app import FivtuiApp


def _cancel_search(*_: object, **__: object) -> None:
    raise Cancelled


@pytest.fixture(autouse=True)
def disable_safe_friction_search(monkeypatch: pytest.MonkeyPatch) -> None:
    """Cancel the slow searches for safe friction at once; tests about them patch them again.

    Friction is safe up to the μ below which no disturbance was found to lead to squeal. Zones are
    ranges of any parameter that are safe or squeal.
    """
    monkeypatch.setattr("fivtui.safety.safe_friction", _cancel_search)
    monkeypatch.setattr("fivtui.safety.safety_zones", _cancel_search)


@pytest.fixture
async def pilot(
    request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> AsyncIterator[Pilot[None]]:
    """A started laboratory, in a terminal of the module's SIZE."""
    monkeypatch.chdir(tmp_path)
    size = getattr(request.module, "SIZE", (100, 30))
    async with FivtuiApp().run_test(size=size) as pilot_of_app:
        await pilot_of_app.pause()
        yield pilot_of_app
