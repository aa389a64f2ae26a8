"""Make ``fivtui/assessment/stress_truth.json``: quadruple-precision results.

Run it as ``python -m tests.references.make_stress_truth``; it needs gcc. The horizon of 1e5 s takes
half an hour, the rest minutes. With test names as arguments it renews only those.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import fivtui
from fivtui.assessment.stress_tests import STRESS_TESTS, TRUTH_FILE
from fivtui.model import System
from fivtui.transient.request import resolve_start

SOURCE = Path(__file__).with_name("quad.c")
TARGET = Path(fivtui.__file__).parent / "assessment" / TRUTH_FILE
FIELDS = ("x", "vx", "y", "vy", "y_abs", "x_abs", "separations", "separated_time")


def solve(program: Path, name: str) -> dict[str, str]:
    test = STRESS_TESTS[name]
    p = test.parameters
    start = resolve_start(System(p, test.separation), test.start)
    arguments = (*p.values(), float(test.separation), test.t_end, *start)
    process = subprocess.run(
        [str(program)],
        input=" ".join(map(repr, map(float, arguments))),
        capture_output=True,
        text=True,
        check=True,
    )
    return dict(zip(FIELDS, process.stdout.split(), strict=True))


def main(names: list[str]) -> None:
    truths = json.loads(TARGET.read_text(encoding="utf-8")) if names and TARGET.exists() else {}
    with tempfile.TemporaryDirectory() as folder:
        program = Path(folder) / "quad"
        command = ["gcc", "-O2", "-o", str(program), str(SOURCE), "-lquadmath", "-lm"]
        subprocess.run(command, check=True)
        for name in names or [
            name
            for name, test in STRESS_TESTS.items()
            if test.has_result and not test.same_result_as
        ]:
            truths[name] = solve(program, name)
            print(name, truths[name], file=sys.stderr, flush=True)
            TARGET.write_text(json.dumps(truths, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
