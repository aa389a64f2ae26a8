"""Transients through the FMU agree with the native ones."""

import numpy as np
import pytest

from fivtui import simulate


@pytest.mark.parametrize("separation", [True, False])
def test_fmu_gives_the_native_final_state_and_switches_to_the_last_bit(separation: bool) -> None:
    native = simulate(separation=separation, t_end=20.0)
    fmu = simulate(separation=separation, t_end=20.0, method="fmu")
    assert fmu.final == native.final
    assert np.array_equal(fmu.switch_times, native.switch_times)
    assert fmu.peak.y_abs == pytest.approx(native.peak.y_abs, rel=1e-12)
