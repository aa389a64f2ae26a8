"""Printed tables: no column is lost at any terminal width.

A wide table is printed in blocks of columns. Each begins with the keys, the first columns, which
identify a row.
"""

import io
import re
import sys

import numpy as np
import pytest

from fivtui.console.layout import GAP, TableColumn, split_columns
from fivtui.console.printing import print_list, print_rows
from fivtui.model import System
from fivtui.model.parameters import Parameters
from fivtui.orbits.attractor_continuation import BranchPoint, Continuation
from fivtui.orbits.explorer import Explorer
from fivtui.orbits.report import print_attractors, print_continuation
from fivtui.sweeps.design import Design
from fivtui.sweeps.report import print_sweep
from fivtui.sweeps.run import local_engine, sweep_in_memory
from fivtui.sweeps.study import Study

WIDTHS = [20, 40, 60, 80, 120, 200]


class Terminal(io.StringIO):
    """Output that claims to be a terminal; its value has no escape sequences."""

    def isatty(self) -> bool:
        return True

    def getvalue(self) -> str:
        return re.sub(r"\x1b\[[0-9;]*m", "", super().getvalue())


def redirect_output(monkeypatch: pytest.MonkeyPatch, columns: int | None) -> io.StringIO:
    """Redirect stdout to a terminal of some columns, or to no terminal if None."""
    stream = io.StringIO() if columns is None else Terminal()
    monkeypatch.setattr(sys, "stdout", stream)
    monkeypatch.setenv("COLUMNS", str(columns))
    monkeypatch.setenv("TERM", "xterm")
    return stream


def make_table(columns: int, rows: int) -> tuple[list[str], list[list[str]]]:
    header = [f"name{column} of it" for column in range(columns)]
    return header, [[f"r{row}c{column}" for column in range(columns)] for row in range(rows)]


@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("keys", [1, 2, 9])
def test_every_cell_is_printed_within_the_width_after_its_key(
    width: int, keys: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    header, rows = make_table(12, 3)
    out = redirect_output(monkeypatch, width)
    print_rows("Title", header, rows, keys=keys)
    lines = out.getvalue().splitlines()
    assert max(map(len, lines)) <= width
    for number, row in enumerate(rows, start=1):
        for cell in row:
            first_cells = [line.split()[0] for line in lines if cell in line.split()]
            assert first_cells
            assert set(first_cells) <= {row[0], str(number)}


def test_the_first_column_is_repeated_in_every_block(monkeypatch: pytest.MonkeyPatch) -> None:
    header, rows = make_table(12, 2)
    out = redirect_output(monkeypatch, 40)
    print_rows("", header, rows)
    blocks = [block.strip() for block in re.split(r"\n\s*\n", out.getvalue().strip())]
    assert len(blocks) > 2
    assert all("r0c0" in block and "r1c0" in block for block in blocks)


def test_a_table_that_fits_is_one_block() -> None:
    columns = [TableColumn(f"c{number}", ("1", "2")) for number in range(5)]
    width = 5 * 2 + 4 * GAP
    assert len(split_columns(columns, 1, width)) == 1
    assert len(split_columns(columns, 1, width - 1)) == 2
    assert len(split_columns(columns, 1, None)) == 1


def test_keys_that_leave_no_room_are_replaced_by_the_numbers_of_rows() -> None:
    columns = [TableColumn(f"key{number}", ("1234567890",) * 3) for number in range(4)]
    columns.append(TableColumn("value", ("1", "2", "3")))
    blocks = split_columns(columns, 4, 40)
    assert {block[0][0].name for block in blocks} == {"row"}
    assert [column.name for block in blocks for column, _ in block[1:]] == [
        column.name for column in columns
    ]


def test_running_text_is_folded_and_not_cut(monkeypatch: pytest.MonkeyPatch) -> None:
    text = " ".join(f"word{number}" for number in range(60))
    out = redirect_output(monkeypatch, 40)
    print_rows("", ("name", "reason"), [("a", text)])
    print_list("", [("a name that is rather long", text)])
    tokens = out.getvalue().split()
    assert all(tokens.count(token) == 2 for token in text.split())
    assert max(map(len, out.getvalue().splitlines())) <= 40


def test_without_a_terminal_nothing_is_wrapped(monkeypatch: pytest.MonkeyPatch) -> None:
    header, rows = make_table(60, 2)
    out = redirect_output(monkeypatch, None)
    print_rows("Title", header, rows)
    title, names, *cells = out.getvalue().splitlines()
    assert (title, len(cells)) == ("Title", 2)
    assert re.split(r" {2,}", names.strip()) == header


def test_sweep_and_attractors_keep_their_first_columns(monkeypatch: pytest.MonkeyPatch) -> None:
    p = Parameters()
    varied = Design({"F": (21.0, 43.0), "mu": (0.1,)})
    study = Study(varied, p, outputs=("growth_rate", "stable"))
    result = sweep_in_memory(study, local_engine(workers=1))
    # The attractor of the motion from the static start, as a continuation to larger μ finds it.
    attractor = Explorer(System(p)).reach("static")
    point = BranchPoint(value=0.7, directions=("up",), attractor=attractor)
    branch = Continuation(System(p), "mu", np.array([0.7]), (point,))
    for width in (40, 60, 80, 120, None):
        out = redirect_output(monkeypatch, width)
        print_sweep(result)
        print_attractors([attractor])
        print_continuation(branch)
        lines = out.getvalue().splitlines()
        assert width is None or max(map(len, lines)) <= width
        tokens = out.getvalue().split()
        # The column `reason` is printed only if a member failed.
        assert {column.name for column in study.columns} - {"reason"} <= set(tokens)
        # The members F = 21 and F = 43 appear in each block of the sweep, below its keys: F, mu and
        # separation.
        blocks = sum({"mu", "separation"} <= set(line.split()) for line in lines)
        assert sum(line.split()[:2] == ["21", "0.1"] for line in lines) == blocks >= 1
        assert sum(line.split()[:2] == ["43", "0.1"] for line in lines) == blocks
        assert str(attractor.kind).split()[0] in tokens
        # The last column of attractors is "multipliers, size".
        assert "multipliers," in tokens
