"""Parts of the reference as Markdown, made from the tables of the code."""

import dataclasses
import inspect
import runpy
import typing
from collections.abc import Iterable, Iterator, Sequence
from functools import cache
from pathlib import Path
from typing import Any, Final

from textual.app import App
from textual.binding import Binding, BindingType

import fivtui
from fivtui import Parameters
from fivtui.equilibrium.scan import mode_scan
from fivtui.io import FORMATS
from fivtui.maps.result import COLUMNS as MAP_COLUMNS
from fivtui.model import ALL_PARAMETERS, Column, System
from fivtui.paper.claims.claim import Verdict
from fivtui.scene import PRESETS
from fivtui.scene.scene import OUTPUTS as SCENE_OUTPUTS
from fivtui.sweeps import SWEEP_PRESETS
from fivtui.sweeps.study import ERROR_COLUMNS, OUTPUTS as SWEEP_OUTPUTS
from fivtui.transient import ALL_METHODS, QUANTITIES, SETTINGS
from fivtui.tui.chart import ChartView
from fivtui.tui.lab.form.form import FieldList
from fivtui.tui.lab.keys import LAB_KEYS, key_text
from fivtui.tui.lab.run_list import RunsTable
from fivtui.tui.tabs import TABS
from fivtui.tui.tabs.motion.belt import BeltView
from fivtui.tui.tabs.search import Searchable, SearchableList, TextView
from fivtui.tui.tabs.transient import TransientPane
from fivtui.tui.tabs.views_pane import ViewsPane
from fmu_src.slave.variables import VARIABLES

# Public names by subject; the table of contents of the API.
_API: Final = {
    "Parameters and scenes": (
        "Parameters", "Scene", "PRESETS", "find_scene", "load_scene", "save_scene",
    ),
    "Stability": ("stability", "stability_map", "safe_friction", "safety_map"),
    "Transients": ("simulate", "simulate_batch", "accuracy", "tradeoff"),
    "Limit cycles": ("attractors", "basin", "continuation", "branch", "boundary"),
    "Studies": ("sweep", "uncertainty", "Design", "Range", "Distribution"),
    "Measured data, film and sound": (
        "read_measurement", "validate", "identify", "Tolerances", "animate", "sound",
    ),
    "FMU": ("build_fmu", "build_ssp", "check_fmu", "run_fmu"),
    "The paper": ("figures", "claims"),
    "Progress and errors": ("ProgressBar", "InputError", "ComputationError", "Cancelled"),
}  # fmt: skip
_WIDGET_KEYS: Final[dict[str, list[BindingType]]] = {
    "In a plot": ChartView.BINDINGS,
    "In lists and in the form": [*SearchableList.BINDINGS, *Searchable.BINDINGS],
    "In texts, such as the log and the help": [*TextView.BINDINGS, *Searchable.BINDINGS],
    "In the form": [key for key in FieldList.BINDINGS if key not in SearchableList.BINDINGS],
    "In the list of runs": RunsTable.BINDINGS,
    "In a tab with several views": ViewsPane.BINDINGS,
    "In the tab Run": TransientPane.BINDINGS,
    "In its view Belt": BeltView.BINDINGS,
}

_VERDICTS: Final = {
    Verdict.DOES_NOT_HOLD: "Do not hold",
    Verdict.HOLDS: "Hold",
    Verdict.NOT_TESTABLE: "Cannot be tested by the model",
}
_CLAIM_COLUMNS: Final = ("section", "stated", "computed")


def parameters() -> str:
    """The parameters with units, defaults and ranges."""
    return _table(
        ("name", "symbol", "unit", "base set", "allowed", "meaning"),
        (
            (
                f"`{spec.name}`",
                _formula(spec.symbol),
                spec.unit or "–",
                "none" if spec.optional else f"{spec.default:g}",
                spec.allowed,
                spec.meaning,
            )
            for spec in ALL_PARAMETERS.values()
        ),
    )


def settings() -> str:
    """The settings of a scene, with the options that set them."""
    return _table(
        ("key", "option", "meaning", "allowed"),
        (
            (f"`{name}`", f"`{setting.option.flag}`", setting.meaning, setting.allowed)
            for name, setting in SETTINGS.items()
        ),
    )


def scene_outputs() -> str:
    """The outputs that a scene may require."""
    return _named(("output", "meaning"), SCENE_OUTPUTS.items())


def error_targets() -> str:
    """The quantities that may have an error target."""
    return _named(("quantity", "meaning"), QUANTITIES.items())


def methods() -> str:
    """The integration methods."""
    return _named(("method", "meaning"), ALL_METHODS.items())


def presets() -> str:
    """The scenes that come with the program."""
    return _named(
        ("preset", "description"), ((name, scene.description) for name, scene in PRESETS.items())
    )


def sweep_presets() -> str:
    """The sweeps that come with the program."""
    return _named(
        ("preset", "description"),
        ((name, preset.description) for name, preset in SWEEP_PRESETS.items()),
    )


def sweep_outputs() -> str:
    """The outputs of sweeps."""
    return _columns([*SWEEP_OUTPUTS.values(), *ERROR_COLUMNS.values()])


def formats() -> str:
    """The formats of tables."""
    return _table(
        ("suffix", "needs"),
        (
            (f"`{suffix}`", f"`fivtui[{form.extra}]`" if form.extra else "–")
            for suffix, form in FORMATS.items()
        ),
    )


def result_files() -> str:
    """The columns of each kind of table, read from a small result of it."""
    return "\n".join(
        f"## {title}\n\n`{command}`; in Python `{function}`.\n\n{_columns(result._table())}"
        for title, command, function, result in _small_results()
    )


def _small_results() -> Iterator[tuple[str, str, str, Any]]:
    base, stable = Parameters(), Parameters(F=120.0)
    loads, frictions = [60.0, 80.0], [0.2, 0.7]
    window = {"F": (28.0, 40.0), "mu": (0.2, 0.6)}
    yield (
        "Run", "fivtui simulate --out FILE", "simulate(samples=…)",
        fivtui.simulate(t_end=1.0, samples=3),
    )  # fmt: skip
    yield (
        "Modes over μ", "fivtui stability --out FILE", "stability()",
        mode_scan(System(base), 1.5),
    )  # fmt: skip
    yield (
        "Map", "fivtui map --out FILE", "stability_map(…)",
        fivtui.stability_map(base, {"F": loads, "mu": frictions}),
    )  # fmt: skip
    yield (
        "Sweep", "fivtui sweep --out FILE", "sweep(…)",
        fivtui.sweep(base, vary={"F": loads}, t_end=5.0),
    )  # fmt: skip
    yield (
        "Uncertainty", "fivtui uncertainty --out FILE", "uncertainty(…)",
        fivtui.uncertainty(vary={"mu": "uniform:0:1"}, samples=64),
    )  # fmt: skip
    yield (
        "Attractors along a parameter", "fivtui attractors --vary … --out FILE", "continuation(…)",
        fivtui.continuation(None, "mu", [0.2, 0.5]),
    )  # fmt: skip
    yield (
        "Basins of attraction", "fivtui attractors --basin … --out FILE", "basin(…)",
        fivtui.basin(stable, {"y0": [-0.8, 0.0], "vy0": [0.0]}),
    )  # fmt: skip
    yield (
        "Branch of limit cycles", "fivtui branch --out FILE", "branch(…)",
        fivtui.branch(None, "mu", low=0.2, high=1.0),
    )  # fmt: skip
    yield (
        "Boundary over two parameters", "fivtui branch --curve … --out FILE", "boundary(…)",
        fivtui.boundary(Parameters(F=30.0), "hopf", window),
    )  # fmt: skip
    yield (
        "Batch in memory", "no command", "simulate_batch(…)",
        fivtui.simulate_batch({"F": loads}, t_end=5.0),
    )  # fmt: skip


def map_columns() -> str:
    """The columns of values that a map may have."""
    return _columns(MAP_COLUMNS.values())


def fmu_variables() -> str:
    """The variables of the FMU of the slider-belt, in the order of their references."""
    return _table(
        ("name", "causality, variability, type", "unit", "meaning", "start", "allowed"),
        (
            (
                f"`{variable.name}`",
                f"{variable.role}, {variable.variability}, {variable.type}",
                variable.unit or "–",
                variable.meaning,
                str(variable.start).lower() if variable.settable else "",
                variable.range_text,
            )
            for variable in VARIABLES
        ),
    )


def coupled_brake() -> str:
    """The displacement y of the coupled brake after 5 s, m, by the number of steps."""
    example = runpy.run_path(str(Path(__file__).parents[2] / "examples" / "fmu_coupled.py"))
    rows = (
        (
            str(steps),
            *(
                f"{example['coupled'](steps, 5.0, extrapolate=flag)[0]:.5f}"
                for flag in (False, True)
            ),
        )
        for steps in (500, 1000, 2000, 4000)
    )
    return _table(("steps", "held", "extrapolated"), rows)


def tabs() -> str:
    """The tabs of the laboratory with their keys."""
    return _table(("tab", "key"), ((tab.title, _key(tab.key)) for tab in TABS))


def keys() -> str:
    """The keys of the laboratory, by where they work."""
    parts = ["## Everywhere", _bindings(LAB_KEYS, with_ids=True)]
    for title, bindings in _WIDGET_KEYS.items():
        widget_keys = [binding for binding in bindings if isinstance(binding, Binding)]
        parts += [f"## {title}", _bindings(widget_keys)]
    return "\n\n".join(parts)


def _bindings(bindings: Iterable[Binding], *, with_ids: bool = False) -> str:
    header = ("key", "what it does", "name in the configuration")
    rows = (
        (
            " ".join(_key(key) for key in binding.key.split(",")),
            binding.tooltip or binding.description,
            f"`{binding.id}`" if binding.id else "",
        )
        for binding in bindings
        if binding.description
    )
    length = 3 if with_ids else 2
    return _table(header[:length], (row[:length] for row in rows))


def _key(key: str) -> str:
    return f"<kbd>{key_text(_app(), key)}</kbd>"


@cache
def _app() -> App[None]:
    # Names keys; it does not run.
    return App()


def claims() -> str:
    """The paper's claims by verdict, each with the stated and the computed value."""
    checked = fivtui.claims()
    parts = []
    for verdict, title in _VERDICTS.items():
        rows = [claim.row for claim in checked if claim.verdict is verdict]
        parts += [f"## {title}: {len(rows)} of {len(checked)}", *map(_claim, rows)]
    return "\n\n".join(parts)


def _claim(row: dict[str, str]) -> str:
    table = _table(_CLAIM_COLUMNS, [[row[name] for name in _CLAIM_COLUMNS]])
    reason = f"\n{_escape(row['reason'])}\n" if row["reason"] else ""
    return f"### {row['statement']}\n\n{table}{reason}"


def api() -> str:
    """The public names by subject, from their docstrings."""
    missing = {*fivtui.__all__} - {name for names in _API.values() for name in names}
    assert missing == {"__version__"}, missing
    parts = []
    for title, names in _API.items():
        parts += [f"## {title}", *(_documented(name) for name in names)]
    return "\n\n".join(parts)


def _documented(name: str) -> str:
    value = getattr(fivtui, name)
    kind = "function" if inspect.isfunction(value) else "data"
    if inspect.isclass(value):
        kind = "exception" if issubclass(value, Exception) else "class"
    return f"```{{eval-rst}}\n.. auto{kind}:: fivtui.{name}\n```"


def results() -> str:
    """The classes of results that public functions return, from their docstrings."""
    classes = dict.fromkeys(_result_classes())
    return "\n\n".join(
        f"## {cls.__name__}\n\n```{{eval-rst}}\n.. autoclass:: {cls.__module__}.{cls.__name__}\n"
        "   :members:\n   :inherited-members:\n   :exclude-members: data_name\n```"
        for cls in classes
    )


def _result_classes() -> Iterator[type[Any]]:
    for name in fivtui.__all__:
        function = getattr(fivtui, name)
        if inspect.isfunction(function):
            yield from _classes(_returned(function))


def _returned(function: Any) -> Any:
    module = inspect.getmodule(function)
    assert module is not None
    annotation = inspect.signature(function).return_annotation
    return eval(annotation, vars(module)) if isinstance(annotation, str) else annotation  # noqa: S307


def _classes(annotation: Any) -> Iterator[type[Any]]:
    for argument in typing.get_args(annotation):
        yield from _classes(argument)
    if inspect.isclass(annotation) and dataclasses.is_dataclass(annotation):
        yield annotation


def _columns(columns: Iterable[Column]) -> str:
    return _table(
        ("column", "unit", "meaning"),
        ((f"`{column.name}`", column.unit or "–", column.meaning) for column in columns),
    )


def _formula(symbol: str) -> str:
    letter, _, subscript = symbol.partition("_")
    return f"${letter}_{{{subscript}}}$" if subscript else f"${letter}$"


def _named(header: Sequence[str], rows: Iterable[tuple[str, str]]) -> str:
    return _table(header, ((f"`{name}`", text) for name, text in rows))


def _table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [header, ["---"] * len(header), *([*map(_escape, row)] for row in rows)]
    return "".join(f"| {' | '.join(cells)} |\n" for cells in lines)


def _escape(text: str) -> str:
    return text.replace("|", r"\|").replace("\n", " ")
