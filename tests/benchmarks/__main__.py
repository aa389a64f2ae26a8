"""Print the benchmark of single runs beside other solvers, and draw the work-precision diagram."""

import sys
from pathlib import Path

import click

from fivtui.console.printing import print_rows
from tests.references import REFERENCES

from .peers import missing_packages, peers
from .solvers import FIVTUI_SOLVERS
from .work_precision import LEVELS, draw, measure, ratio_to, table


@click.command()
@click.option("--scene", default="base", type=click.Choice(list(REFERENCES)), show_default=True)
@click.option("--out", type=click.Path(path_type=Path), default=Path("work-precision.png"))
@click.option(
    "--seconds",
    default=0.3,
    help="CPU time, s, in which one solver repeats a run at one tolerance or step.",
)
def main(scene: str, out: Path, seconds: float) -> None:
    """Measure single runs beside other solvers."""

    def report(text: str) -> None:
        print(text, file=sys.stderr, flush=True)

    if not_installed := missing_packages():
        report(f"not installed, therefore not measured: {', '.join(not_installed)}")
    measurements = measure(
        REFERENCES[scene], [*FIVTUI_SOLVERS, *peers()], seconds=seconds, report=report
    )
    header = ("CPU ms to reach the error", *(f"{level:.0e}" for level in LEVELS), "over fivtui")
    print_rows(f"Scene {scene}, {REFERENCES[scene].t_end:g} s", header, table(measurements))
    ratio = ratio_to(measurements, "heyoka")
    if ratio is not None:
        print(f"\nCPU time of heyoka at its best over that of fivtui, geometric mean: {ratio:.2f}")
    draw(measurements, f"Scene {scene}", out)
    report(f"wrote {out}")


main()
