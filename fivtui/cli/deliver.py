"""How commands write, draw and print the result of a study."""

from pathlib import Path
from typing import Any

from .options import print_json, say, say_written


def check_outputs(kind: str, out: Path | None, plot: Path | None, *, force: bool) -> None:
    """Check files to be written, before the work; `InputError` if one cannot be."""
    if out is not None:
        from fivtui.studies import check_study_path

        check_study_path(kind, out, force=force)
    if plot is not None:
        from fivtui.charts import check_figure_path

        check_figure_path(plot, force=force)


def write(kind: str, result: Any, out: Path | None, plot: Path | None, *, force: bool) -> None:
    """Write a result and its figure to the files asked for, and say so."""
    from fivtui.studies import save_study, study

    if out is not None:
        save_study(kind, result, out, force=force)
        say_written(out)
    if plot is not None:
        from fivtui.charts import save_figure

        save_figure(study(kind).figure(result), plot, force=force)
        say_written(plot)


def show(kind: str, result: Any, *, as_json: bool = False) -> None:
    """Print a result as a table or as JSON."""
    from fivtui.studies import study

    if as_json:
        print_json(study(kind).to_dict(result))
    else:
        study(kind).show(result)


def warn(kind: str, result: Any) -> None:
    """Say what a result warns of."""
    from fivtui.studies import study

    if (warning := study(kind).warning(result)) is not None:
        say(f"warning: {warning}")
