"""Instances of an extracted FMU in this process, through fmpy, accessed by variable names."""

from pathlib import Path
from typing import Any, Self

import fmpy


class FmuInstance:
    """One instance of the native FMU, which is compiled from C; freed when its context ends.

    `kind` is ``"CoSimulation"`` or ``"ModelExchange"``. `fmi` is fmpy's instance; `log` lists the
    messages of the FMU.
    """

    def __init__(self, folder: Path, kind: str = "CoSimulation") -> None:
        self.log: list[str] = []
        self.description = fmpy.read_model_description(str(folder))
        self.references = {v.name: v.valueReference for v in self.description.modelVariables}
        self.fmi: Any = fmpy.instantiate_fmu(
            str(folder),
            self.description,
            fmi_type=kind,
            debug_logging=True,
            logger=lambda *args: self.log.append(args[-1].decode()),
        )
        self.t = 0.0

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.fmi.freeInstance()

    def set(self, **values: float | bool) -> None:
        """Set parameters and inputs."""
        for name, value in values.items():
            kind = "Boolean" if isinstance(value, bool) else "Real"
            getattr(self.fmi, f"set{kind}")([self.references[name]], [value])

    def get(self, *names: str) -> list[float]:
        """Values of variables."""
        values: list[float] = self.fmi.getReal([self.references[name] for name in names])
        return values

    def begin(self, *, tol: float | None = None, **values: float | bool) -> Self:
        """Set values and complete the initialization."""
        self.set(**values)
        self.fmi.setupExperiment(tolerance=tol)
        self.fmi.enterInitializationMode()
        self.fmi.exitInitializationMode()
        return self

    def step(self, h: float) -> None:
        """Advance by one communication step of `h` seconds."""
        self.fmi.doStep(self.t, h)
        self.t += h

    def update_mode(self) -> bool:
        """Update the mode of the slider, in FMI's event mode; return whether the states changed."""
        _, _, _, has_changed_states, *_ = self.fmi.newDiscreteStates()
        return bool(has_changed_states)

    def set_slopes(self, **rates: float) -> None:
        """Set the first derivatives of inputs for the next step."""
        references = [self.references[name] for name in rates]
        self.fmi.setRealInputDerivatives(references, [1] * len(rates), list(rates.values()))
