"""Slider-belt and brake actuator as an SSP archive, coupled by libcosim (extra ``interop``).

Run it as ``python examples/system_libcosim.py``.
"""

import tempfile
from pathlib import Path

from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
from libcosimpy.CosimManipulator import CosimManipulator
from libcosimpy.CosimObserver import CosimObserver

from fmu_src.build.ssp import build_ssp


def main() -> None:
    """Raise the commanded force after 10 s and print the motion."""
    log_output_level(CosimLogLevel.ERROR)
    with tempfile.TemporaryDirectory() as folder:
        path = build_ssp(Path(folder) / "brake.ssp")
        run = CosimExecution.from_ssp_file(str(path), step_size=10_000_000)
        s, a = (run.slave_index_from_instance_name(n) for n in ("slider_belt", "brake_actuator"))
        slider = {v.name.decode(): v.reference for v in run.slave_variables(s)}
        actuator = {v.name.decode(): v.reference for v in run.slave_variables(a)}
        observer, setter = CosimObserver.create_last_value(), CosimManipulator.create_override()
        run.add_observer(observer)
        run.add_manipulator(setter)
        for t, command in ((10, 80.0), (20, 120.0)):
            setter.slave_real_values(a, [actuator["command"]], [command])
            run.simulate_until(t * 1_000_000_000)
            y, count = observer.last_real_values(s, [slider["y"], slider["separations"]])
            (F,) = observer.last_real_values(a, [actuator["F"]])
            print(f"t {t} s  F {F:7.3f} N  y {y:8.5f} m  separations {count:.0f}")


if __name__ == "__main__":
    main()
