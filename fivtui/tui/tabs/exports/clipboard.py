"""Copy figures to the clipboard of the desktop, by a program of the system."""

import os
import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final

from fivtui.io import temporary_folder
from fivtui.model import InputError

from .export import Export

# Time limit of the program that copies, s.
_TIMEOUT_S: Final = 20.0
_NO_PROGRAM: Final = (
    "a picture cannot be copied without a desktop and wl-copy (Wayland) or xclip (X11); "
    "the plot can be copied as text"
)


def copy_picture(export: Export) -> None:
    """Copy a figure to the clipboard as PNG; raises `InputError` if no program can do this."""
    with temporary_folder() as folder:
        path = folder / "picture.png"
        command = clipboard_command(path, sys.platform, os.environ)
        export.write(path)
        try:
            # Do not wait for output: the program provides the picture while in the background.
            none = subprocess.DEVNULL
            subprocess.run(  # noqa: S603, a program of the desktop
                command, stdin=none, stdout=none, stderr=none, timeout=_TIMEOUT_S, check=True
            )
        except subprocess.CalledProcessError:
            raise InputError(f"the picture is not copied: {command[0]} failed") from None
        except (OSError, subprocess.TimeoutExpired) as error:
            raise InputError(f"the picture is not copied: {error}") from None


def clipboard_command(path: Path, platform: str, environment: Mapping[str, str]) -> Sequence[str]:
    """The command that copies a PNG file on a platform; raises `InputError` without a program."""
    if platform == "darwin":
        script = f'set the clipboard to (read POSIX file "{path}" as «class PNGf»)'
        return ["osascript", "-e", script]
    if platform == "win32":
        load_assemblies = "Add-Type -AssemblyName System.Windows.Forms, System.Drawing"
        image = f"[System.Drawing.Image]::FromFile('{path}')"
        script = f"{load_assemblies}; [System.Windows.Forms.Clipboard]::SetImage({image})"
        return ["powershell", "-NoProfile", "-STA", "-Command", script]
    if environment.get("WAYLAND_DISPLAY") and shutil.which("wl-copy"):
        return ["sh", "-c", 'exec wl-copy --type image/png < "$0"', str(path)]
    if environment.get("DISPLAY") and shutil.which("xclip"):
        return ["xclip", "-selection", "clipboard", "-target", "image/png", "-in", str(path)]
    raise InputError(_NO_PROGRAM)
