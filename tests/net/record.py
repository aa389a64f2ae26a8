"""Writes the recordings: `python -m tests.net.record [PART ...]` for the named parts, or all."""

import sys
import time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

from tests.net.parts import PARTS
from tests.net.text import RECORDED, differences

_PROCESSES = 2


def record_part(name: str) -> tuple[str, float]:
    """Record a part; return the differences from its previous recording, and the CPU time in s."""
    begin = time.process_time()
    text = PARTS[name]()
    path = RECORDED / f"{name}.txt"
    previous = path.read_text(encoding="utf-8") if path.exists() else ""
    changes = differences(previous, text)
    # A recording that agrees within the tolerance is not rewritten.
    if changes or not previous:
        RECORDED.mkdir(exist_ok=True)
        path.write_text(text, encoding="utf-8")
    return "\n".join(changes), time.process_time() - begin


def main(names: list[str]) -> None:
    """Record the named parts, or all, each in a process of its own."""
    if unknown_names := [name for name in names if name not in PARTS]:
        sys.exit(f"unknown part {unknown_names[0]!r} (known: {', '.join(PARTS)})")
    if not names:
        for path in RECORDED.glob("*.txt"):
            if path.stem not in PARTS:
                path.unlink()
    selected = names or list(PARTS)
    failed = 0
    with ProcessPoolExecutor(
        _PROCESSES, mp_context=get_context("spawn"), max_tasks_per_child=1
    ) as pool:
        for name, future in [(name, pool.submit(record_part, name)) for name in selected]:
            try:
                changes, seconds = future.result()
            except Exception as error:  # noqa: BLE001 (the other parts are recorded)
                failed += 1
                print(f"{name}: failed: {type(error).__name__}: {error}")
                continue
            print(
                f"{name}: {'changed' if changes else 'same'}, {seconds:.0f} s of CPU time",
                flush=True,
            )
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main(sys.argv[1:])
