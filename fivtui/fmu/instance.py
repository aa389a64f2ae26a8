"""FMU files and instances: loaded by fmpy, with their log and without side effects here."""

import filecmp
import itertools
import logging
import os
import signal
import sys
import threading
import zipfile
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from ctypes import byref
from functools import lru_cache
from pathlib import Path
from typing import Any, Final

from fivtui.io import MAX_TABLE, opened
from fivtui.model import ComputationError, InputError
from fmu_src.build import IMPORT_LOCK

from .folders import Folder, folder_for

# FMI statuses.
_WARNING: Final = 1
_FATAL: Final = 4
_MAX_MESSAGES: Final = 20
_DESCRIPTION: Final = "modelDescription.xml"

_identifiers = itertools.count(1)
_listeners: dict[int, "Messages"] = {}
# FMUs of this project also log refusals here. Filter those that the host already receives.
_LOGGER: Final = logging.getLogger("fivtui.fmu")


class Messages:
    """Log of the warnings and failed calls of one FMU instance, newest last."""

    def __init__(self) -> None:
        self._failures: deque[str] = deque(maxlen=_MAX_MESSAGES)
        self._warnings: deque[str] = deque(maxlen=_MAX_MESSAGES)

    def log(self, status: int, message: bytes) -> None:
        """Store a message unless its FMI status is success."""
        if status >= _WARNING:
            messages = self._warnings if status == _WARNING else self._failures
            messages.append(" ".join(message.decode("utf-8", "replace").split()))

    @property
    def last(self) -> str:
        """The newest message on one line, or an empty string."""
        return self._failures[-1] if self._failures else ""

    @property
    def warnings(self) -> tuple[str, ...]:
        """The newest warnings, each different one once, on one line."""
        return tuple(dict.fromkeys(self._warnings))


class FmuFile:
    """An extracted FMU: its path, the folder of its files, and fmpy's model description."""

    def __init__(self, path: Path, folder: Folder, description: Any) -> None:
        self.path = path
        self.folder = folder.path
        self.description = description
        self._folder = folder

    def spoil(self) -> None:
        """Have the next run load the FMU's library again."""
        self._folder.spoilt = True


@contextmanager
def extracted(path: Path) -> Iterator[FmuFile]:
    """Extract an FMU for the duration of a context."""
    check_archive(path)
    with ExitStack() as stack:
        try:
            folder = stack.enter_context(folder_for(path))
            description = _extracted_to(folder.path, path)
        except OSError as error:
            raise InputError(f"{path}: cannot be extracted: {error.strerror or error}") from None
        yield FmuFile(path, folder, description)


def _extracted_to(folder: str, path: Path) -> Any:
    import fmpy

    try:
        fmpy.extract(path, folder)
        return fmpy.read_model_description(folder, validate=False)
    except OSError:
        raise
    except Exception as error:  # noqa: BLE001
        raise InputError(f"{path}: is not an FMU: {' '.join(str(error).split())}") from None


def check_archive(path: Path) -> None:
    """Check that a file is a zip archive with a model description; `InputError` if not."""
    with opened(path) as file:
        try:
            with zipfile.ZipFile(file) as archive:
                sizes = {entry.filename: entry.file_size for entry in archive.infolist()}
        except (zipfile.BadZipFile, ValueError, NotImplementedError):
            raise InputError(f"{path}: is not an FMU: not a zip archive") from None
    if sum(sizes.values()) > MAX_TABLE:
        raise InputError(f"{path}: must be of at most {MAX_TABLE >> 30} GiB when extracted")
    if _DESCRIPTION not in sizes:
        raise InputError(f"{path}: is not an FMU: it holds no {_DESCRIPTION}")


@contextmanager
def instantiated(fmu: FmuFile) -> Iterator[tuple[Any, Messages]]:
    """One co-simulation instance of an FMU (FMI 2.0 or 3.0), freed when the context ends.

    The host's working directory and module path are restored.
    """
    make = _maker(fmu)
    identifier, messages = next(_identifiers), Messages()
    _listeners[identifier] = messages
    instance, fatal = None, False
    unprinted = _unprinted(identifier)
    _LOGGER.addFilter(unprinted)
    try:
        with IMPORT_LOCK, _process_restored():
            instance = _instance_of(fmu, lambda: make(identifier, messages), messages)
        yield instance, messages
    except Exception as error:
        causes = (error, error.__context__)
        fatal = any(getattr(cause, "status", None) == _FATAL for cause in causes)
        raise
    finally:
        if fatal:
            fmu.spoil()
        elif instance is not None:
            with suppress(Exception):
                instance.freeInstance()
        _LOGGER.removeFilter(unprinted)
        del _listeners[identifier]


def _name_of(identifier: int) -> str:
    return f"fivtui-{identifier}"


def _unprinted(identifier: int) -> Callable[[logging.LogRecord], bool]:
    name = _name_of(identifier)
    return lambda record: getattr(record, "fmu_instance", None) != name


@contextmanager
def _process_restored() -> Iterator[None]:
    # The wrapper of a Python FMU extends the module path; fmpy changes the working directory.
    path, directory = sys.path[:], Path.cwd()
    try:
        yield
    finally:
        sys.path[:] = path
        os.chdir(directory)


def _instance_of(fmu: FmuFile, make: Callable[[], Any], messages: Messages) -> Any:
    try:
        return make()
    except Exception as error:  # noqa: BLE001
        why = messages.last or " ".join(str(error).split())
        raise ComputationError(
            f"{fmu.path}: the FMU cannot be instantiated: {why}", "check it: fivtui fmu check"
        ) from None


def has_binary(fmu: FmuFile) -> bool:
    """Whether an FMU has a binary for this platform."""
    import fmpy

    is_3 = fmu.description.fmiVersion.startswith("3.")
    binaries = Path(fmu.folder, "binaries")
    folder = binaries / (fmpy.platform_tuple if is_3 else fmpy.platform)
    # The x86 folder may contain a copy of the ARM binary.
    arm = binaries / f"aarch64-{fmpy.system}"
    foreign = fmpy.architecture != "aarch64"

    def is_for_arm(file: Path) -> bool:
        twin = arm / file.name
        return twin.is_file() and filecmp.cmp(file, twin, shallow=False)

    files = folder.glob(f"*{fmpy.sharedLibraryExtension}")
    return any(not (foreign and is_for_arm(file)) for file in files)


def _maker(fmu: FmuFile) -> Callable[[int, Messages], Any]:
    import fmpy

    version = fmu.description.fmiVersion
    if fmu.description.coSimulation is None:
        raise InputError(f"{fmu.path}: is not for co-simulation")
    if not has_binary(fmu):
        raise InputError(f"{fmu.path}: has no binary for this platform, {fmpy.platform}")
    if version == "2.0":
        return lambda identifier, _: _instantiate_fmi2(fmu, identifier)
    if version.startswith("3."):
        return lambda _, messages: _instantiate_fmi3(fmu, messages)
    raise InputError(f"{fmu.path}: is of FMI {version}; FMI 2.0 or 3.0 is needed")


def _instantiate_fmi2(fmu: FmuFile, identifier: int) -> Any:
    from fmpy.fmi2 import (
        FMU2Slave,
        calloc,
        fmi2CallbackAllocateMemoryTYPE,
        fmi2CallbackFreeMemoryTYPE,
        fmi2CallbackFunctions,
        free,
    )
    from fmpy.logging import addLoggerProxy

    callbacks = fmi2CallbackFunctions()
    callbacks.logger = _dispatcher()
    callbacks.allocateMemory = fmi2CallbackAllocateMemoryTYPE(calloc)
    callbacks.freeMemory = fmi2CallbackFreeMemoryTYPE(free)
    callbacks.componentEnvironment = identifier
    addLoggerProxy(byref(callbacks))
    description = fmu.description
    instance = FMU2Slave(
        guid=description.guid,
        modelIdentifier=description.coSimulation.modelIdentifier,
        unzipDirectory=fmu.folder,
        instanceName=_name_of(identifier),
    )
    instance.instantiate(callbacks=callbacks, loggingOn=True)
    return instance


@lru_cache(maxsize=1)
def _dispatcher() -> Any:
    # fmpy has one logger for the whole process, which must serve all instances and outlive them.
    from fmpy.fmi1 import printLogMessage
    from fmpy.fmi2 import fmi2CallbackLoggerTYPE

    def log(
        environment: int | None, name: bytes, status: int, category: bytes, message: bytes
    ) -> None:
        if environment in _listeners:
            _listeners[environment].log(status, message)
        else:
            printLogMessage(environment, name, status, category, message)

    return fmi2CallbackLoggerTYPE(log)


def _instantiate_fmi3(fmu: FmuFile, messages: Messages) -> Any:
    import fmpy

    return fmpy.instantiate_fmu(
        fmu.folder,
        fmu.description,
        fmi_type="CoSimulation",
        debug_logging=True,
        logger=lambda _environment, status, _category, message: messages.log(status, message),
    )


@contextmanager
def interrupts_deferred() -> Iterator[Callable[[], None]]:
    """Defer Ctrl-C while the FMU runs, where an exception would corrupt it.

    Yields a function to call between calls of the FMU; it raises a deferred KeyboardInterrupt.
    """
    previous = signal.getsignal(signal.SIGINT)
    main = threading.current_thread() is threading.main_thread()
    if not main or previous is not signal.default_int_handler:
        yield lambda: None
        return
    interrupts: list[int] = []

    def check() -> None:
        if interrupts:
            interrupts.clear()
            raise KeyboardInterrupt

    signal.signal(signal.SIGINT, lambda number, _frame: interrupts.append(number))
    try:
        yield check
    finally:
        signal.signal(signal.SIGINT, previous)
    check()
