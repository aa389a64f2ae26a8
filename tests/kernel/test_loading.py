"""Loading of the compiled kernels: lazily, in the background, from a cache that cannot be stale."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import fivtui
from fivtui import simulate
from fivtui.kernel import loader as kernel_loader
from fivtui.kernel.loader import KernelLoader
from fivtui.model.errors import ComputationError

PACKAGE = Path(fivtui.__file__).parent


def python(
    code: str, *, cache: Path | None = None, path: Path = PACKAGE.parent
) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "PYTHONPATH": str(path)}
    if cache is not None:
        environment["NUMBA_CACHE_DIR"] = str(cache)
    return subprocess.run(
        [sys.executable, "-W", "error", "-c", code],
        env=environment,
        cwd=path,
        capture_output=True,
        text=True,
        check=False,
        timeout=300.0,
    )


def test_neither_the_package_nor_a_first_run_imports_the_compiler() -> None:
    done = python(
        "import sys, fivtui\n"
        "kernel = fivtui.simulate(t_end=1e-3).stats.kernel\n"
        "print(kernel, 'numba' in sys.modules)"
    )
    assert (done.stdout, done.stderr, done.returncode) == ("interpreted False\n", "", 0)


def test_a_later_run_is_compiled() -> None:
    done = python(
        "from fivtui import simulate\n"
        "from fivtui.kernel import loader\n"
        "first = simulate(t_end=1.0).stats.kernel\n"
        "loader.single.module()\n"
        "print(first, simulate(t_end=1.0).stats.kernel)"
    )
    assert (done.stdout, done.stderr, done.returncode) == ("interpreted compiled\n", "", 0)


def test_compiling_leaves_standard_output_alone_where_colorama_is_installed(
    tmp_path: Path,
) -> None:
    fake = tmp_path / "fake" / "colorama.py"
    fake.parent.mkdir()
    fake.write_text(
        "import sys\n"
        "__version__ = '9.0.0'\n"
        "class Fore:\n    def __getattr__(self, name): return ''\n"
        "Fore = Style = Fore()\n"
        "def init(): sys.stdout = sys.stderr\n"
        "reinit = deinit = init\n"
    )
    done = python(
        f"import sys; sys.path.insert(0, {str(fake.parent)!r})\n"
        "from fivtui.kernel import loader\n"
        "kernel = loader.single.module()\n"
        "from numba.core.errors import termcolor\n"
        "import colorama\n"
        "termcolor().errmsg('coloured')\n"
        "print(colorama.__version__)",
    )
    assert (done.stdout, done.stderr, done.returncode) == ("9.0.0\n", "", 0)


@pytest.mark.parametrize("seconds", [0.0, 0.3, 0.7, 1.5, 2.5, 4.0])
def test_the_end_of_the_process_stops_the_compiler(seconds: float, tmp_path: Path) -> None:
    done = python(
        f"import time; from fivtui import simulate; simulate(t_end=1.0); time.sleep({seconds})",
        cache=tmp_path,
    )
    assert (done.stdout, done.stderr, done.returncode) == ("", "", 0)


def test_a_failure_to_load_is_reported_and_single_runs_go_on(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def broken(name: str) -> object:
        raise OSError(f"no {name}\nand more")

    loader = KernelLoader("single")
    monkeypatch.setattr(kernel_loader, "import_module", broken)
    monkeypatch.setattr(kernel_loader, "single", loader)
    with pytest.raises(ComputationError, match=r"cannot be loaded: OSError: no .*single; use the"):
        simulate(t_end=1.0, kernel="compiled")
    assert loader.failure == "OSError: no fivtui.kernel.single"
    assert simulate(t_end=1.0).stats.kernel == "interpreted"


@pytest.mark.parametrize(("looks", "kernel"), [(16, "compiled"), (120, "interpreted")])
def test_an_interpreted_run_hands_over_to_the_compiled_kernel_if_that_is_ready_early(
    monkeypatch: pytest.MonkeyPatch, looks: int, kernel: str
) -> None:
    class Late(KernelLoader):
        seen = 0

        @property
        def ready(self) -> bool:
            self.seen += 1
            return self.seen > looks

    fractions: list[float] = []

    def note(fraction: float) -> bool:
        fractions.append(fraction)
        return True

    expected = simulate(t_end=400.0, tol=1e-9, kernel=kernel)  # type: ignore[arg-type]
    monkeypatch.setattr(kernel_loader, "single", Late("single"))
    run = simulate(t_end=400.0, tol=1e-9, progress=note)
    assert run.stats.kernel == kernel
    assert run.final == expected.final
    assert fractions == sorted(fractions)
    assert fractions[-1] == 1.0


def test_a_kernel_is_stored_under_a_name_that_follows_from_all_of_its_sources(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    import numba

    from fivtui.kernel import jit
    from fivtui.taylor import series

    def stored_as(text: str) -> str:
        def double(x: float) -> float:
            return 2.0 * x

        monkeypatch.setattr(jit, "_source", lambda module: text if module is series else "")
        compiled_double = jit.kernel(numba.float64(numba.float64), series)(double)
        assert compiled_double(3.0) == 6.0
        return double.__qualname__

    assert stored_as("square * 3.0") == stored_as("square * 3.0") != stored_as("square * 2.0")


@pytest.mark.whole
def test_kernels_are_compiled_anew_when_a_source_of_theirs_changes(tmp_path: Path) -> None:
    shutil.copytree(PACKAGE, tmp_path / "fivtui", ignore=shutil.ignore_patterns("__pycache__"))
    source = tmp_path / "fivtui" / "taylor" / "series.py"
    before, cache = source.stat(), tmp_path / "cache"
    code = (
        "from fivtui import simulate\n"
        "print([simulate(t_end=1.0, kernel=k).final.y for k in ('compiled', 'interpreted')])"
    )
    old = python(code, cache=cache, path=tmp_path)
    text = source.read_text(encoding="utf-8")
    changed = text.replace("square * 3.0", "square * 2.0")
    assert changed != text
    assert len(changed) == len(text)
    source.write_text(changed, encoding="utf-8")
    # Neither its size nor its date tells of the change, nor do Python's own caches.
    os.utime(source, ns=(before.st_atime_ns, before.st_mtime_ns))
    for folder in (tmp_path / "fivtui").rglob("__pycache__"):
        shutil.rmtree(folder)
    new = python(code, cache=cache, path=tmp_path)
    assert (old.stderr, new.stderr) == ("", "")
    assert new.stdout != old.stdout
    one, other = map(float, new.stdout.strip("[]\n").split(","))
    assert one == pytest.approx(other, rel=1e-9)
