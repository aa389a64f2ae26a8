"""Loading an FMU again takes no more memory in the process and disturbs no other run."""

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
def test_tens_of_runs_map_one_library_and_open_no_file(fmu: Path) -> None:
    first, *later = json.loads(run_python("-c", LOAD_SCRIPT, fmu))
    assert first[0] > 0
    assert later == [first] * 11


def test_a_folder_is_reused_only_for_the_same_content(
    fmu: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    copy, changed = tmp_path / "copy.fmu", tmp_path / "other.fmu"
    copy.write_bytes(fmu.read_bytes())
    changed.write_bytes(fmu.read_bytes() + b"\0")
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    with reserve_folder(fmu) as first:
        assert Path(first.path).parent == folder
        assert list(Path(first.path).iterdir()) == []
        with reserve_folder(copy) as second, reserve_folder(changed) as foreign:
            assert len({first.path, second.path, foreign.path}) == 3
    assert list(folder.iterdir()) == []
    with reserve_folder(copy) as again:
        assert again.path in (first.path, second.path)
        # A folder of the expected name that another program made stays unchanged.
        occupied = Path(({first.path, second.path} - {again.path}).pop())
        occupied.mkdir()
        with reserve_folder(fmu) as fresh:
            assert fresh.path not in (str(occupied), foreign.path)
        again.failed_fatally = True
    assert list(folder.iterdir()) == [occupied]
    with reserve_folder(fmu) as next_folder:
        assert next_folder.path == fresh.path
