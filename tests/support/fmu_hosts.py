"""Runs the brake system in a co-simulation tool: ``python -I fmu_hosts.py HOST FOLDER STEPS H``.

FOLDER holds the system as ``brake.ssp`` and its two FMUs; H is the step in seconds. The last line
printed is a JSON list of (y, P, F), or of `OUTPUTS`, at the end of every communication step.
"""

import json
import os
import sys
from pathlib import Path
from typing import Any

Rows = list[tuple[float, ...]]
_SLIDER_BELT, _ACTUATOR = "slider_belt", "brake_actuator"


def libcosim(folder: Path, steps: int, h: float) -> Rows:
    """Run both FMUs in libcosimpy, connected by calls of its API."""
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimSlave import CosimLocalSlave

    execution = CosimExecution.from_step_size(round(h * 1e9))
    for name in (_SLIDER_BELT, _ACTUATOR):
        slave = CosimLocalSlave(fmu_path=str(folder / f"{name}.fmu"), instance_name=name)
        execution.add_local_slave(slave)
    slider, actuator = (
        execution.slave_index_from_instance_name(n) for n in (_SLIDER_BELT, _ACTUATOR)
    )
    slider_references, actuator_references = (
        {v.name.decode(): v.reference for v in execution.slave_variables(index)}
        for index in (slider, actuator)
    )
    execution.connect_real_variables(
        actuator, actuator_references["F"], slider, slider_references["F"]
    )
    execution.connect_real_variables(
        slider, slider_references["P"], actuator, actuator_references["P"]
    )
    return _run_libcosim(execution, steps)


def libcosim_ssp(folder: Path, steps: int, h: float) -> Rows:
    """Run ``brake.ssp`` in libcosimpy."""
    from libcosimpy.CosimExecution import CosimExecution

    path = str(folder / "brake.ssp")
    return _run_libcosim(CosimExecution.from_ssp_file(path, step_size=round(h * 1e9)), steps)


def _run_libcosim(run: Any, steps: int) -> Rows:
    from libcosimpy.CosimObserver import CosimObserver

    slider, actuator = (
        run.slave_index_from_instance_name(name) for name in (_SLIDER_BELT, _ACTUATOR)
    )
    slider_references, actuator_references = (
        {v.name.decode(): v.reference for v in run.slave_variables(index)}
        for index in (slider, actuator)
    )
    observer = CosimObserver.create_last_value()
    run.add_observer(observer)
    rows: Rows = []
    for _ in range(steps):
        assert run.step()
        values = observer.last_real_values(slider, [slider_references["y"], slider_references["P"]])
        rows.append((*values, *observer.last_real_values(actuator, [actuator_references["F"]])))
    return rows


def ecos(folder: Path, steps: int, h: float) -> Rows:
    """Run both FMUs in ecospy, connected by calls of its API."""
    from ecospy import EcosSimulation, EcosSimulationStructure

    structure = EcosSimulationStructure()
    for name in (_SLIDER_BELT, _ACTUATOR):
        structure.add_model(name, str(folder / f"{name}.fmu"))
    structure.make_real_connection(f"{_ACTUATOR}::F", f"{_SLIDER_BELT}::F")
    structure.make_real_connection(f"{_SLIDER_BELT}::P", f"{_ACTUATOR}::P")
    return _run_ecos(EcosSimulation(step_size=h, structure=structure), steps)


def ecos_ssp(folder: Path, steps: int, h: float) -> Rows:
    """Run ``brake.ssp`` in ecospy."""
    from ecospy import EcosSimulation

    return _run_ecos(EcosSimulation(step_size=h, ssp_path=str(folder / "brake.ssp")), steps)


def _run_ecos(simulation: Any, steps: int) -> Rows:
    simulation.init()
    names = (f"{_SLIDER_BELT}::y", f"{_SLIDER_BELT}::P", f"{_ACTUATOR}::F")
    rows: Rows = []
    for _ in range(steps):
        simulation.step()
        rows.append(tuple(simulation.get_real(name) for name in names))
    simulation.terminate()
    return rows


def container(folder: Path, steps: int, h: float) -> Rows:
    """Build a container of both FMUs with fmu-manipulation-toolbox, and run it in fmpy."""
    import fmpy
    from fmu_manipulation_toolbox.assembly import AssemblyNode

    node = AssemblyNode(
        "pair.fmu", step_size=h, auto_link=False, auto_input=False, auto_output=False
    )
    # F and P form a loop. The container steps the FMUs in the order of `add_fmu`: the actuator
    # first, with the P of the previous step.
    slider, actuator = f"{_SLIDER_BELT}.fmu", f"{_ACTUATOR}.fmu"
    node.add_fmu(actuator)
    node.add_fmu(slider)
    node.add_link(actuator, "F", slider, "F")
    node.add_link(slider, "P", actuator, "P")
    for fmu, name in ((slider, "y"), (slider, "P"), (actuator, "F")):
        node.add_output(fmu, name, name)
    node.make_fmu(folder)
    return _run_container(fmpy, folder / "pair.fmu", steps, h, ("y", "P", "F"))


def container_ssp(folder: Path, steps: int, h: float) -> Rows:
    """Build a container of ``brake.ssp`` with fmu-manipulation-toolbox, and run it in fmpy."""
    import fmpy
    from fmu_manipulation_toolbox.assembly import Assembly

    assembly = Assembly("brake.ssp", fmu_directory=folder, default_step_size=h)
    # The archive declares no system ports, so the outputs are named here.
    actuator, slider = assembly.root.fmu_names_list
    for fmu, name in ((slider, "y"), (slider, "P"), (actuator, "F")):
        assembly.root.add_output(fmu, name, name)
    assembly.make_fmu()
    return _run_container(fmpy, folder / "brake.fmu", steps, h, ("y", "P", "F"))


def _run_container(fmpy: Any, fmu: Path, steps: int, h: float, names: tuple[str, ...]) -> Rows:
    run = fmpy.simulate_fmu(
        str(fmu), stop_time=steps * h, output_interval=h, output=names, validate=False
    )
    return [tuple(row) for row in zip(*(run[name][1:].tolist() for name in names), strict=True)]


# Values of the slider-belt at the start and, set by the host, after half of the steps: a belt that
# runs backward, and a tunable parameter. Outputs of such a run.
START, CHANGE = {"v_belt": -1.5, "mu_s": 0.9}, {"v_belt": -0.5, "k1": 150.0}
OUTPUTS = ("y", "P_max", "sticks")


def libcosim_tuned(folder: Path, steps: int, h: float) -> Rows:
    """Run the slider-belt alone in libcosimpy, and change an input and a tunable parameter."""
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimManipulator import CosimManipulator
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    execution = CosimExecution.from_step_size(round(h * 1e9))
    fmu = str(folder / f"{_SLIDER_BELT}.fmu")
    execution.add_local_slave(CosimLocalSlave(fmu_path=fmu, instance_name=_SLIDER_BELT))
    slider = execution.slave_index_from_instance_name(_SLIDER_BELT)
    references = {v.name.decode(): v.reference for v in execution.slave_variables(slider)}
    observer, setter = CosimObserver.create_last_value(), CosimManipulator.create_override()
    execution.add_observer(observer)
    execution.add_manipulator(setter)
    execution.boolean_initial_value(slider, references["finite_belt"], True)
    for name, value in START.items():
        execution.real_initial_value(slider, references[name], value)
    rows: Rows = []
    for step in range(steps):
        if step == steps // 2:
            setter.slave_real_values(slider, [references[n] for n in CHANGE], list(CHANGE.values()))
        assert execution.step()
        values = observer.last_real_values(slider, [references[name] for name in OUTPUTS])
        rows.append(tuple(values))
    return rows


def ecos_tuned(folder: Path, steps: int, h: float) -> Rows:
    """Run the slider-belt alone in ecospy, and change an input and a tunable parameter."""
    from ecospy import EcosSimulation, EcosSimulationStructure
    from ecospy.EcosParameterSet import EcosParameterSet

    structure, values = EcosSimulationStructure(), EcosParameterSet()
    structure.add_model(_SLIDER_BELT, str(folder / f"{_SLIDER_BELT}.fmu"))
    values.add_bool(f"{_SLIDER_BELT}::finite_belt", True)
    for name, value in START.items():
        values.add_real(f"{_SLIDER_BELT}::{name}", value)
    structure.add_parameter_set("start", values)
    simulation = EcosSimulation(step_size=h, structure=structure)
    simulation.init(parameter_set="start")
    rows: Rows = []
    for step in range(steps):
        for name, value in CHANGE.items() if step == steps // 2 else ():
            simulation.set_real(f"{_SLIDER_BELT}::{name}", value)
        simulation.step()
        rows.append(tuple(simulation.get_real(f"{_SLIDER_BELT}::{name}") for name in OUTPUTS))
    simulation.terminate()
    return rows


HOSTS = (libcosim, libcosim_ssp, ecos, ecos_ssp, container, container_ssp)
TUNED_HOSTS = (libcosim_tuned, ecos_tuned)


def main() -> None:
    """Run the named host."""
    run = {host.__name__: host for host in (*HOSTS, *TUNED_HOSTS)}[sys.argv[1]]
    rows = run(Path(sys.argv[2]), int(sys.argv[3]), float(sys.argv[4]))
    print("\n" + json.dumps(rows), flush=True)
    # Threads of ecos may still run, and crash a process that unloads its libraries.
    os._exit(0)


if __name__ == "__main__":
    main()
