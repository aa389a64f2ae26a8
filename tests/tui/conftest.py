"""What tests of the laboratory have in common."""

from collections.abc import AsyncIterator
from pathlib import Path

import pytest
from textual.pilot import Pilot

from fivtui.model import Cancelled
from fivtui.tui.app import FivtuiApp


def _not_searched(*_: object, **__: object) -> None:
    raise Cancelled


@pytest.fixture(autouse=True)
def safe_friction_is_not_searched(monkeypatch: pytest.MonkeyPatch) -> None:
    """Laboratories search for the safe friction where a test is about it alone."""
    monkeypatch.setattr("fivtui.safety.safe_friction", _not_searched)
    monkeypatch.setattr("fivtui.safety.safety_zones", _not_searched)


@pytest.fixture
async def pilot(
    request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> AsyncIterator[Pilot[None]]:
    """A laboratory that has begun, in a terminal of the size that the module says."""
    monkeypatch.chdir(tmp_path)
    size = getattr(request.module, "SIZE", (100, 30))
    async with FivtuiApp().run_test(size=size) as started:
        await started.pause()
        yield started
