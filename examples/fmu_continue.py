"""Continue a run: save a state as bytes, and start several instances from it.

Run it as ``python examples/fmu_continue.py``.
"""

import tempfile
from pathlib import Path

from fmpy import extract, instantiate_fmu, read_model_description, simulate_fmu

from fmu_src.build.builder import build_fmu


def main() -> None:
    """Settle for 60 s once, then press harder or more softly from there."""
    with tempfile.TemporaryDirectory() as folder:
        fmu = str(build_fmu(Path(folder) / "slider_belt.fmu"))
        files = extract(fmu, Path(folder) / "extracted")
        description = read_model_description(files)
        instance = instantiate_fmu(files, description)
        options = {"set_stop_time": False, "terminate": False}
        simulate_fmu(fmu, stop_time=60.0, fmu_instance=instance, **options)
        saved = instance.serializeFMUState(instance.getFMUState())
        instance.freeInstance()
        for F in (60.0, 80.0, 120.0):
            continued = instantiate_fmu(files, description)
            continued.setFMUState(continued.deserializeFMUState(saved))
            names = {v.name: v.valueReference for v in description.modelVariables}
            continued.setReal([names["F"]], [F])
            continued.doStep(60.0, 40.0)
            y, count = continued.getReal([names["y"], names["separations"]])
            print(f"F {F:5.0f} N from 60 s on: y(100 s) {y:9.5f} m, separations {count:.0f}")
            continued.freeInstance()


if __name__ == "__main__":
    main()
