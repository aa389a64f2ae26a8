"""Repeated loads of an FMU reuse the library and the folder, without files left open."""

import json
import sys
import tempfile
from pathlib import Path

import pytest

from fivtui.fmu.folders import reserve_folder
from tests.support.processes import run_python

LOAD_SCRIPT = """
import json, os, sys, threading
from pathlib import Path
from fivtui.model import Parameters, System
from fivtui.transient.request import Request
from fivtui.fmu.transient import integrate_fmu
from fivtui.fmu.run import run_fmu

def count_resources():
    libraries = [line for line in open("/proc/self/maps") if "SliderBelt.so" in line]
    return len(libraries), len(os.listdir("/proc/self/fd"))

fmu = Path(sys.argv[1])
counts = []
for _ in range(12):
    run_fmu(fmu, t_end=0.1)
    integrate_fmu(Request(System(Parameters()), t_end=0.1, method="fmu"), fmu=fmu)
    counts.append(count_resources())
print(json.dumps(counts))
"""


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
def test_repeated_runs_map_no_more_libraries_and_leave_no_open_files(fmu: Path) -> None:
    # Each count holds the mapped parts of libraries and the open files.
    first_counts, *later_counts = json.loads(run_python("-c", LOAD_SCRIPT, fmu))
    assert first_counts[0] > 0
    assert later_counts == [first_counts] * 11


def test_a_folder_is_reused_only_for_the_same_content(
    fmu: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    copy, changed_fmu = tmp_path / "copy.fmu", tmp_path / "other.fmu"
    copy.write_bytes(fmu.read_bytes())
    changed_fmu.write_bytes(fmu.read_bytes() + b"\0")
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    # Files of equal content share folders, but not at the same time.
    with reserve_folder(fmu) as first_folder:
        assert Path(first_folder.path).parent == folder
        assert list(Path(first_folder.path).iterdir()) == []
        with reserve_folder(copy) as second_folder, reserve_folder(changed_fmu) as changed_folder:
            assert len({first_folder.path, second_folder.path, changed_folder.path}) == 3
    assert list(folder.iterdir()) == []
    with reserve_folder(copy) as reused_folder:
        assert reused_folder.path in (first_folder.path, second_folder.path)
        # A folder that another program made at the path that is free stays unchanged.
        (free_path,) = {first_folder.path, second_folder.path} - {reused_folder.path}
        occupied_path = Path(free_path)
        occupied_path.mkdir()
        with reserve_folder(fmu) as new_folder:
            assert new_folder.path not in (str(occupied_path), changed_folder.path)
        # After a fatal error the next run loads the library from another path.
        reused_folder.failed_fatally = True
    assert list(folder.iterdir()) == [occupied_path]
    # Of the paths for this content, one is occupied, one not used again, and the new one is free.
    with reserve_folder(fmu) as next_folder:
        assert next_folder.path == new_folder.path
