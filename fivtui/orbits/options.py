"""Options of ``fivtui branch``."""

from fivtui.model import PARAMETERS
from fivtui.options import flag, option, options_class
from fivtui.transient import setting


@options_class
class BranchOptions:
    """Options of ``fivtui branch``."""

    # If given, the scene that is computed has `separation` False.
    ignore_separation: bool = setting("separation")
    vary: str | None = option(
        "--vary",
        "The parameter, and its range; a tenth to ten times its value if not given.",
        metavar="NAME[=LOW:HIGH]",
        completions=lambda: (f"{name}=" for name in PARAMETERS),
    )
    origin: str | None = option(
        "--from",
        "Begin at the Hopf point nearest to the scene's value (the default), at a limit cycle that "
        "its transients reach, or at a cycle in a file: a branch, or attractors as JSON.",
        metavar="hopf|cycle|FILE",
    )
    doubled: bool = flag(
        "--doubled",
        "Follow the branch of twice the period that begins at the first period doubling instead.",
    )
    curve: str | None = option(
        "--curve",
        "Follow Hopf points, folds or cycles that just reach y = 0, where contact ends, over two "
        "parameters instead.",
        metavar="hopf|fold|touch",
    )
    over: tuple[str, ...] = option(
        "--over",
        "A parameter of --curve, and its range; give it twice.",
        metavar="NAME[=LOW:HIGH]",
        multiple=True,
        completions=lambda: (f"{name}=" for name in PARAMETERS),
    )
