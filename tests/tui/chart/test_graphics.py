"""Pictures as text for terminals are read back as the same pixels."""

import base64
import re
import zlib

import numpy as np
import pytest

from fivtui.tui.chart.graphics import encode_kitty, encode_sixel
from tests.support.sixel import decode_sixel

# Sixel has colours in percent, which are 2.55 of 255 apart.
ROUNDING = 2


@pytest.mark.parametrize("height", [1, 5, 6, 13])
def test_sixel_has_the_pixels_of_a_picture_of_few_colours(height: int) -> None:
    colours = np.array([[18, 18, 18], [1, 120, 212], [255, 166, 43]], dtype=np.uint8)
    pixels = colours[np.random.default_rng(1).integers(3, size=(height, 40))]
    pixels[:, 10:30] = colours[0]
    decoded = decode_sixel(encode_sixel(pixels))
    assert decoded.min() >= 0
    assert np.abs(decoded - pixels).max() <= ROUNDING


def test_sixel_replaces_rare_colours_by_near_ones() -> None:
    ramp = np.linspace(0, 255, 120).astype(np.uint8)
    pixels = np.stack(np.broadcast_arrays(ramp[:, None], ramp[None, :], ramp[0]), axis=-1)
    decoded = decode_sixel(encode_sixel(pixels))
    assert len(np.unique(decoded.reshape(-1, 3), axis=0)) <= 255
    assert np.abs(decoded - pixels).mean() < 20.0


def test_kittys_graphics_have_the_pixels_in_chunks() -> None:
    pixels = np.random.default_rng(2).integers(256, size=(40, 60, 3), dtype=np.uint8)
    text = encode_kitty(pixels, 7, 6, 2)
    chunks = re.findall(r"\x1b_G([^;]*);([^\x1b]*)\x1b\\", text)
    assert "".join(f"\x1b_G{keys};{data}\x1b\\" for keys, data in chunks) == text
    assert {"a=T", "i=7", "f=24", "o=z", "s=60", "v=40", "c=6", "r=2"} <= set(
        chunks[0][0].split(",")
    )
    assert all(len(data) <= 4096 for _, data in chunks)
    assert [keys[-3:] for keys, _ in chunks] == ["m=1"] * (len(chunks) - 1) + ["m=0"]
    data = zlib.decompress(base64.b64decode("".join(data for _, data in chunks)))
    assert data == pixels.tobytes()
