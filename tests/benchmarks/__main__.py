"""Print the benchmarks of single runs, starts and batches, and draw the work-precision diagram."""

import sys
from pathlib import Path

import click

from fivtui.console.printing import print_list, print_rows
from tests.references import REFERENCES

from . import batch
from .peers import missing, peers
from .solvers import OWN
from .starts import starts
from .work_precision import LEVELS, draw, measure, ratio_to, table


@click.command()
@click.option("--scene", default="base", type=click.Choice(list(REFERENCES)), show_default=True)
@click.option("--out", type=click.Path(path_type=Path), default=Path("work-precision.png"))
@click.option("--seconds", default=0.3, help="CPU time for one setting in a round.")
@click.option("--no-starts", is_flag=True, help="Do not time fresh processes.")
@click.option("--no-sweep", is_flag=True, help="Do not time batches.")
def main(scene: str, out: Path, seconds: float, no_starts: bool, no_sweep: bool) -> None:
    """Measure single runs and batches beside other solvers, and starts of fresh processes."""

    def say(text: str) -> None:
        print(text, file=sys.stderr, flush=True)

    if absent := missing():
        say(f"not installed, therefore not measured: {', '.join(absent)}")
    measured = measure(REFERENCES[scene], [*OWN, *peers()], seconds=seconds, say=say)
    header = ("CPU ms to reach the error", *(f"{level:.0e}" for level in LEVELS), "ratio")
    print_rows(f"Scene {scene}, {REFERENCES[scene].t_end:g} s", header, table(measured))
    ratio = ratio_to(measured, "heyoka")
    if ratio is not None:
        print(f"\nCPU time of heyoka at its best over that of fivtui, geometric mean: {ratio:.2f}")
    draw(measured, f"Scene {scene}", out)
    say(f"wrote {out}")
    if not no_starts:
        rows = [(name, f"{seconds:.3f} s") for name, seconds in starts()]
        print_list("Fresh processes, wall clock", rows)
    if not no_sweep:
        batch.main()


main()
