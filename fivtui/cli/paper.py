"""Commands that reproduce the paper."""

from pathlib import Path

import click

from fivtui.model import InputError

from .arguments import option
from .deliver import show
from .group import commands
from .options import folder_option, force_option, json_option, progress_bar, put, say


@commands.command()
@click.argument("numbers", nargs=-1, metavar="[N ...]")
@folder_option("Folder for the pictures and their data.")
@option(
    "--format",
    "formats",
    multiple=True,
    metavar="NAME",
    help="pdf, svg or png; may be repeated.  [default: pdf and png]",
)
@force_option
def figures(numbers: tuple[str, ...], out: Path, formats: tuple[str, ...], force: bool) -> None:
    """Draw the paper's figures 2 to 16.

    N is a number or a range such as 3-9; all are drawn without it. The data of each picture go to
    a CSV file beside it, with units and parameters.
    """
    from fivtui.paper import DEFAULT_FORMATS, figure_numbers, save_figures

    with progress_bar("figures") as progress:
        written = save_figures(
            figure_numbers(numbers),
            out,
            formats=formats or DEFAULT_FORMATS,
            force=force,
            progress=progress,
        )
    for files in written:
        say(f"wrote {', '.join(str(path) for path in (*files.pictures, *files.data))}")


@commands.command()
@option("--markdown", is_flag=True, help="Print a Markdown table.")
@json_option
def claims(markdown: bool, as_json: bool) -> None:
    """Check every testable statement of the paper.

    Lists section, stated value, computed value and verdict of each.
    """
    from fivtui.paper import check_claims, claims_markdown

    if markdown and as_json:
        raise InputError("--markdown: must be given without --json")
    with progress_bar("claims") as progress:
        checked = check_claims(progress=progress)
    if markdown:
        put(claims_markdown(checked))
    else:
        show("claims", checked, as_json=as_json)
