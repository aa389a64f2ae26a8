"""Sphinx extension of the manual: tables from the code, outputs of commands, laboratory screens.

A line ``{generated} NAME`` in a fence is replaced by what `tables.NAME` returns. The directive
``run`` runs fivtui commands while the manual is built and shows their outputs and figures, and
``screen`` shows the laboratory after some keys. ``file`` shows a file and writes it for the
commands of the page.
"""

import os
import re
import shutil
from pathlib import Path
from typing import ClassVar, Final

import tables
from commands import CommandError, run_line
from docutils import nodes
from docutils.parsers.rst import directives
from screens import page_screens
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment
from sphinx.util.docutils import SphinxDirective
from sphinx.util.typing import ExtensionMetadata, OptionSpec

_GENERATED: Final = re.compile(r"^```\{generated\} (\w+)\n```$", flags=re.MULTILINE)


def insert_generated(_app: Sphinx, _docname: str, source: list[str]) -> None:
    """Replace the fences of generated parts of a page by Markdown."""
    source[0] = _GENERATED.sub(lambda match: str(getattr(tables, match[1])()), source[0])


class _PictureDirective(SphinxDirective):
    # Base of directives that show a picture.

    def work_folder(self) -> Path:
        """The folder of the page, where its commands run; outside of the sources."""
        folder = Path(str(self.env.doctreedir), "manual", self.env.docname)
        folder.mkdir(parents=True, exist_ok=True)
        return folder

    def picture(self, path: Path, description: str, kind: str = "figure") -> nodes.Node:
        """The node of a picture in a file."""
        page = Path(self.env.doc2path(self.env.docname)).parent
        uri = Path(os.path.relpath(path.resolve(), page.resolve())).as_posix()
        image = nodes.image(uri=uri, alt=description, classes=[kind])
        return nodes.figure("", image)


class Run(_PictureDirective):
    """Fivtui commands, one a line, with what they print; ``:picture:`` shows a file they wrote."""

    has_content = True
    option_spec: ClassVar[OptionSpec] = {
        "picture": directives.unchanged,
        "alt": directives.unchanged,
        "lines": directives.unchanged,
    }

    def run(self) -> list[nodes.Node]:
        """Run the commands; an error is a warning of the build.

        ``:lines: 5 3`` shows the first five and the last three lines of an output; ``:lines: 0``
        shows none.
        """
        folder = self.work_folder()
        parts: list[nodes.Node] = []
        # A command ends at the first line without a backslash at its end.
        for command in re.split(r"(?<!\\)\n", "\n".join(self.content)):
            parts.append(_code(command, "sh"))
            try:
                printed = run_line(command.replace("\\\n", ""), folder)
            except CommandError as error:
                raise self.error(f"{command}: {error}") from None
            shown = _shortened(printed, self.options.get("lines", ""))
            if shown:
                parts.append(_code(shown, "text"))
        if "picture" in self.options:
            path = folder / self.options["picture"]
            parts.append(self.picture(path, self.options.get("alt", path.stem)))
        return parts


class Screen(_PictureDirective):
    """The laboratory after some steps, one a line; the argument describes the picture.

    The screens of a page are one session: each continues from the one before.
    """

    has_content = True
    required_arguments = 1
    final_argument_whitespace = True
    option_spec: ClassVar[OptionSpec] = {"size": directives.unchanged_required}

    def run(self) -> list[nodes.Node]:
        """Draw all screens of the page at its first one, and show the next."""
        pictures = self.env.temp_data.get("screens")
        if pictures is None:
            text = Path(self.env.doc2path(self.env.docname)).read_text(encoding="utf-8")
            pictures = self.env.temp_data["screens"] = page_screens(text)
        path = self.work_folder() / f"laboratory-{len(pictures)}.svg"
        path.write_text(pictures.pop(0), encoding="utf-8")
        return [self.picture(path, self.arguments[0], "screen")]


class WrittenFile(_PictureDirective):
    """A text file, shown and written for the commands that follow; the argument is its name."""

    has_content = True
    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        """Write and show the file."""
        path = self.work_folder() / self.arguments[0]
        text = "\n".join(self.content)
        path.write_text(f"{text}\n", encoding="utf-8")
        code = _code(text, path.suffix[1:] if path.suffix != ".csv" else "text")
        return [
            nodes.container(
                "",
                nodes.caption("", path.name),
                code,
                literal_block=True,
                classes=["literal-block-wrapper"],
            )
        ]


def _shortened(text: str, counts: str) -> str:
    if not counts:
        return text
    lines = text.splitlines()
    first, last = (*map(int, counts.split()), 0)[:2]
    if not first + last:
        return ""
    if first + last >= len(lines):
        return text
    return "\n".join([*lines[:first], "…", *lines[len(lines) - last :]])


def _code(text: str, language: str) -> nodes.Node:
    return nodes.literal_block(text, text, language=language)


def clear_work_folder(app: Sphinx, _environment: BuildEnvironment, docname: str) -> None:
    """Remove the files of an earlier build of a page, which commands would not overwrite."""
    shutil.rmtree(Path(str(app.doctreedir), "manual", docname), ignore_errors=True)


def setup(app: Sphinx) -> ExtensionMetadata:
    """Register the parts of the extension; the pages are read by all processors."""
    app.parallel = max(app.parallel, os.cpu_count() or 1)
    app.connect("env-purge-doc", clear_work_folder)
    app.connect("source-read", insert_generated)
    app.add_directive("run", Run)
    app.add_directive("screen", Screen)
    app.add_directive("file", WrittenFile)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
