"""Decoder of sixel, for tests of pictures in terminals."""

import re

import numpy as np
from numpy.typing import NDArray

SIXEL = re.compile(r'\x1bP0;1q"1;1;(\d+);(\d+)([^\x1b]*)\x1b\\')
_COMMAND = re.compile(r"#(\d+);2;(\d+);(\d+);(\d+)|#(\d+)|!(\d+)([?-~])|([?-~])|([$-])")


def decode_sixel(text: str) -> NDArray[np.int64]:
    """The RGB pixels of a picture, shape (height, width, 3); -1 where it has none."""
    match = SIXEL.fullmatch(text)
    assert match is not None, text[:80]
    width, height, data = int(match[1]), int(match[2]), match[3]
    pixels = np.full((height, width, 3), -1)
    palette: dict[int, NDArray[np.int64]] = {}
    colour, column, top, end = 0, 0, 0, 0
    for command in _COMMAND.finditer(data):
        assert command.start() == end, data[end : end + 20]
        end = command.end()
        defined, red, green, blue, selected, repeats, repeated, single, move = command.groups()
        if defined:
            percents = np.array([int(red), int(green), int(blue)])
            palette[int(defined)] = np.rint(percents * 2.55).astype(np.int64)
        elif selected:
            colour = int(selected)
        elif move:
            column, top = 0, top + 6 * (move == "-")
        else:
            count, bits = int(repeats or 1), ord(repeated or single) - ord("?")
            for row in range(6):
                if bits >> row & 1:
                    pixels[top + row, column : column + count] = palette[colour]
            column += count
    assert end == len(data)
    return pixels
