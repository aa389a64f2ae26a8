"""Random legal and illegal calls, against a model of the calling sequence of FMI 2.0."""

import itertools
import math
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, ClassVar

import pytest
from hypothesis import settings, strategies as st
from hypothesis.stateful import (
    RuleBasedStateMachine,
    initialize,
    precondition,
    rule,
    run_state_machine_as_test,
)

from fmu_src.build.builder import NATIVE, PYTHON, build_fmu
from fmu_src.slave.variable import Role
from fmu_src.slave.variables import REFERENCES, VARIABLES
from tests.support.fmu_driver import Answer, Driver

OUTPUTS = [v.name for v in VARIABLES if v.role is Role.OUTPUT]
STARTS = {"F": 80.0, "mu": 0.7, "m": 5.0}
# Values that the FMU accepts.
RANGES = {"F": (-1e9, 1e9), "mu": (0.0, 100.0), "m": (5e-324, 1e9)}
TYPICAL_VALUES = {"F": st.floats(1.0, 200.0), "mu": st.floats(0.0, 2.0), "m": st.floats(1.0, 10.0)}
INVALID_VALUES = st.sampled_from([math.nan, math.inf, -math.inf, -1e10, 1e12])


@dataclass(frozen=True)
class Expected:
    """Expected state of the instance."""

    phase: str = "instantiated"
    start: float | None = None
    stop: float = math.inf
    tol: float | None = None
    t: float = 0.0
    values: dict[str, float] = field(default_factory=lambda: dict(STARTS))
    # Values set before the end of the initialization, to repeat the run on a fresh instance.
    initial_values: dict[str, float] | None = None
    history: tuple[tuple[dict[str, float], float, float], ...] = ()
    # Refused calls that the next step will report.
    refused: frozenset[str] = frozenset()

    def with_refused(self, *calls: str) -> "Expected":
        return replace(self, refused=self.refused | set(calls))

    def without_refused(self, *calls: str) -> "Expected":
        return replace(self, refused=self.refused - set(calls))


class Calls(RuleBasedStateMachine):
    """An instance driven at random, with its expected state."""

    driver: ClassVar[Driver]
    # Whether a refused call itself returns an error, rather than the next step.
    reported_at_once: ClassVar[bool]
    expected: Expected

    def call(self, *call: Any) -> Answer:
        """Call a method of the instance "a", which lives on between calls of `go_on`."""
        return self.driver.go_on(("a", *call))[0]

    def check_refused(self, answer: Answer, *calls: str) -> None:
        """Check that a call is refused, by its own status or by that of the next step."""
        if self.reported_at_once:
            assert answer.status in ("discard", "error")
            assert answer.log
        else:
            assert answer.status == "ok"
            self.expected = self.expected.with_refused(*calls)

    @initialize(initialized=st.booleans(), tol=st.sampled_from([None, 1e-6]))
    def instantiate(self, initialized: bool, tol: float | None) -> None:
        # Remove the instances and states of the previous example.
        self.driver.go_on(("", "free_all"))
        assert self.call("new").status == "ok"
        self.expected = Expected()
        self.saved: list[Expected] = []
        if initialized:
            self.begin(tol)

    def begin(self, tol: float | None) -> None:
        self.setup(0.0, None, tol)
        self.enter()
        self.exit()

    def setup(self, start: float, stop: float | None, tol: float | None) -> None:
        answer = self.call("setup", start, stop, tol)
        legal = start == start and (stop is None or stop >= start) and tol == tol
        if self.expected.phase != "instantiated" or not legal:
            self.check_refused(answer, "setup")
        else:
            assert answer.status == "ok"
            self.expected = replace(
                self.expected.without_refused("setup"),
                start=start,
                stop=math.inf if stop is None else stop,
                tol=tol,
            )

    def enter(self) -> None:
        answer = self.call("enter")
        if self.expected.phase == "instantiated" and self.expected.start is not None:
            assert answer.status == "ok"
            self.expected = replace(self.expected.without_refused("enter"), phase="initialization")
        else:
            self.check_refused(answer, "enter")

    def exit(self) -> None:
        answer = self.call("exit")
        e = self.expected
        # A refused exit may be repeated.
        if e.phase == "initialization" and not e.refused - {"exit"}:
            assert answer.status == "ok"
            assert e.start is not None
            initial_values = dict(e.values)
            self.expected = replace(
                e.without_refused("exit"),
                phase="stepping",
                t=e.start,
                initial_values=initial_values,
            )
        else:
            self.check_refused(answer, "exit")

    def terminate(self) -> None:
        answer = self.call("terminate")
        e = self.expected
        # The Python FMU cannot report a refused exit, so its importer takes the run for initialized
        # and may terminate it. For the native FMU `refused` is empty.
        if e.phase == "stepping" or (e.phase != "terminated" and "exit" in e.refused):
            assert answer.status == "ok"
            self.expected = replace(self.expected, phase="terminated")
        else:
            self.check_refused(answer, "terminate")

    def reset(self) -> None:
        assert self.call("reset").status == "ok"
        self.expected = Expected()

    @rule(
        call_name=st.sampled_from(["enter", "exit", "begin", "setup", "terminate", "reset"]),
        data=st.data(),
    )
    def change_the_phase(self, call_name: str, data: st.DataObject) -> None:
        if call_name == "setup":
            self.setup(
                data.draw(st.sampled_from([0.0, -2.0, 3.5, math.nan])),
                data.draw(st.sampled_from([None, 5.0, 100.0, -10.0])),
                data.draw(st.sampled_from([None, 1e-8, 0.0, 1.0, math.nan])),
            )
        elif call_name == "begin":
            self.reset()
            self.begin(None)
        else:
            getattr(self, call_name)()

    def set(self, name: str, value: float) -> None:
        answer = self.call("set", {name: value})
        e = self.expected
        lower, upper = RANGES[name]
        settable = e.phase != "terminated" and not (e.phase == "stepping" and name == "m")
        if settable and lower <= value <= upper:
            assert answer.status == "ok"
            self.expected = replace(e.without_refused(name), values=e.values | {name: value})
        else:
            self.check_refused(answer, name)

    @rule(name=st.sampled_from(["F", "F", "mu", "mu", "m"]), data=st.data())
    def set_a_typical_value(self, name: str, data: st.DataObject) -> None:
        self.set(name, data.draw(TYPICAL_VALUES[name]))

    @rule(name=st.sampled_from(["F", "mu", "y", "mode", "unknown"]), value=INVALID_VALUES)
    def set_an_invalid_value(self, name: str, value: float) -> None:
        if name in STARTS:
            self.set(name, value)
        else:
            reference = REFERENCES.get(name, 10_000)
            answer = self.call("set_raw", "Real", [reference], [0.0])
            self.check_refused(answer, f"reference {reference}")

    @rule(kind=st.sampled_from(["Real", "Integer", "Boolean", "String"]))
    def read_an_unknown_reference(self, kind: str) -> None:
        answer = self.call("get_raw", kind, [10_000])
        assert (answer.status, len(answer.log)) == ("error" if self.reported_at_once else "ok", 1)

    @rule(h=st.one_of(st.floats(1e-6, 1.5), st.sampled_from([1e-3, 1e-2])))
    def step(self, h: float, time_offset: float = 0.0) -> None:
        e = self.expected
        status = self.call("step", e.t + time_offset, h).status
        end = e.t + time_offset + h
        legal = abs(time_offset) < 1e-9 and 0.0 < h < math.inf and e.t < end <= e.stop
        if e.refused or e.phase != "stepping" or not legal:
            assert status == (
                "error" if self.reported_at_once and e.phase != "stepping" else "discard"
            )
            # The failed step has reported the refused calls.
            if e.phase == "stepping":
                self.expected = replace(e, refused=frozenset())
        else:
            assert status == "ok"
            self.expected = replace(
                e, t=end, history=(*e.history, (dict(e.values), e.t + time_offset, h))
            )

    @rule(h=st.sampled_from([1e-3, 3e-3, 1e-2]), count=st.integers(2, 5))
    def repeat_steps(self, h: float, count: int) -> None:
        for _ in range(count):
            self.step(h)

    @rule(
        h=st.sampled_from([0.0, -0.1, math.nan, math.inf, 1e-300, 1e-3]),
        time_offset=st.sampled_from([0.0, 1e-10, 0.25, -0.25, math.nan]),
    )
    def take_an_invalid_step(self, h: float, time_offset: float) -> None:
        self.step(h, time_offset)

    @precondition(lambda self: len(self.saved) < 3)
    @rule()
    def save(self) -> None:
        self.call("save", f"s{len(self.saved)}")
        self.saved.append(replace(self.expected, refused=frozenset()))

    @precondition(lambda self: self.saved)
    @rule(data=st.data(), through_bytes=st.booleans())
    def restore(self, data: st.DataObject, through_bytes: bool) -> None:
        number = data.draw(st.integers(0, len(self.saved) - 1))
        name = f"s{number}"
        if through_bytes:
            self.call("serialize", name, "copy")
            name = "copy"
        assert self.call("restore", name).status == "ok"
        if through_bytes:
            self.call("forget", "copy")
        self.expected = self.saved[number]

    @rule()
    def check_values(self) -> None:
        # Not after every rule: until outputs are read, steps need not compute them.
        answer = self.call("get", [*STARTS, *OUTPUTS])
        assert answer.value[: len(STARTS)] == list(self.expected.values.values())

    def teardown(self) -> None:
        """Refused calls have no effect: the accepted calls alone give the same outputs."""
        self.check_values()
        e = self.expected
        if e.initial_values is None:
            return
        expected = self.call("get", OUTPUTS).value
        calls: list[Any] = [("b", "new"), ("b", "setup", e.start, None, e.tol)]
        calls += [("b", "set", e.initial_values), ("b", "enter"), ("b", "exit")]
        for inputs, steps in itertools.groupby(e.history, lambda step: step[0]):
            calls.append(("b", "set", {n: inputs[n] for n in ("F", "mu")}))
            calls += [("b", "step", t, h) for t, h in _merge_steps([step[1:] for step in steps])]
        calls += [("b", "set", {n: e.values[n] for n in ("F", "mu")}), ("b", "get", OUTPUTS)]
        assert self.driver.go_on(*calls)[-1].value == expected


def _merge_steps(steps: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Merge steps into one if its end is the same float: the outputs must then be the same."""
    (begin, _), (final_start, h) = steps[0], steps[-1]
    end = final_start + h
    length = end - begin
    can_merge = begin < end and begin + length == end
    return [(begin, length)] if can_merge else steps


@pytest.mark.parametrize("examples", [40, pytest.param(400, marks=pytest.mark.whole)])
@pytest.mark.parametrize("flavour", [PYTHON, NATIVE])
def test_any_sequence_of_calls_follows_the_standard(
    flavour: str, examples: int, tmp_path: Path
) -> None:
    Calls.reported_at_once = flavour == NATIVE
    with Driver(build_fmu(tmp_path / "slider_belt.fmu", flavour=flavour)) as Calls.driver:
        run_state_machine_as_test(
            Calls, settings=settings(max_examples=examples, stateful_step_count=30, deadline=None)
        )
