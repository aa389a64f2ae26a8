"""The state of an FMU instance can be saved, restored, copied and serialised, to the last bit."""

import pytest
from hypothesis import given, settings, strategies as st

from fivtui import Parameters, simulate
from fmu_src.build.builder import PYTHON
from fmu_src.slave.instance_state import InstanceState
from fmu_src.slave.slider_belt import SliderBeltInstance
from fmu_src.slave.variables import REFERENCES, VARIABLES
from tests.support.fmu_driver import Call, Driver
from tests.support.strategies import moderate_parameters

REAL_NAMES = [v.name for v in VARIABLES if v.type == "Real"]


# At 3.9 s the slider is separated, at 2.5 s in contact; 1/7 s lies within a Taylor step.
@pytest.mark.parametrize("t", [2.5, 3.9, 1.0 / 7.0])
def test_rollback_in_any_phase_is_exact(driver: Driver, t: float) -> None:
    calls: list[Call] = [
        ("a", "begin"),
        ("a", "step", 0.0, t),
        ("a", "save", "saved"),
        ("a", "set", {"F": 20.0}),
        ("a", "steps", t, 0.3, 20),
        ("a", "get", REAL_NAMES),
        ("a", "restore", "saved"),
        ("a", "get", REAL_NAMES),
        ("a", "set", {"F": 20.0}),
        ("a", "steps", t, 0.3, 20),
        ("a", "get", REAL_NAMES),
        ("a", "forget", "saved"),
    ]
    answers = driver.drive(*calls)
    first, changed, second = answers[5].value, answers[7].value, answers[10].value
    assert first == second != changed
    assert changed[REAL_NAMES.index("F")] == 80.0


def test_a_serialised_state_continues_in_another_instance(driver: Driver) -> None:
    calls: list[Call] = [
        ("a", "begin", {"k_nl": 300.0, "mu": 0.9}, 1e-8),
        ("a", "steps", 0.0, 0.35, 11),
        ("a", "save", "original"),
        ("a", "serialize", "original", "copy"),
        ("b", "begin", {"separation": False, "F": 5.0}),
        ("b", "step", 0.0, 1.0),
        ("b", "restore", "copy"),
        ("a", "steps", 3.85, 0.1, 50),
        ("b", "steps", 3.85, 0.1, 50),
        ("a", "get", REAL_NAMES),
        ("b", "get", REAL_NAMES),
        ("a", "forget", "original"),
        ("a", "free"),
        ("b", "forget", "copy"),
        ("b", "free"),
    ]
    answers = driver.drive(*calls)
    assert {answer.status for answer in answers} == {"ok"}
    assert answers[9].value == answers[10].value


def test_a_state_saved_before_the_initialization_can_be_used(driver: Driver) -> None:
    calls: list[Call] = [
        ("a", "new"),
        ("a", "save", "fresh"),
        ("a", "init", {"F": 40.0}),
        ("a", "step", 0.0, 5.0),
        ("a", "restore", "fresh"),
        ("a", "init"),
        ("a", "step", 0.0, 5.0),
        ("a", "get", REAL_NAMES),
        ("b", "begin"),
        ("b", "step", 0.0, 5.0),
        ("b", "get", REAL_NAMES),
    ]
    answers = driver.drive(*calls)
    assert answers[7].value == answers[10].value


@pytest.mark.parametrize("flavour", [PYTHON], indirect=True)
# A serialised state begins with eight bytes of a checksum; JSON text follows.
@pytest.mark.parametrize("flipped_byte", [0, 20, -1])
def test_a_damaged_state_is_refused_and_nothing_changes(driver: Driver, flipped_byte: int) -> None:
    calls: list[Call] = [
        ("a", "begin"),
        ("a", "step", 0.0, 4.0),
        ("a", "save", "good"),
        ("a", "serialize", "good", "bad", flipped_byte),
        ("a", "step", 4.0, 1.0),
        ("a", "get", REAL_NAMES),
        ("a", "restore", "bad"),
        ("a", "get", REAL_NAMES),
        ("a", "step", 5.0, 1.0),
        ("a", "step", 5.0, 1.0),
    ]
    answers = driver.drive(*calls)
    assert answers[5].value == answers[7].value
    assert "the serialised FMU state is damaged" in answers[6].log[0]
    assert [answer.status for answer in answers[-2:]] == ["discard", "ok"]


def test_a_state_of_another_build_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    instance = stepping_instance()
    before = instance.read()
    data = SliderBeltInstance._fmu_state_to_bytes(instance.saved_state())
    # `_BUILD` identifies the sources of the FMU; every state contains it.
    monkeypatch.setattr("fmu_src.slave.instance_state._BUILD", "another")
    # The wrapper gets the reason of the refusal in place of a state, and sets it.
    refusal = SliderBeltInstance._fmu_state_from_bytes(data)
    assert isinstance(refusal, str)
    assert "another build" in refusal
    instance.fmu._set_fmu_state(refusal)
    assert instance.read() == before


def test_a_step_of_too_many_taylor_steps_is_refused_with_the_reason(
    caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("fmu_src.slave.motion._MAX_STEPS", 100)
    instance = stepping_instance()
    assert not instance.fmu.do_step(0.0, 1e6)
    (message,) = caplog.messages
    assert "the step is stopped after 100 Taylor steps at t = " in message
    assert "use shorter communication steps, or the native FMU" in message
    assert instance.fmu.do_step(0.0, 1.0)


class DirectInstance:
    """An instance of the Python FMU, called directly instead of by the wrapper in C."""

    def __init__(self) -> None:
        self.fmu = SliderBeltInstance(instance_name="test")
        self.t = 0.0

    def set(self, **values: float) -> None:
        references = [REFERENCES[name] for name in values]
        self.fmu.set_real(references, list(values.values()))

    def begin(self) -> None:
        self.fmu.setup_experiment(0.0, None, None)
        self.fmu.enter_initialization_mode()
        self.fmu.exit_initialization_mode()

    def step(self, h: float) -> None:
        assert self.fmu.do_step(self.t, h)
        self.t += h

    def read(self) -> list[float]:
        return self.fmu.get_real(range(len(VARIABLES)))

    def get(self, name: str) -> float:
        return self.fmu.get_real([REFERENCES[name]])[0]

    def saved_state(self) -> InstanceState:
        saved_state = self.fmu._get_fmu_state()
        assert isinstance(saved_state, InstanceState)
        return saved_state

    def restore(self, saved_state: InstanceState, t: float) -> None:
        self.fmu._set_fmu_state(saved_state)
        self.t = t


def copy_through_bytes(saved_state: InstanceState) -> InstanceState:
    copy = SliderBeltInstance._fmu_state_from_bytes(
        SliderBeltInstance._fmu_state_to_bytes(saved_state)
    )
    assert isinstance(copy, InstanceState)
    return copy


def stepping_instance() -> DirectInstance:
    instance = DirectInstance()
    instance.begin()
    return instance


steps = st.lists(st.floats(1e-3, 2.0), min_size=1, max_size=8)


@settings(max_examples=40, deadline=None)
@given(moderate_parameters(), steps, steps, st.floats(-50.0, 200.0), st.booleans())
def test_repeating_steps_from_a_saved_state_gives_the_same_bits(
    p: Parameters, before: list[float], after: list[float], F: float, through_bytes: bool
) -> None:
    instance = DirectInstance()
    instance.set(**p.as_dict())
    instance.begin()
    for h in before:
        instance.step(h)
    saved_state, t = instance.saved_state(), instance.t
    saved = instance.read()
    ends = []
    for _ in range(2):
        instance.set(F=F)
        for h in after:
            instance.step(h)
        ends.append(instance.read())
        instance.restore(copy_through_bytes(saved_state) if through_bytes else saved_state, t)
    assert ends[0] == ends[1]
    assert instance.read() == saved
    assert instance.saved_state() == saved_state


@settings(max_examples=40, deadline=None)
@given(moderate_parameters(), st.lists(st.floats(1e-4, 3.0), min_size=1, max_size=30))
def test_the_communication_points_do_not_matter(p: Parameters, points: list[float]) -> None:
    one_step, many_steps = DirectInstance(), DirectInstance()
    for instance in (one_step, many_steps):
        instance.set(**p.as_dict())
        instance.begin()
    for h in points:
        many_steps.step(h)
    one_step.step(many_steps.t)
    assert many_steps.read() == one_step.read()


@settings(max_examples=60, deadline=None)
@given(
    moderate_parameters(),
    st.lists(st.tuples(st.floats(1e-3, 1.5), st.floats(-80.0, 200.0)), min_size=1, max_size=8),
    st.booleans(),
)
def test_switches_alternate_for_any_inputs(
    p: Parameters, changes: list[tuple[float, float]], on_switches: bool
) -> None:
    instance, native = DirectInstance(), simulate(p, t_end=3.0)
    # Change an input one rounding error before a switch, which could be lost or counted twice.
    if on_switches and native.switch_times.size:
        first = float(native.switch_times[0])
        changes = [(first * (1.0 - 1e-16), changes[0][1]), *changes]
    instance.set(**p.as_dict())
    instance.begin()
    first_mode = instance.get("mode")
    for h, F in changes:
        instance.step(h)
        instance.set(F=F)
        instance.step(1e-3)
        y, mode = instance.get("y"), instance.get("mode")
        separations, reattachments = instance.get("separations"), instance.get("reattachments")
        assert mode == first_mode - separations + reattachments
        assert mode in (0.0, 1.0)
        assert (y <= 1e-12) if mode else (y >= -1e-12)
