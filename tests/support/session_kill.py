"""Kills a process at the file operations that store a session, and checks the stored session.

``python -m tests.support.session_kill autosave FOLDER`` kills at each operation once and prints
their number; ``python -m tests.support.session_kill lab FOLDER COUNT`` kills the whole laboratory
COUNT times at a random operation. The operating system kills the process, so no handler of the
program runs.
"""

import asyncio
import random
import shutil
import signal
import sys
from itertools import count
from pathlib import Path
from unittest import mock

import numpy as np

from fivtui.maps import stability_map
from fivtui.scene.presets import PRESETS
from fivtui.simulation import simulate
from fivtui.tui import app as app_module
from fivtui.tui.persistence.autosave import Autosave
from fivtui.tui.persistence.state_file import restore_results, session_state
from fivtui.tui.session.jobs import Outcome
from fivtui.tui.session.runs import RunState
from fivtui.tui.session.session import DisplayedStudy, Session
from tests.support.kernels import INTERPRETED
from tests.support.laboratory import until

from .sweep_kill import child, kill_at

SEED = 11
# About the number of file operations of `use_lab`.
OPERATIONS = 50
# The session is emptied above this number of runs, before it drops old runs itself: above 20.
MAX_STORED_RUNS = 15
BASE = PRESETS["base"]
RESULT = simulate(t_end=1.0, samples=np.linspace(0.0, 1.0, 11), kernel="interpreted")


def restored(autosave: Autosave) -> Session:
    """The session of a state file with its results; a new one without a file."""
    session = autosave.load() or Session()
    assert not autosave.notices, autosave.notices
    # Session 1 was opened, not a second one beside it.
    assert autosave.number == 1, autosave.number
    results, errors = autosave.store.read(session.unread_results)
    assert not errors, errors
    restore_results(session, results)
    return session


def change_session(path: Path) -> None:
    """Delete a run, make another, and replace the map."""
    autosave = Autosave(path)
    session = restored(autosave)
    for run in list(session.runs):
        session.runs.remove(run)
    autosave.save(session_state(session))
    run = session.runs.start(BASE)
    session.runs.finish(run, Outcome(RESULT))
    over = {"mu": np.linspace(0.0, 1.0, 3), "F": np.linspace(10.0, 20.0, 2)}
    session.studies["map"] = DisplayedStudy(stability_map(BASE.parameters, over), "base")
    autosave.save(session_state(session))
    autosave.close(session_state(session))


def load_and_check(path: Path) -> Session:
    """Load the session as the next start does; every result of the file must be readable."""
    autosave = Autosave(path)
    session = restored(autosave)
    state = session_state(session)
    for run in session.runs:
        assert (run.result is not None) is (run.state is RunState.DONE)
    autosave.close(state)
    assert not autosave.save_error, autosave.save_error
    return session


def kill_sessions(folder: Path) -> int:
    """Kill a process at each operation that changes a session; return their number."""
    before = folder / "before"
    change_session(before / "session.json")

    def is_killed_at(operation: int) -> bool:
        path = folder / str(operation) / "session.json"
        shutil.copytree(before, path.parent)

        def change_until_killed() -> None:
            kill_at(operation, path.parent)
            change_session(path)

        code = child(change_until_killed)
        assert code in (0, -signal.SIGKILL), code
        session = load_and_check(path)
        # Before the change, after the deletion, or with the new run.
        assert [run.number for run in session.runs] in ([1], [], [2])
        assert session.studies.get("map") is not None
        assert child(lambda: change_session(path)) == 0
        assert not list(path.parent.rglob("*.tmp"))
        return code != 0

    return next(number for number in count() if not is_killed_at(number + 1))


def kill_labs(folder: Path, times: int) -> int:
    """Kill laboratories, each of which continues the session of the one before."""
    path = folder / "session.json"
    rng = random.Random(SEED)
    # Use interpreted runs, and store the session often.
    INTERPRETED.start()
    mock.patch.object(app_module, "_SAVE_INTERVAL_S", 0.01).start()
    recorded: set[int] = set()
    kills = 0
    while kills < times:
        operation = rng.randrange(1, OPERATIONS + 1)

        def lab(operation: int = operation) -> None:
            kill_at(operation, folder)
            asyncio.run(use_lab(path))

        code = child(lab)
        assert code in (0, -signal.SIGKILL), code
        kills += code != 0
        session = load_and_check(path)
        # Only the user deletes runs; an unfinished run is not counted.
        finished = {run.number for run in session.runs if run.result is not None}
        assert recorded <= finished, (recorded, finished)
        recorded = finished
        if len(list(session.runs)) > MAX_STORED_RUNS:
            autosave = Autosave(path)
            autosave.load()
            autosave.close(session_state(Session()))
            assert not recorded & {run.number for run in load_and_check(path).runs}
            recorded = set()
    return kills


async def use_lab(path: Path) -> None:
    """Compute two runs in a laboratory, and wait until its session is stored."""
    app = app_module.FivtuiApp(state=path)
    async with app.run_test(size=(80, 24)) as pilot:
        await pilot.pause()
        runs = app.session.runs
        for text in ("0.5", "0.6"):
            app.session.set_text("t_end", text)
            await pilot.press("f5")
            await until(
                pilot,
                lambda: runs.active is None and not app.autosave.needs_save(app._session_state()),
            )


def main() -> None:
    kind, folder, *times = sys.argv[1:]
    if kind == "autosave":
        print(kill_sessions(Path(folder)))
    else:
        print(kill_labs(Path(folder), int(*times)))


if __name__ == "__main__":
    main()
