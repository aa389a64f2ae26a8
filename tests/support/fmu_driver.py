"""Drives FMUs through fmpy in a separate process that cannot import this project."""

import contextlib
import json
import logging
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any, NamedTuple, Self

Call = tuple[Any, ...]


class Answer(NamedTuple):
    """Result of one call of the script: FMI status, returned value, and messages of the FMU."""

    status: str
    value: Any
    log: list[str]


class Driver:
    """A process that drives FMUs, as a context manager.

    Parameters
    ----------
    fmus : Path
        Files of the FMUs; `_Host.new` selects one by its index.
    """

    def __init__(self, *fmus: Path) -> None:
        self._fmus = [str(fmu.resolve()) for fmu in fmus]

    def __enter__(self) -> Self:
        self._folder = tempfile.TemporaryDirectory()
        self._errors = tempfile.TemporaryFile("w+")
        self._process = subprocess.Popen(
            [sys.executable, "-I", __file__, *self._fmus],
            cwd=self._folder.name,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._errors,
            text=True,
        )
        return self

    def __exit__(self, *_: object) -> None:
        self._process.communicate()
        self._errors.seek(0)
        errors = self._errors.read()
        self._errors.close()
        self._folder.cleanup()
        assert (self._process.returncode, errors) == (0, ""), (self._process.returncode, errors)

    def drive(self, *calls: Call) -> list[Answer]:
        """Run a script of calls, each (instance, method of `_Host`, arguments …)."""
        return [Answer(*answer) for answer in self._request({"calls": calls})]

    def go_on(self, *calls: Call) -> list[Answer]:
        """As `drive`, but keep instances and states of the previous `go_on`."""
        return [Answer(*answer) for answer in self._request({"calls": calls, "keep": True})]

    def simulate(self, *runs: dict[str, Any]) -> list[dict[str, float]]:
        """Final outputs of fmpy's ``simulate_fmu`` for each set of options."""
        final_values: list[dict[str, float]] = self._request({"runs": runs})
        return final_values

    def _request(self, request: dict[str, Any]) -> Any:
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(json.dumps(request) + "\n")
        self._process.stdin.flush()
        answer = self._process.stdout.readline()
        assert answer, f"the process has ended with {self._process.wait()}"
        return json.loads(answer)


class _Host:
    # Executes calls in the driven process: a script names its methods. The first argument of each
    # is the name of an instance, even where it is not used. Holds FMUs, and instances and saved
    # states by name. `kind` is an FMI type such as "Real".

    def __init__(self, fmus: list[tuple[Any, Any]]) -> None:
        self.fmus = fmus
        self.instances: dict[str, Any] = {}
        self.references: dict[str, dict[str, Any]] = {}
        self.states: dict[str, Any] = {}
        self.log: list[str] = []

    def new(self, name: str, fmu_index: int = 0, logging: bool = True) -> None:
        import fmpy

        folder, description = self.fmus[fmu_index]
        self.references[name] = {v.name: v for v in description.modelVariables}
        self.instances[name] = fmpy.instantiate_fmu(
            folder,
            description,
            debug_logging=logging,
            logger=lambda *args: self.log.append(args[-1].decode()),
        )

    def free(self, name: str) -> None:
        self.instances.pop(name).freeInstance()

    def free_all(self, name: str) -> None:
        for key in list(self.instances):
            self.free(key)
        self.states.clear()

    def setup(self, name: str, start: float = 0.0, stop: Any = None, tol: Any = None) -> None:
        self.instances[name].setupExperiment(startTime=start, stopTime=stop, tolerance=tol)

    def enter(self, name: str) -> None:
        self.instances[name].enterInitializationMode()

    def exit(self, name: str) -> None:
        self.instances[name].exitInitializationMode()

    def init(self, name: str, values: dict[str, Any] | None = None, tol: Any = None) -> None:
        self.setup(name, tol=tol)
        self.set(name, values or {})
        self.enter(name)
        self.exit(name)

    def begin(self, name: str, values: dict[str, Any] | None = None, tol: Any = None) -> None:
        self.new(name)
        self.init(name, values, tol)

    def reset(self, name: str) -> None:
        self.instances[name].reset()

    def terminate(self, name: str) -> None:
        self.instances[name].terminate()

    def step(self, name: str, t: float, h: float) -> None:
        self.instances[name].doStep(t, h)

    def steps(self, name: str, t: float, h: float, count: int) -> None:
        for number in range(count):
            self.instances[name].doStep(t + number * h, h)

    def set(self, name: str, values: dict[str, Any]) -> None:
        for variable, value in values.items():
            reference = self.references[name][variable]
            getattr(self.instances[name], f"set{reference.type}")(
                [reference.valueReference], [value]
            )

    def set_raw(self, name: str, kind: str, references: list[int], values: list[Any]) -> None:
        getattr(self.instances[name], f"set{kind}")(references, values)

    def get(self, name: str, variables: list[str]) -> list[float]:
        references = [self.references[name][variable].valueReference for variable in variables]
        values: list[float] = self.instances[name].getReal(references)
        return values

    def get_raw(self, name: str, kind: str, references: list[int]) -> Any:
        values = getattr(self.instances[name], f"get{kind}")(references)
        return [value.decode() if isinstance(value, bytes) else value for value in values]

    def save(self, name: str, state: str) -> None:
        self.states[state] = self.instances[name].getFMUstate()

    def restore(self, name: str, state: str) -> None:
        self.instances[name].setFMUstate(self.states[state])

    def forget(self, name: str, state: str) -> None:
        self.instances[name].freeFMUstate(self.states.pop(state))

    def serialize(self, name: str, state: str, copy: str, flipped_byte: int | None = None) -> int:
        data = bytearray(self.instances[name].serializeFMUstate(self.states[state]))
        if flipped_byte is not None:
            data[flipped_byte] ^= 1
        self.states[copy] = self.instances[name].deSerializeFMUstate(bytes(data))
        return len(data)

    def many(self, name: str, count: int) -> list[Any]:
        for number in range(count):
            self.begin(f"{name}{number}")
            self.step(f"{name}{number}", 0.0, 0.1)
        final_values = [self.get(f"{name}{number}", ["y"])[0] for number in range(count)]
        for number in range(count):
            self.free(f"{name}{number}")
        return final_values

    def path_length(self, name: str) -> int:
        # Tests that instances do not lengthen the search path of modules.
        return len(sys.path)

    def modules(self, name: str) -> list[str]:
        return sorted({module.partition(".")[0] for module in sys.modules if "fivtui" in module})


# Names of the FMI statuses of failed calls.
_STATUSES = {2: "discard", 3: "error", 4: "fatal"}


def _drive(host: _Host, calls: list[Any]) -> list[Answer]:
    from fmpy.fmi1 import FMICallException

    answers = []
    for instance, method, *arguments in calls:
        host.log.clear()
        try:
            status, value = "ok", getattr(host, method)(instance, *arguments)
        except FMICallException as error:
            status, value = _STATUSES[error.status], None
        answers.append(Answer(status, value, host.log[:]))
    return answers


def _simulate(path: str, runs: list[dict[str, Any]]) -> list[dict[str, float]]:
    import fmpy

    results = [fmpy.simulate_fmu(path, **options) for options in runs]
    return [{name: float(r[name][-1]) for name in r.dtype.names} for r in results]


def main() -> None:
    """Serve requests, one per line, until the input ends."""
    # Block the project's packages even where they are installed beside fmpy: imports must fail.
    for project in ("fivtui", "fmu_src"):
        sys.modules[project] = None  # type: ignore[assignment]
        with contextlib.suppress(ImportError):
            __import__(project)
            raise AssertionError(project)
    import fmpy

    # A script sees the FMU's messages in its log instead of on standard error.
    logging.getLogger("fivtui.fmu").addHandler(logging.NullHandler())
    fmus = [(fmpy.extract(path), fmpy.read_model_description(path)) for path in sys.argv[1:]]
    lasting_host = _Host(fmus)
    for line in sys.stdin:
        request = json.loads(line)
        answer: list[Any]
        if "runs" in request:
            answer = _simulate(sys.argv[1], request["runs"])
        elif "keep" in request:
            answer = _drive(lasting_host, request["calls"])
        else:
            new_host = _Host(fmus)
            answer = _drive(new_host, request["calls"])
            new_host.free_all("")
        print(json.dumps(answer), flush=True)
    for folder, _ in fmus:
        shutil.rmtree(folder)


if __name__ == "__main__":
    main()
