"""Commands that build, check and run FMUs: of the slider-belt, and of a brake actuator.

The brake actuator computes the preload of the slider-belt from a commanded force.
"""

from pathlib import Path
from typing import Any, Final

import click

from fivtui.model import InputError
from fivtui.options import OUTPUT

from .arguments import option
from .group import CommandGroup, commands
from .options import (
    force_option,
    json_option,
    output_option,
    parse_assignments,
    print_json,
    print_note,
    print_text,
    print_written_files,
    progress_bar,
)
from .paths import InputFile

_RUN: Final = "Run"

fmi_option = option(
    "--fmi",
    default="2",
    metavar="2|3",
    help="2 for FMI 2.0; 3 for FMI 3.0, in the native flavour only.",
)
fmu_argument = click.argument("fmu_file", type=InputFile("the FMU"), metavar="FILE.fmu")
flavour_option = option(
    "--flavour",
    default="native",
    metavar="NAME",
    help="native, or python: needs Python where it runs, and a folder of plain characters.  "
    "[default: native]",
)


@commands.group(cls=CommandGroup, invoke_without_command=True)
@click.pass_context
def fmu(context: click.Context) -> None:
    """Build, check and run FMUs (FMI 2.0 and 3.0)."""
    if context.invoked_subcommand is None:
        print_text(context.get_help())


@fmu.command("build")
@output_option("--out", "FILE.fmu", "The FMU to write.", required=True)
@option(
    "--component",
    default="slider-belt",
    metavar="NAME",
    help="slider-belt or brake-actuator.  [default: slider-belt]",
)
@fmi_option
@flavour_option
@option(
    "--platform",
    "platform",
    metavar="NAMES",
    help="Platforms of the native flavour, of linux64,win64,darwin64 and, for 64-bit ARM, "
    "aarch64-linux,aarch64-darwin,aarch64-windows.  [default: this one]",
)
@option("--sources", is_flag=True, help="Add the C files of the native flavour.")
@force_option
def fmu_build(out: Path, platform: str | None, **options: Any) -> None:
    """Export the slider-belt or the brake actuator as an FMU.

    The native flavour runs without Python and also offers model exchange. It runs on this platform
    or on those of --platform, which needs the extra fivtui[cross]. With --sources, `fmpy compile`
    builds it for other platforms. The Python flavour is one file for Linux and Windows.
    """
    from fmu_src.build import build_fmu

    platforms = [] if platform is None else platform.split(",")
    build_fmu(out, platforms=platforms, **options)
    print_written_files(out)


@fmu.command("system")
@output_option("--out", "FILE.ssp", "The archive to write.", required=True)
@fmi_option
@flavour_option
@option("--ports", is_flag=True, help="Give the system ports, which libcosim and ecos refuse.")
@force_option
def fmu_system(out: Path, **options: Any) -> None:
    """Export slider-belt and brake actuator, coupled, as SSP."""
    from fmu_src.build import build_ssp

    build_ssp(out, **options)
    print_written_files(out)


@fmu.command("check")
@fmu_argument
@json_option
def fmu_check(fmu_file: Path, as_json: bool) -> None:
    """Check that an FMU follows the standard and runs.

    Lists the problems found; the exit status is then 2.
    """
    from fivtui.fmu import check_fmu

    problems = check_fmu(fmu_file)
    if as_json:
        print_json({"file": str(fmu_file), "problems": problems})
    elif problems:
        print_text("\n".join(problems))
    else:
        print_text(f"{fmu_file}: no problems")
    if problems:
        raise InputError(f"{fmu_file}: not a valid FMU, problems found: {len(problems)}")


@fmu.command("run")
@fmu_argument
@option("--t-end", metavar="S", group=_RUN, help="Stop time, s.  [default: the FMU's]")
@option("--output-interval", metavar="S", group=OUTPUT, help="Time between recorded points, s.")
@option(
    "--set",
    "assignments",
    multiple=True,
    metavar="NAME=VALUE",
    group=_RUN,
    help="Start value of a variable of the FMU; may be repeated.",
)
@option(
    "--output",
    "outputs",
    multiple=True,
    metavar="NAME",
    group=OUTPUT,
    help="Record this variable only; may be repeated.",
)
@option("--tol", metavar="R", group=_RUN, help="Relative tolerance passed to the FMU.")
@option(
    "--input",
    type=InputFile("--input"),
    metavar="FILE.csv",
    group=_RUN,
    help="Inputs over time: columns time (s) and the names of inputs.",
)
@output_option("--out", "FILE.csv", "Write the recorded variables over time.")
@output_option("--events", "FILE.csv", "Write the times at which discrete variables changed.")
@force_option
@json_option
def fmu_run(fmu_file: Path, out: Path | None, as_json: bool, **options: Any) -> None:
    """Run a co-simulation FMU through fmpy.

    Prints the last values, or writes all of them with --out.
    """
    from fivtui.console import print_list
    from fivtui.fmu import run_fmu, save_fmu_events, save_fmu_run
    from fivtui.io import check_table_path

    events = options["events"]
    for path in (out, events):
        if path is not None:
            check_table_path(path, "FMU result", (".csv",))
    with progress_bar("FMU") as progress:
        run = run_fmu(
            fmu_file,
            t_end=options["t_end"],
            output_interval=options["output_interval"],
            start_values=parse_assignments("--set", options["assignments"], "F=60"),
            outputs=options["outputs"] or None,
            input_csv=options["input"],
            tol=options["tol"],
            progress=progress,
        )
    for warning in run.warnings:
        print_note(f"warning: {warning}")
    if out is not None:
        save_fmu_run(run, out)
        print_written_files(out)
    if events is not None:
        save_fmu_events(run, events)
        print_written_files(events)
    if as_json:
        print_json(run.to_dict())
    elif out is None:
        rows = [
            (name, f"{value:.10g} {run.units.get(name, '')}")
            for name, value in run.to_dict()["final"].items()
        ]
        print_list(f"{run.model}, FMI {run.fmi_version}: last values", rows)
