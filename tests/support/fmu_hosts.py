"""Other hosts, each in a process of its own: ``python -I fmu_hosts.py HOST FOLDER STEPS H``.

FOLDER holds the system as ``brake.ssp`` and its two FMUs. The last line printed is a list of
(y, P, F) at the end of every communication step, as JSON.
"""

import json
import sys
from pathlib import Path
from typing import Any

Rows = list[tuple[float, ...]]
_SLIDER_BELT, _ACTUATOR = "slider_belt", "brake_actuator"


def libcosim(folder: Path, steps: int, h: float) -> Rows:
    """Through libcosimpy, coupled by its own calls."""
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimSlave import CosimLocalSlave

    execution = CosimExecution.from_step_size(round(h * 1e9))
    for name in (_SLIDER_BELT, _ACTUATOR):
        slave = CosimLocalSlave(fmu_path=str(folder / f"{name}.fmu"), instance_name=name)
        execution.add_local_slave(slave)
    s, a = (execution.slave_index_from_instance_name(n) for n in (_SLIDER_BELT, _ACTUATOR))
    s_names, a_names = (
        {v.name.decode(): v.reference for v in execution.slave_variables(index)} for index in (s, a)
    )
    execution.connect_real_variables(a, a_names["F"], s, s_names["F"])
    execution.connect_real_variables(s, s_names["P"], a, a_names["P"])
    return _observed(execution, steps)


def libcosim_ssp(folder: Path, steps: int, h: float) -> Rows:
    """Through libcosimpy, from the archive."""
    from libcosimpy.CosimExecution import CosimExecution

    path = str(folder / "brake.ssp")
    return _observed(CosimExecution.from_ssp_file(path, step_size=round(h * 1e9)), steps)


def _observed(run: Any, steps: int) -> Rows:
    from libcosimpy.CosimObserver import CosimObserver

    s, a = (run.slave_index_from_instance_name(name) for name in (_SLIDER_BELT, _ACTUATOR))
    s_names, a_names = (
        {v.name.decode(): v.reference for v in run.slave_variables(index)} for index in (s, a)
    )
    observer = CosimObserver.create_last_value()
    run.add_observer(observer)
    rows: Rows = []
    for _ in range(steps):
        assert run.step()
        values = observer.last_real_values(s, [s_names["y"], s_names["P"]])
        rows.append((*values, *observer.last_real_values(a, [a_names["F"]])))
    return rows


def ecos(folder: Path, steps: int, h: float) -> Rows:
    """Through ecospy, coupled by its own calls."""
    from ecospy import EcosSimulation, EcosSimulationStructure

    structure = EcosSimulationStructure()
    for name in (_SLIDER_BELT, _ACTUATOR):
        structure.add_model(name, str(folder / f"{name}.fmu"))
    structure.make_real_connection(f"{_ACTUATOR}::F", f"{_SLIDER_BELT}::F")
    structure.make_real_connection(f"{_SLIDER_BELT}::P", f"{_ACTUATOR}::P")
    return _stepped(EcosSimulation(step_size=h, structure=structure), steps)


def ecos_ssp(folder: Path, steps: int, h: float) -> Rows:
    """Through ecospy, from the archive."""
    from ecospy import EcosSimulation

    return _stepped(EcosSimulation(step_size=h, ssp_path=str(folder / "brake.ssp")), steps)


def _stepped(simulation: Any, steps: int) -> Rows:
    simulation.init()
    names = (f"{_SLIDER_BELT}::y", f"{_SLIDER_BELT}::P", f"{_ACTUATOR}::F")
    rows: Rows = []
    for _ in range(steps):
        simulation.step()
        rows.append(tuple(simulation.get_real(name) for name in names))
    simulation.terminate()
    return rows


def container(folder: Path, steps: int, h: float) -> Rows:
    """Through a container FMU that fmu-manipulation-toolbox makes of both, run by fmpy."""
    import fmpy
    from fmu_manipulation_toolbox.assembly import AssemblyNode

    node = AssemblyNode(
        "pair.fmu", step_size=h, auto_link=False, auto_input=False, auto_output=False
    )
    # The loop of links is cut before the first FMU, the actuator, so F does not wait for P.
    s, a = f"{_SLIDER_BELT}.fmu", f"{_ACTUATOR}.fmu"
    node.add_fmu(a)
    node.add_fmu(s)
    node.add_link(a, "F", s, "F")
    node.add_link(s, "P", a, "P")
    for fmu, name in ((s, "y"), (s, "P"), (a, "F")):
        node.add_output(fmu, name, name)
    node.make_fmu(folder)
    return _of_container(fmpy, folder / "pair.fmu", steps, h, ("y", "P", "F"))


def container_ssp(folder: Path, steps: int, h: float) -> Rows:
    """Through a container FMU that fmu-manipulation-toolbox makes of the archive, run by fmpy."""
    import fmpy
    from fmu_manipulation_toolbox.assembly import Assembly

    assembly = Assembly("brake.ssp", fmu_directory=folder, default_step_size=h)
    # The archive declares no system ports, so the outputs are named here.
    a, s = assembly.root.fmu_names_list
    for fmu, name in ((s, "y"), (s, "P"), (a, "F")):
        assembly.root.add_output(fmu, name, name)
    assembly.make_fmu()
    return _of_container(fmpy, folder / "brake.fmu", steps, h, ("y", "P", "F"))


def _of_container(fmpy: Any, fmu: Path, steps: int, h: float, names: tuple[str, ...]) -> Rows:
    run = fmpy.simulate_fmu(
        str(fmu), stop_time=steps * h, output_interval=h, output=names, validate=False
    )
    return [tuple(row) for row in zip(*(run[name][1:].tolist() for name in names), strict=True)]


HOSTS = (libcosim, libcosim_ssp, ecos, ecos_ssp, container, container_ssp)


def main() -> None:
    """Run the named host."""
    run = {host.__name__: host for host in HOSTS}[sys.argv[1]]
    rows = run(Path(sys.argv[2]), int(sys.argv[3]), float(sys.argv[4]))
    print("\n" + json.dumps(rows), flush=True)


if __name__ == "__main__":
    main()
