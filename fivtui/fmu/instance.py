"""Load FMUs with fmpy: extract the file, create an instance, collect its log messages."""

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

from fivtui.io import MAX_TABLE, open_regular
from fivtui.model import ComputationError, InputError
from fmu_src.build import IMPORT_LOCK

from .folders import Folder, reserve_folder

# FMI statuses: 0 is success, 2 discard, 3 error.
_WARNING: Final = 1
_FATAL: Final = 4
# Greatest size of the files in an FMU, bytes: that of tables.
_MAX_EXTRACTED: Final = MAX_TABLE
# Limit of stored messages, of each kind.
_MAX_MESSAGES: Final = 20
_DESCRIPTION: Final = "modelDescription.xml"

_instance_numbers = itertools.count(1)
_messages_by_instance: dict[int, "Messages"] = {}
# FMUs of this project pass each message to their host, fmpy (see `Messages`), and in Python also to
# this logger. Its records are filtered out.
_LOGGER: Final = logging.getLogger("fivtui.fmu")


class Messages:
    """Newest warnings and messages of failed calls of one FMU instance."""

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
        """The newest message of a failed call on one line; empty if there is none."""
        return self._failures[-1] if self._failures else ""

    @property
    def warnings(self) -> tuple[str, ...]:
        """The newest warnings, without repetition, each on one line."""
        return tuple(dict.fromkeys(self._warnings))


class FmuFile:
    """An extracted FMU: its path, the folder of its files, and fmpy's model description."""

    def __init__(self, path: Path, folder: Folder, description: Any) -> None:
        self.path = path
        self.folder = folder.path
        self.description = description
        self._folder = folder

    def discard_folder(self) -> None:
        """Prevent reuse of the folder: the next run loads the library from another path."""
        self._folder.failed_fatally = True


@contextmanager
def extract_fmu(path: Path) -> Iterator[FmuFile]:
    """Extract an FMU for the duration of a context."""
    check_archive(path)
    with ExitStack() as stack:
        try:
            folder = stack.enter_context(reserve_folder(path))
            description = _extract_to(folder.path, path)
        except OSError as error:
            raise InputError(f"{path}: cannot be extracted: {error.strerror or error}") from None
        yield FmuFile(path, folder, description)


def _extract_to(folder: str, path: Path) -> Any:
    import fmpy

    try:
        fmpy.extract(path, folder)
        return fmpy.read_model_description(folder, validate=False)
    except OSError:
        raise
    except Exception as error:  # noqa: BLE001
        raise InputError(f"{path}: is not an FMU: {' '.join(str(error).split())}") from None


def check_archive(path: Path) -> None:
    """Raise `InputError` unless a file is a zip archive with a model description."""
    with open_regular(path) as file:
        try:
            with zipfile.ZipFile(file) as archive:
                sizes = {entry.filename: entry.file_size for entry in archive.infolist()}
        except (zipfile.BadZipFile, ValueError, NotImplementedError):
            raise InputError(f"{path}: is not an FMU: not a zip archive") from None
    if sum(sizes.values()) > _MAX_EXTRACTED:
        raise InputError(f"{path}: must be of at most {_MAX_EXTRACTED >> 30} GiB when extracted")
    if _DESCRIPTION not in sizes:
        raise InputError(f"{path}: is not an FMU: it holds no {_DESCRIPTION}")


@contextmanager
def create_instance(fmu: FmuFile) -> Iterator[tuple[Any, Messages]]:
    """Create a co-simulation instance of an FMU (FMI 2.0 or 3.0); the context frees it at its end.

    The host's working directory and module path are restored.
    """
    instantiate = _choose_instantiation(fmu)
    number, messages = next(_instance_numbers), Messages()
    _messages_by_instance[number] = messages
    instance, failed_fatally = None, False
    exclusion_filter = _exclusion_filter(number)
    _LOGGER.addFilter(exclusion_filter)
    try:
        # An FMU in Python imports its code. One import at a time: it changes `sys.path`.
        with IMPORT_LOCK, _restore_process():
            instance = _instantiate(fmu, lambda: instantiate(number, messages), messages)
        yield instance, messages
    except Exception as error:
        # The FMI status is in fmpy's error, which a caller may have replaced by its own.
        causes = (error, error.__context__)
        failed_fatally = any(getattr(cause, "status", None) == _FATAL for cause in causes)
        raise
    finally:
        if failed_fatally:
            fmu.discard_folder()
        elif instance is not None:
            with suppress(Exception):
                instance.freeInstance()
        _LOGGER.removeFilter(exclusion_filter)
        del _messages_by_instance[number]


def _instance_name(number: int) -> str:
    return f"fivtui-{number}"


def _exclusion_filter(number: int) -> Callable[[logging.LogRecord], bool]:
    # A logging filter that drops the records of an instance.
    name = _instance_name(number)
    return lambda record: getattr(record, "fmu_instance", None) != name


@contextmanager
def _restore_process() -> Iterator[None]:
    # The wrapper of a Python FMU extends the module path; fmpy changes the working directory.
    path, directory = sys.path[:], Path.cwd()
    try:
        yield
    finally:
        sys.path[:] = path
        os.chdir(directory)


def _instantiate(fmu: FmuFile, instantiate: Callable[[], Any], messages: Messages) -> Any:
    try:
        return instantiate()
    except Exception as error:  # noqa: BLE001
        reason = messages.last or " ".join(str(error).split())
        raise ComputationError(
            f"{fmu.path}: the FMU cannot be instantiated: {reason}", "check it: fivtui fmu check"
        ) from None


def has_binary(fmu: FmuFile) -> bool:
    """Whether an FMU has a binary for this platform."""
    import fmpy

    is_fmi3 = fmu.description.fmiVersion.startswith("3.")
    binaries = Path(fmu.folder, "binaries")
    folder = binaries / (fmpy.platform_tuple if is_fmi3 else fmpy.platform)
    # FMI 2.0 named no folder for ARM before 2.0.4, so FMUs may have a copy of the binary for ARM in
    # the folder for x86. On x86 it does not count.
    arm_folder = binaries / f"aarch64-{fmpy.system}"
    is_not_arm = fmpy.architecture != "aarch64"

    def is_for_arm(file: Path) -> bool:
        arm_file = arm_folder / file.name
        return arm_file.is_file() and filecmp.cmp(file, arm_file, shallow=False)

    files = folder.glob(f"*{fmpy.sharedLibraryExtension}")
    return any(not (is_not_arm and is_for_arm(file)) for file in files)


def _choose_instantiation(fmu: FmuFile) -> Callable[[int, Messages], Any]:
    # The function that creates an instance by the FMI version of the FMU.
    import fmpy

    version = fmu.description.fmiVersion
    if fmu.description.coSimulation is None:
        raise InputError(f"{fmu.path}: is not for co-simulation")
    if not has_binary(fmu):
        raise InputError(f"{fmu.path}: has no binary for this platform, {fmpy.platform}")
    if version == "2.0":
        return lambda number, _: _instantiate_fmi2(fmu, number)
    if version.startswith("3."):
        return lambda _, messages: _instantiate_fmi3(fmu, messages)
    raise InputError(f"{fmu.path}: is of FMI {version}; FMI 2.0 or 3.0 is needed")


def _instantiate_fmi2(fmu: FmuFile, number: int) -> Any:
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
    callbacks.logger = _logger_callback()
    callbacks.allocateMemory = fmi2CallbackAllocateMemoryTYPE(calloc)
    callbacks.freeMemory = fmi2CallbackFreeMemoryTYPE(free)
    callbacks.componentEnvironment = number
    addLoggerProxy(byref(callbacks))
    description = fmu.description
    instance = FMU2Slave(
        guid=description.guid,
        modelIdentifier=description.coSimulation.modelIdentifier,
        unzipDirectory=fmu.folder,
        instanceName=_instance_name(number),
    )
    instance.instantiate(callbacks=callbacks, loggingOn=True)
    return instance


@lru_cache(maxsize=1)
def _logger_callback() -> Any:
    # fmpy keeps one logger per process: it must serve all instances and outlive them.
    from fmpy.fmi1 import printLogMessage
    from fmpy.fmi2 import fmi2CallbackLoggerTYPE

    def log(
        environment: int | None, name: bytes, status: int, category: bytes, message: bytes
    ) -> None:
        if environment in _messages_by_instance:
            _messages_by_instance[environment].log(status, message)
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
def defer_interrupts() -> Iterator[Callable[[], None]]:
    """Defer Ctrl-C while the FMU runs, because an exception would corrupt its state.

    Yields a function to call between calls of the FMU; it raises a deferred KeyboardInterrupt.
    """
    previous = signal.getsignal(signal.SIGINT)
    is_main_thread = threading.current_thread() is threading.main_thread()
    if not is_main_thread or previous is not signal.default_int_handler:
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
