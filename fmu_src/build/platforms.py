"""The platforms that binaries are compiled for: those in FMUs, and those in wheels.

The build hook imports this module, so it imports only the standard library.
"""

from collections.abc import Mapping
from typing import Final, NamedTuple


class Platform(NamedTuple):
    """A platform that binaries can be compiled for."""

    # The compiler's name for it, and the suffix of binaries.
    triple: str
    suffix: str
    # Folders of the binary in an FMU: FMI 2.0 and 3.0.
    folders: tuple[str, str]
    # The platform in the name of a wheel; empty if none is published.
    wheel_tag: str = ""
    # Folder of the same system on x86, to which a binary for 64-bit ARM is also copied: FMI before
    # 2.0.4 named no folder for ARM, and many importers look in this one. Empty for x86.
    x86_folder: str = ""

    @property
    def is_x86(self) -> bool:
        """Whether its processor is a 64-bit x86."""
        return self.triple.startswith("x86_64")


PLATFORMS: Final[Mapping[str, Platform]] = {
    "linux64": Platform(
        "x86_64-linux-gnu.2.17", ".so", ("linux64", "x86_64-linux"), "manylinux_2_17_x86_64"
    ),
    "win64": Platform("x86_64-windows-gnu", ".dll", ("win64", "x86_64-windows"), "win_amd64"),
    "darwin64": Platform(
        "x86_64-macos.11.0", ".dylib", ("darwin64", "x86_64-darwin"), "macosx_11_0_x86_64"
    ),
    "aarch64-linux": Platform(
        "aarch64-linux-gnu.2.17",
        ".so",
        ("aarch64-linux", "aarch64-linux"),
        "manylinux_2_17_aarch64",
        "linux64",
    ),
    "aarch64-darwin": Platform(
        "aarch64-macos.11.0",
        ".dylib",
        ("aarch64-darwin", "aarch64-darwin"),
        "macosx_11_0_arm64",
        "darwin64",
    ),
    "aarch64-windows": Platform(
        "aarch64-windows-gnu",
        ".dll",
        ("aarch64-windows", "aarch64-windows"),
        x86_folder="win64",
    ),
}
# Platforms on which fivtui may run: name in `PLATFORMS` by `sys.platform` and processor.
HOSTS: Final[Mapping[tuple[str, str], str]] = {
    ("linux", "x86_64"): "linux64",
    ("linux", "aarch64"): "aarch64-linux",
    ("darwin", "x86_64"): "darwin64",
    ("darwin", "arm64"): "aarch64-darwin",
    ("win32", "amd64"): "win64",
    ("win32", "arm64"): "aarch64-windows",
}
