"""Build an FMU: by pythonfmu from Python sources, or from the compiled native flavour.

An FMU is a ZIP archive of a model description, sources or binaries, and documentation. Equal
sources and an equal `SOURCE_DATE_EPOCH` give equal bytes.
"""

import hashlib
import re
import sys
import threading
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path, PurePosixPath
from typing import BinaryIO, Final, Self

from fivtui.io import check_output, check_suffix, output_path, temporary_folder, write_atomically
from fivtui.model import InputError, check_known

from .component import Component, documentation_files, reference_files
from .components import COMPONENTS, DEFAULT_COMPONENT
from .description import complete_description
from .native import native_files
from .terminals import pictures_and_terminals

SUFFIX: Final = ".fmu"
PYTHON: Final = "python"
NATIVE: Final = "native"
FLAVOURS: Final = (NATIVE, PYTHON)
_VERSIONS: Final = ("2", "3")
_DESCRIPTION: Final = "modelDescription.xml"
# A constant date and system in the archive keep its bytes independent of time and machine.
ZIP_DATE: Final = (1980, 1, 1, 0, 0, 0)
_UNIX_SYSTEM: Final = 3
# Held while an FMU's Python code is imported: importing changes `sys.path` and `sys.modules`.
IMPORT_LOCK: Final = threading.Lock()
# The `from` of an import from the project, after which the package of the bundle is inserted.
_PROJECT_IMPORT: Final = re.compile(r"^from (?=(?:fivtui|fmu_src)[. ])", re.MULTILINE)
_HASH_DIGITS: Final = 12
_WRAPPER_FOLDER: Final = "resources/pythonfmu/"
# Modules of pythonfmu that build FMUs, and the import of them in its `__init__.py`.
_BUILDER_MODULES: Final = ("__main__", "builder", "csvbuilder", "deploy", "osutil")
_BUILDER_IMPORT: Final = re.compile(rb"^from \.builder import .*\n", re.MULTILINE)
# Flags of the model description: whether a tool besides the FMU must run, and whether the state
# of an instance can be read, restored and stored as bytes.
_CAPABILITIES: Final = {
    "needsExecutionTool": False,
    "canGetAndSetFMUstate": True,
    "canSerializeFMUstate": True,
}


def build_fmu(
    path: str | Path,
    *,
    component: str = DEFAULT_COMPONENT,
    fmi: str = "2",
    flavour: str = NATIVE,
    platforms: Sequence[str] = (),
    sources: bool = False,
    force: bool = False,
) -> Path:
    """Build the FMU of a component.

    Parameters
    ----------
    path : str or Path
        The ``.fmu`` file to write.
    component : str
        One of `COMPONENTS`; the slider-belt model if not given.
    fmi : "2" or "3"
        FMI 2.0, or FMI 3.0 in the native flavour.
    flavour : "native" or "python"
        ``"native"``: compiled, for co-simulation and model exchange; needs no Python, and runs on
        `platforms` alone.
        ``"python"``: for co-simulation on Linux and Windows; needs Python where it runs.
    platforms : sequence of str
        Platforms of the native flavour: ``"linux64"``, ``"win64"``, ``"darwin64"``; by default the
        platform of this machine. Others need the package ziglang.
    sources : bool
        Whether to add the C files of the native flavour, to compile them on other platforms.
    force : bool
        Whether to replace an existing file.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        If the component or flavour is unknown, or FMI 3.0 is combined with the Python flavour; if
        the binary of the native flavour was not compiled at installation; if the name does not end
        in ``.fmu``, the folder cannot be written, or the file exists and `force` is not set.

    Examples
    --------
    >>> from fivtui import build_fmu
    >>> build_fmu("slider_belt.fmu").name
    'slider_belt.fmu'
    """
    check_known("flavour", flavour, FLAVOURS)
    if flavour != NATIVE and sources:
        raise InputError(f"sources: the {flavour} flavour has no C files")
    if flavour != NATIVE and platforms:
        raise InputError(f"platforms: the {flavour} flavour always includes Linux and Windows")
    definition = _find_component(component, fmi, flavour)
    target = output_path(path, force=force)
    check_suffix(target, "FMU", (SUFFIX,))
    check_output(target)
    if flavour == NATIVE:
        content = native_files(definition, fmi, platforms, with_sources=sources)
    else:
        with temporary_folder() as folder:
            content = _export_with_pythonfmu(folder, definition)
    content |= documentation_files(definition, is_native=flavour == NATIVE)
    content |= pictures_and_terminals(definition, fmi)
    content |= reference_files(definition.model, definition.reference_run())
    if flavour != NATIVE:
        incomplete = content.pop(_DESCRIPTION)
        content[_DESCRIPTION] = complete_description(incomplete, content, definition.variable_table)
    write_atomically(target, lambda file: _write_archive(file, content))
    return Path(path)


def _find_component(name: str, fmi: str, flavour: str) -> Component:
    check_known("component", name, COMPONENTS)
    if fmi not in _VERSIONS:
        raise InputError(f"FMI {fmi}: must be {' or '.join(_VERSIONS)}")
    if fmi != _VERSIONS[0] and flavour != NATIVE:
        raise InputError(f"FMI {fmi}: needs the {NATIVE} flavour, not the {flavour} flavour")
    return COMPONENTS[name]


def _export_with_pythonfmu(folder: Path, component: Component) -> dict[str, bytes]:
    # Files of the FMU that pythonfmu exports: content by name in the archive.
    from pythonfmu.builder import FmuBuilder

    bundle = Bundle.from_component(component)
    sources = folder / "sources"
    for name, text in bundle.sources.items():
        file = sources / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8", newline="\n")
    with IMPORT_LOCK, _restore_imports(bundle):
        exported = FmuBuilder.build_FMU(
            sources / f"{bundle.entry}.py",
            dest=folder / f"exported{SUFFIX}",
            project_files=[sources / bundle.package],
            **_CAPABILITIES,
        )
    with zipfile.ZipFile(exported) as archive:
        return _remove_builder({name: archive.read(name) for name in archive.namelist()})


def _remove_builder(content: dict[str, bytes]) -> dict[str, bytes]:
    # An FMU does not need pythonfmu's builder, whose import takes most of pythonfmu's loading time.
    init_file = f"{_WRAPPER_FOLDER}__init__.py"
    for name in _BUILDER_MODULES:
        del content[f"{_WRAPPER_FOLDER}{name}.py"]
    content[init_file] = _BUILDER_IMPORT.sub(b"", content[init_file])
    return content


@dataclass(frozen=True, slots=True)
class Bundle:
    """The Python sources of an FMU: its package, its entry module, and all texts by path.

    Modules of the same name collide in an interpreter that hosts several FMUs. The names of
    package and entry module therefore contain a hash of the sources.
    """

    package: str
    entry: str
    sources: dict[str, str]

    @classmethod
    def from_component(cls, component: Component) -> Self:
        """Copy the modules of a component from the installed sources."""
        texts = {
            f"{package.replace('.', '/')}/{name}.py": _read_source(package, name)
            for package, names in component.modules.items()
            for name in names
        }
        entry_text = _read_source("fmu_src.slave", component.entry)
        content = "\0".join(f"{path}\0{text}" for path, text in texts.items()) + entry_text
        digest = hashlib.sha256(content.encode()).hexdigest()[:_HASH_DIGITS]
        package, entry = f"fivtui_{digest}", f"fivtui_entry_{digest}"
        sources = {
            f"{package}/{path}": _rename_imports(text, package) for path, text in texts.items()
        }
        folders = {folder for path in sources for folder in PurePosixPath(path).parents[:-1]}
        sources |= {f"{folder}/__init__.py": "" for folder in folders}
        sources[f"{entry}.py"] = _rename_imports(entry_text, package)
        return cls(package, entry, sources)


def _read_source(package: str, name: str) -> str:
    return files(package).joinpath(f"{name}.py").read_text(encoding="utf-8")


def _rename_imports(text: str, package: str) -> str:
    return _PROJECT_IMPORT.sub(f"from {package}.", text)


@contextmanager
def _restore_imports(bundle: Bundle) -> Iterator[None]:
    # Undo the changes of the interpreter's import state that importing the bundle makes.
    path, cached, imported = sys.path[:], set(sys.path_importer_cache), set(sys.modules)
    dont_write_bytecode = sys.dont_write_bytecode
    sys.dont_write_bytecode = True
    try:
        yield
    finally:
        sys.dont_write_bytecode = dont_write_bytecode
        sys.path[:] = path
        for name in set(sys.modules) - imported:
            if name.partition(".")[0] in (bundle.package, bundle.entry):
                del sys.modules[name]
        for name in set(sys.path_importer_cache) - cached:
            sys.path_importer_cache.pop(name, None)


def _write_archive(file: BinaryIO, content: Mapping[str, bytes]) -> None:
    with zipfile.ZipFile(file, "w") as archive:
        for name in sorted(content, key=lambda name: (name != _DESCRIPTION, name)):
            entry = zipfile.ZipInfo(name, ZIP_DATE)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.create_system = _UNIX_SYSTEM
            entry.external_attr = (0o755 if name.startswith("binaries/") else 0o644) << 16
            archive.writestr(entry, content[name], compresslevel=9)
