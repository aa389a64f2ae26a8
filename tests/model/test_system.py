"""Systems: parameters, separation and tables over time in one immutable object."""

import pickle
from dataclasses import FrozenInstanceError
from typing import Any

import numpy as np
import pytest

from fivtui.model import InputError, Parameters, System, system_of, time_tables

TABLES = time_tables({"F": [(0.0, 20.0), (1.0, 60.0)]})


def test_changed_values_keep_separation_and_tables() -> None:
    system = System(Parameters(), separation=False, over_time=TABLES)
    changed = system.with_values({"mu": "0.3"})
    assert changed == System(Parameters(mu=0.3), separation=False, over_time=TABLES)
    assert system.parameters.mu == Parameters().mu
    with pytest.raises(InputError, match="unknown parameter 'G'"):
        system.with_values({"G": 1.0})


def test_systems_are_immutable_and_compare_by_value() -> None:
    system = System(Parameters(), over_time=TABLES)
    assert system == pickle.loads(pickle.dumps(system))
    assert hash(system) == hash(System(Parameters(), over_time=dict(TABLES)))
    assert system != System(Parameters())
    assert System(Parameters()) != System(Parameters(), separation=False)
    with pytest.raises(FrozenInstanceError):
        setattr(system, "separation", False)  # noqa: B010


@pytest.mark.parametrize("wrong", ["base", 3.0])
def test_the_base_set_is_the_default_and_invalid_parameter_sets_are_refused(wrong: Any) -> None:
    assert system_of(None, separation=True) == System(Parameters())
    assert system_of(Parameters(mu=0.2), separation=False).parameters.mu == 0.2
    with pytest.raises(InputError, match="must be a set of parameters"):
        system_of(wrong, separation=True)


def test_separation_must_be_a_truth_value() -> None:
    assert System(Parameters(), np.bool_(False)).separation is False  # type: ignore[arg-type]
    for wrong in ("no", None, 1):
        with pytest.raises(InputError, match=f"separation = {wrong!r}: must be True or False"):
            System(Parameters(), wrong)  # type: ignore[arg-type]
