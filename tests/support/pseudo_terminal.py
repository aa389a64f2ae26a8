"""A laboratory in a pseudo-terminal, on systems that have these."""

import fcntl
import os
import pty
import struct
import subprocess
import sys
import termios
from collections.abc import Mapping


def start_laboratory(
    environment: Mapping[str, str], rows: int, columns: int, cell_pixels: tuple[int, int] = (0, 0)
) -> tuple[subprocess.Popen[bytes], int]:
    """The process, and the descriptor of the side that reads its screen and sends it keys.

    It does not control the terminal, so that its process starts without a fork of this one, which
    may stop for ever while threads of numerical libraries compute.
    """
    controller, terminal = pty.openpty()
    width, height = cell_pixels
    size = struct.pack("HHHH", rows, columns, columns * width, rows * height)
    fcntl.ioctl(terminal, termios.TIOCSWINSZ, size)
    process = subprocess.Popen(
        [sys.executable, "-m", "fivtui"],
        stdin=terminal,
        stdout=terminal,
        stderr=terminal,
        start_new_session=True,
        env={**environment, "TERM": "xterm-256color"},
    )
    os.close(terminal)
    return process, controller
