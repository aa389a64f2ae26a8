"""The commands by purpose, each with an example and its page of the manual."""

from collections.abc import Mapping
from itertools import chain
from pathlib import Path
from typing import Final, NamedTuple

from fivtui.model import InputError, unknown_name_error

# Folders that may hold the manual as HTML pages: in this installation, and as the README builds it.
FOLDERS: Final = (Path(__file__).parents[1] / "manual", Path("manual"))
_MISSING: Final = (
    "there is no manual in this installation, nor in the folder manual here; build it in the "
    "source folder of fivtui: .venv/bin/pip install -c .ci/constraints.txt '.[docs]' && "
    ".venv/bin/python -m sphinx docs manual"
)


class Entry(NamedTuple):
    """What the help of a command names: a page of the manual, and an example."""

    page: str
    example: str


# Commands in the order of the help, by purpose.
SECTIONS: Final[Mapping[str, Mapping[str, Entry]]] = {
    "Run": {
        "simulate": Entry("how-to/compare-cases", "simulate --set F=120 --t-end 50"),
        "compare": Entry("how-to/compare-cases", "compare --out base-scene"),
        "run": Entry("how-to/own-scenes", "run brake-stop"),
        "presets": Entry("how-to/own-scenes", "presets"),
        "methods": Entry("how-to/cost", "methods"),
        "accuracy": Entry("how-to/trust", "accuracy --set F=120"),
        "validate": Entry(
            "how-to/measured-data", "validate --measured measured.csv --quantity y --band 5%"
        ),
        "identify": Entry(
            "how-to/identify", "identify --measured measured.csv --signal y --fit mu --fit c1=0.1:2"
        ),
        "animate": Entry(
            "how-to/film-and-sound", "animate --window 50:52 --speed 1 --out film.gif"
        ),
        "sound": Entry("how-to/film-and-sound", "sound --out run.wav"),
    },
    "Stability": {
        "stability": Entry("how-to/check-stability", "stability --set F=120"),
        "attractors": Entry("how-to/safe-friction", "attractors --set F=120"),
        "branch": Entry("how-to/branches", "branch --vary mu=0.2:1 --plot branch.png"),
        "map": Entry(
            "how-to/map",
            "map --over F=20:150:27 --over mu=0.1:1:19 --plot map.png",
        ),
    },
    "Studies": {
        "sweep": Entry("how-to/sweep", "sweep --vary F=20:150:27 --both --out sweep.csv"),
        "uncertainty": Entry(
            "how-to/uncertainty",
            "uncertainty --vary mu~normal:0.4:0.05 --vary F~uniform:60:100",
        ),
        "tradeoff": Entry("how-to/cost", "tradeoff --error peak=1e-4"),
        # Stress tests of the integration methods.
        "extremes": Entry("how-to/trust", "extremes"),
    },
    "FMU": {
        "fmu": Entry("how-to/fmu-in-fmpy", "fmu build --out slider-belt.fmu"),
        "fmu build": Entry("how-to/fmu-in-c", "fmu build --fmi 3 --out slider-belt-3.fmu"),
        "fmu run": Entry("how-to/fmu-inputs", "fmu run slider-belt.fmu --set F=60 --t-end 20"),
        "fmu check": Entry("how-to/fmu-in-fmpy", "fmu check slider-belt.fmu"),
        "fmu system": Entry("how-to/fmu-inputs", "fmu system --out brake.ssp"),
    },
    "Paper": {
        "figures": Entry("explanation/paper-claims", "figures 3-5 --out figures"),
        "claims": Entry("explanation/paper-claims", "claims"),
    },
    # The laboratory is the interactive program in the terminal.
    "Laboratory and manual": {
        "tui": Entry("tutorial/laboratory", "tui brake-stop"),
        "serve": Entry("tutorial/laboratory", "serve --port 8000"),
        "docs": Entry("index", "docs trust"),
    },
}
ENTRIES: Final[Mapping[str, Entry]] = dict(
    chain.from_iterable(section.items() for section in SECTIONS.values())
)
# The entry of the program itself: ``fivtui --help``.
PROGRAM_ENTRY: Final = Entry("index", "stability --set F=120")


def epilog(entry: Entry) -> str:
    """The end of a help text: the example, and the page of the manual."""
    # The mark \b keeps click from joining the lines that follow.
    page = "" if entry.page == "index" else f" {_page_name(entry.page)}"
    lines = "\b", "Example:", f"  fivtui {entry.example}", "", "\b", "Manual:"
    return "\n".join((*lines, f"  {entry.page}.html, opened by fivtui docs{page}"))


def _page_name(path: str) -> str:
    return path.rpartition("/")[2].removesuffix(".html")


def find_page(name: str | None) -> Path:
    """The file of a page of the manual, by its name or by that of a command."""
    folder = next((path for path in FOLDERS if (path / "index.html").is_file()), None)
    if folder is None:
        raise InputError(_MISSING)
    # Of two pages of one name the first counts, so it is entered at the end.
    pages = {page.stem: page for page in sorted(folder.resolve().rglob("*.html"), reverse=True)}
    pages["index"] = folder.resolve() / "index.html"
    entry = ENTRIES.get(name or "")
    page = _page_name(entry.page if entry is not None else name or "index")
    if page not in pages:
        raise unknown_name_error("page", page, sorted(pages))
    return pages[page]


def open_page(page: Path) -> bool:
    """Open a page in the browser; returns whether there is one."""
    import webbrowser

    return webbrowser.open(page.as_uri())
