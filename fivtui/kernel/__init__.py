"""The compiled kernel: the same integrator as `fivtui.taylor` in C, one run or many side by side.

`native` loads it, `runs`, `lanes` and `in_turn` are runs under way. The text in C: `vector.h` (one
run or LANES of them), `field.h` (the equations, made by `field_text`), `expansion.h` (the
recurrences), `polynomial.h` and `roots.h` (bounds,
roots), `motion.h` (a step and its mode), `search.h` (first switches, extremes), `problem.h`,
`run.h` (a step of one run), `output.h`, `friction.h` (the friction law), `belt.h` (modes and guards
on a belt of finite speed), `driven.h` (the same while parameters change with time), `belts.h`
(blocks of belts), `deviations.h` (the variational equations), and five loops: `single.c`, `belt.c`
(one run on a belt of finite speed, or over tables), `vary.c` (one run with its derivatives),
`lanes.c` and `belt_lanes.c`, which share `lanes.h`; `orbit.c` closes runs to periodic orbits.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .driven import legs_of
    from .field_text import FLAGS, headers
    from .native import Kernel, load_kernel, stepping_kernel, why_interpreted
    from .orbits import OrbitSearch, Varied
    from .runs import SEGMENT_HEAD, BeltRun, KernelRun, RunColumns, VariedRun
    from .status import Status
else:
    from fivtui.lazy import lazily

    __getattr__, __dir__ = lazily(__name__)
