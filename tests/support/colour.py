"""Colours as seen with colour vision deficiencies, their differences and contrasts."""

from collections.abc import Mapping
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]

# G. M. Machado et al. (2009), severity 1: linear sRGB as seen with each deficiency.
VISIONS: Final[Mapping[str, ArrayLike]] = {
    "normal": np.eye(3),
    "protanopia": [
        [0.152286, 1.052583, -0.204868],
        [0.114503, 0.786281, 0.099216],
        [-0.003882, -0.048116, 1.051998],
    ],
    "deuteranopia": [
        [0.367322, 0.860646, -0.227968],
        [0.280085, 0.672501, 0.047413],
        [-0.011820, 0.042940, 0.968881],
    ],
    "tritanopia": [
        [1.255528, -0.076749, -0.178779],
        [-0.078411, 0.930809, 0.147602],
        [0.004733, 0.691367, 0.303900],
    ],
}
# Linear sRGB to XYZ, and the white point D65.
_TO_XYZ: Final = np.array(
    [
        [0.4124564, 0.3575761, 0.1804375],
        [0.2126729, 0.7151522, 0.0721750],
        [0.0193339, 0.1191920, 0.9503041],
    ]
)
_WHITE: Final = np.array([0.95047, 1.0, 1.08883])


def linear_rgb(code: str) -> FloatArray:
    """Linear sRGB of a code such as ``#014dec``."""
    channels = np.frombuffer(bytes.fromhex(code[1:7]), dtype=np.uint8) / 255.0
    return np.where(channels <= 0.04045, channels / 12.92, ((channels + 0.055) / 1.055) ** 2.4)


def contrast(first: str, second: str) -> float:
    """Contrast ratio of two colours by WCAG 2, from 1 to 21."""
    low, high = sorted(float(_TO_XYZ[1] @ linear_rgb(code)) for code in (first, second))
    return (high + 0.05) / (low + 0.05)


def seen_lab(code: str, vision: str = "normal") -> FloatArray:
    """CIELAB coordinates of a colour as seen with a deficiency."""
    seen = np.clip(np.asarray(VISIONS[vision]) @ linear_rgb(code), 0.0, 1.0)
    ratio = _TO_XYZ @ seen / _WHITE
    x, y, z = np.where(ratio > 216 / 24389, np.cbrt(ratio), (24389 / 27 * ratio + 16) / 116)
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


def difference(first: FloatArray, second: FloatArray) -> float:
    """CIEDE2000 difference of two colours in CIELAB; 1 is just noticeable."""
    (l1, a1, b1), (l2, a2, b2) = first.tolist(), second.tolist()
    mean_chroma = 0.5 * (np.hypot(a1, b1) + np.hypot(a2, b2))
    stretch = 1.5 - 0.5 * np.sqrt(mean_chroma**7 / (mean_chroma**7 + 25.0**7))
    c1, c2 = np.hypot(stretch * a1, b1), np.hypot(stretch * a2, b2)
    h1, h2 = (np.degrees(np.arctan2(b, stretch * a)) % 360 for a, b in ((a1, b1), (a2, b2)))
    turn = (h2 - h1 + 180) % 360 - 180 if c1 * c2 else 0.0
    lightness, chroma = 0.5 * (l1 + l2), 0.5 * (c1 + c2)
    # The mean hue is on the shorter arc; without chroma of one colour it is that of the other.
    hue = (h1 + 0.5 * turn) % 360 if c1 * c2 else h1 + h2
    weight = 1.0 + sum(
        factor * np.cos(np.radians(multiple * hue + shift))
        for factor, multiple, shift in ((-0.17, 1, -30), (0.24, 2, 0), (0.32, 3, 6), (-0.2, 4, -63))
    )
    offset = (lightness - 50) ** 2
    dl = (l2 - l1) / (1 + 0.015 * offset / np.sqrt(20 + offset))
    dc = (c2 - c1) / (1 + 0.045 * chroma)
    dh = 2 * np.sqrt(c1 * c2) * np.sin(np.radians(turn / 2)) / (1 + 0.015 * chroma * weight)
    spread = 30 * np.exp(-(((hue - 275) / 25) ** 2))
    rotation = -2 * np.sqrt(chroma**7 / (chroma**7 + 25.0**7)) * np.sin(np.radians(2 * spread))
    return float(np.sqrt(dl**2 + dc**2 + dh**2 + rotation * dc * dh))
