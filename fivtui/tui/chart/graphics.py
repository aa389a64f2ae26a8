"""Pictures as text for terminals, in sixel or kitty's graphics protocol. Imports no Textual."""

import re
import zlib
from base64 import b64encode
from collections.abc import Iterator
from typing import Final

import numpy as np
from numpy.typing import NDArray

Pixels = NDArray[np.uint8]

# Ask for the pixels of a character cell; also for support of kitty's protocol, and for the
# attributes of the terminal, which all terminals answer.
CELL_QUERY: Final = "\x1b[16t"
GRAPHICS_QUERY: Final = f"\x1b_Gi=31,s=1,v=1,a=q,t=d,f=24;AAAA\x1b\\{CELL_QUERY}\x1b[c"
# Attribute of terminals that understand sixel.
SIXEL_ATTRIBUTE: Final = "4"
# Registers for colours, which all terminals with sixel have.
_MAX_COLOURS: Final = 255
# Pixels in a sixel, one above the other.
_SIXEL_HEIGHT: Final = 6
_SIXEL_BITS: Final = (1 << np.arange(_SIXEL_HEIGHT)).astype(np.uint8)
# The character for no pixels.
_NO_PIXELS: Final = b"?"
_REPEATED: Final = re.compile(rb"(.)\1{3,}", re.DOTALL)
# Characters of kitty's data in one command.
_CHUNK: Final = 4096


def encode_sixel(pixels: Pixels) -> str:
    """RGB pixels, shape (height, width, 3), as sixel from the position of the terminal's cursor."""
    # Imported late, because Pillow loads slowly.
    from PIL import Image

    height, width, _ = pixels.shape
    image = Image.fromarray(pixels).quantize(_MAX_COLOURS, method=Image.Quantize.FASTOCTREE)
    palette = np.rint(np.reshape(image.getpalette() or (), (-1, 3)) / 2.55).astype(int).tolist()
    colours = "".join(
        f"#{number};2;{red};{green};{blue}" for number, (red, green, blue) in enumerate(palette)
    )
    # The index of padding is that of no colour.
    padding = -height % _SIXEL_HEIGHT
    indices = np.pad(np.asarray(image), ((0, padding), (0, 0)), constant_values=_MAX_COLOURS)
    bands = indices.reshape(-1, _SIXEL_HEIGHT, width)
    data = b"-".join(b"$".join(_encode_band(band)) for band in bands)
    return f'\x1bP0;1q"1;1;{width};{height}{colours}{data.decode()}\x1b\\'


def _encode_band(band: Pixels) -> Iterator[bytes]:
    # The sixels of each colour in a row of sixels.
    for number in np.flatnonzero(np.bincount(band.ravel())[:_MAX_COLOURS]):
        sixels = _SIXEL_BITS @ (band == number) + ord(_NO_PIXELS)
        line = sixels.tobytes().rstrip(_NO_PIXELS)
        # Sixels that are repeated follow their number.
        line = _REPEATED.sub(lambda match: b"!%d%b" % (len(match[0]), match[1]), line)
        yield b"#%d" % number + line


def encode_kitty(pixels: Pixels, number: int, columns: int, rows: int) -> str:
    """RGB pixels in kitty's protocol, scaled to character cells from the cursor's position."""
    height, width, _ = pixels.shape
    data = b64encode(zlib.compress(pixels.tobytes(), 6)).decode()
    chunks = [data[start : start + _CHUNK] for start in range(0, len(data), _CHUNK)]
    keys = f"a=T,i={number},p=1,f=24,o=z,s={width},v={height},c={columns},r={rows},C=1,q=2,"
    return "".join(
        f"\x1b_G{keys if index == 0 else ''}m={int(index < len(chunks) - 1)};{chunk}\x1b\\"
        for index, chunk in enumerate(chunks)
    )


def delete_kitty(number: int) -> str:
    """The command that removes a picture in kitty's protocol."""
    return f"\x1b_Ga=d,d=I,i={number},q=2\x1b\\"
