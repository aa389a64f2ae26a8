"""How commands write, draw and print the result of a study.

A `kind` is the name of a kind of study, such as map or sweep, in `fivtui.studies`.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

from .options import print_json, print_note, print_written_files, progress_bar


@dataclass(frozen=True)
class Outputs:
    """Where a result goes: files for its data and its figure, and standard output."""

    out: Path | None = None
    plot: Path | None = None
    as_json: bool = False

    @property
    def path(self) -> Path:
        """The file or folder of a command that requires --out."""
        return cast("Path", self.out)

    def check(self, kind: str) -> None:
        """Raise `InputError` if a file cannot be written; call it before the computation."""
        if self.out is not None:
            from fivtui.studies import check_study_path

            check_study_path(kind, self.out)
        if self.plot is not None:
            from fivtui.charts import check_figure_path

            check_figure_path(self.plot)

    def write(self, kind: str, result: Any) -> None:
        """Write a result and its figure to the files, and print their names."""
        from fivtui.studies import save_study, study

        if self.out is not None:
            save_study(kind, result, self.out)
            print_written_files(self.out)
        if self.plot is not None:
            from fivtui.charts import save_figure

            save_figure(study(kind).figure(result), self.plot)
            print_written_files(self.plot)

    def show(self, kind: str, result: Any) -> None:
        """Print a result as a table or as JSON."""
        from fivtui.studies import study

        if self.as_json:
            print_json(study(kind).to_dict(result))
        else:
            study(kind).show(result)

    def warn(self, kind: str, result: Any) -> None:
        """Print the warning of a result."""
        from fivtui.studies import study

        if (warning := study(kind).warning(result)) is not None:
            print_note(f"warning: {warning}")

    def finish(self, kind: str, result: Any) -> None:
        """Print the warning of a result, write the result to files and print it.

        Raises `ComputationError` afterwards if nothing could be computed.
        """
        self.warn(kind, result)
        self.write(kind, result)
        self.show(kind, result)
        self.check_computed(kind, result)

    def check_computed(self, kind: str, result: Any) -> None:
        """Raise `ComputationError` if nothing could be computed."""
        from fivtui.studies import study

        if (failure := study(kind).failure(result)) is not None:
            raise failure

    def compute_and_deliver(
        self, kind: str, compute: Callable[..., Any], *, label: str = ""
    ) -> Any:
        """Compute a study with a progress bar of a `label`, by default its kind; `finish` it.

        `compute` has the only argument `progress`.
        """
        self.check(kind)
        with progress_bar(label or kind) as progress:
            result = compute(progress=progress)
        self.finish(kind, result)
        return result
