"""Random command lines over all commands and options, with unusual values.

`create_files` creates the files that the lines name. The probabilities of the random choices give
many lines of each kind: valid ones, and ones with unusual values, missing values or options.
"""

import os
import random
import zipfile
from collections.abc import Iterator, Sequence
from pathlib import Path

import click

from fivtui.cli import commands

# Slow commands, and the server, always get an invalid argument.
SLOW = {
    "attractors", "claims", "compare", "extremes", "figures", "serve", "tradeoff", "tui", "build",
    "system", "accuracy", "methods", "uncertainty", "animate",
}  # fmt: skip
INVALID_OPTIONS = ("--colour", "--colour=red", "-q", "--force=3", "--\x00")

VALID_VALUES = {
    "--set": ("F=60", "mu=0.3", "k_nl=20", "m=4", "c1=0.1"),
    "--t-end": ("0.5", "1"),
    "--tol": ("1e-8", "1e-3"),
    "--step": ("0.01",),
    "--method": ("taylor", "rk4"),
    "--start": ("static", "0,0,-0.5,0"),
    "--sensitivity": ("mu", "F"),
    "--points": ("11", "2"),
    "--out": ("a.csv", "b.npz", "c.json", "d.CSV", "mine.csv"),
    "--plot": ("p.gif", "mine.csv"),
    "--error": ("peak=1e-2",),
    "--vary": ("F=20:40:2", "mu=0.1,0.2", "y0=-1:0:2", "mu~uniform:0:1"),
    "--from": ("hopf", "cycle"),
    "--design": ("product", "list"),
    "--output": ("stable", "growth_rate"),
    "--over": ("F=1:2:2", "mu=0:1:3"),
    "--value": ("growth-rate", "critical-mu", "safe-mu", "coexistence"),
    "--flavour": ("native", "python"),
    "--basin": ("y0=-1:0:2", "vy0=-1:1:2"),
    "--window": ("0:0.5", "0.1:0.2"),
    "--speed": ("1", "0.1"),
    "--factor": ("10", "100"),
    "--signal": ("vy", "P"),
    "--measured": ("mine.csv", "table.csv"),
    "--band": ("0.1", "5%"),
    "--input": ("mine.csv", "table.csv"),
}
SCENES = ("base", "linear", "own.toml", "bare.toml")
FILES = ("text.fmu", "empty.fmu", "bare.fmu", "odd.fmu", "pipe.fmu", "folder.fmu", "absent.fmu")
UNUSUAL_VALUES = (
    "", " ", "\t", "x" * 5000, "1" * 100_000, "a" * 300 + ".csv", "1_0", "F=1_0", "٣", "F=٣", "１",
    "nan", "inf", "-inf", "F=nan", "1e400", "1e-400", "0x10", "1e308", "-1", "0", "-0", "1e-13",
    "9" * 5000, "+", "--", "-", "---", "\n", "a\nb", "a\nb.csv", "F=1\n2", "\x1b[31m", "\udcff",
    "\udcff.csv", "/dev/zero", "/dev/null", "/dev/full", "pipe.toml", "pipe.csv", "folder",
    "folder/", "folder/x.csv", "missing/x.csv", "missing.toml", "deep.toml", "binary.toml",
    "long.toml", "dots.toml", "wrong.toml", "huge.toml", "names.toml", "=", "=1", "F", "F=", "F==1",
    "F=1=2", "F=1,2", "F=80", "F=60", "f=1", "knl=1", "1:2:3", "F=1:2:1e3", "F=2:1:3:log:log",
    "F=1:2:1_0", "F=0:1:3:log", "x0=0:1:2", "F=1:1:2", "F=1:2:99999999999", "%s%n", "{0}", "[/red]",
    "[bold]", "$HOME", "~", "a,b,c,d", "1,2,3,4,5", "0,0,0,", "NaN,0,0,0", "1_0,0,0,0", "é", "😀",
    "peak", "peak=0", "final=2", "peak=1_0", "events=1e-3", "mine.csv", "mine.toml", ".", "..", "/",
    "C:\\x", "taylor", "fmu", "sobol", "1" * 400 + "." + "1" * 400, "2-", "1", "17",
)  # fmt: skip


def create_files(folder: Path) -> None:
    """Create the files that the command lines name: readable and unreadable ones."""
    texts = {
        "own.toml": "fivtui_scene = 1\nt_end = 0.5\n[parameters]\nF = 33.0\n",
        "bare.toml": "fivtui_scene = 1\nt_end = 1\n",
        "wrong.toml": "fivtui_scene = 1\nname = 3\n",
        "dots.toml": f"fivtui_scene = 1\n{'.'.join('a' * 20_000)} = 1\n",
        "deep.toml": f"fivtui_scene = 1\naccuracy.{'.'.join('a' * 1500)} = 1\n",
        "long.toml": f"fivtui_scene = 1\nname = '{'x' * 3000}'\n",
        "huge.toml": "#" * (1 << 20) + "\n#\n",
        "names.toml": 'fivtui_scene = 1\nname = "a\\nb"\n',
        "mine.csv": "mine",
        "mine.toml": "mine",
        "table.csv": "time,F\n0,80\n1_0,80\n",
        "text.fmu": "mine",
        "empty.fmu": "",
    }
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8")
    (folder / "binary.toml").write_bytes(bytes(range(256)))
    for name, member in (("bare.fmu", "a"), ("odd.fmu", "modelDescription.xml")):
        with zipfile.ZipFile(folder / name, "w") as archive:
            archive.writestr(member, "<fmiModelDescription/>")
    for name in ("pipe.toml", "pipe.csv", "pipe.fmu"):
        os.mkfifo(folder / name)
    for name in ("folder", "folder.fmu"):
        (folder / name).mkdir()


def lines(seed: int, count: int) -> Iterator[list[str]]:
    """Reproducible random command lines."""
    rng = random.Random(seed)
    paths = list(_commands(commands, ()))
    for _ in range(count):
        names, command = rng.choice(paths)
        yield [*names, *_arguments(rng, names, command)]


def _commands(
    group: click.Group, names: tuple[str, ...]
) -> Iterator[tuple[tuple[str, ...], click.Command]]:
    for name, command in group.commands.items():
        if isinstance(command, click.Group):
            yield from _commands(command, (*names, name))
        else:
            yield (*names, name), command
    yield names, group


def _arguments(rng: random.Random, names: Sequence[str], command: click.Command) -> list[str]:
    # Each group is an option with its value, or an operand.
    groups: list[list[str]] = []
    for parameter in command.params:
        is_needed = parameter.required and rng.random() < 0.9
        repetitions = max(rng.choice((0, 0, 0, 0, 1, 1, 1, 1, 2)), int(is_needed))
        groups += [_option_arguments(rng, parameter) for _ in range(repetitions)]
    has_extra_operand = rng.random() < 0.05
    if has_extra_operand:
        groups.append([rng.choice(UNUSUAL_VALUES)])
    rng.shuffle(groups)
    arguments = [argument for group in groups for argument in group]
    if arguments and rng.random() < 0.05:
        # Leave out the last value.
        arguments.pop()
    if not names or names[-1] in SLOW or "--attractors" in arguments:
        # Put the wrong option first: `--` would turn it into an operand.
        arguments = [rng.choice(INVALID_OPTIONS), *arguments]
    return arguments


def _option_arguments(rng: random.Random, parameter: click.Parameter) -> list[str]:
    is_unusual = rng.random() < 0.25
    if isinstance(parameter, click.Argument):
        valid = FILES if parameter.name == "fmu_file" else SCENES
        return [rng.choice(UNUSUAL_VALUES if is_unusual else valid)]
    flag = parameter.opts[0]
    if isinstance(parameter, click.Option) and parameter.is_flag:
        return [flag]
    value = rng.choice(UNUSUAL_VALUES if is_unusual else VALID_VALUES.get(flag, ("1", "2")))
    return [f"{flag}={value}"] if rng.random() < 0.3 else [flag, value]
