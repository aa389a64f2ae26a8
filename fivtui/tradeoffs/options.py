"""Options of ``fivtui tradeoff``.

`setting` declares the option that sets a field of the scene, such as --t-end.
"""

from fivtui.options import flag, options_class
from fivtui.transient import setting


@options_class
class TradeoffOptions:
    """Options of ``fivtui tradeoff``."""

    ignore_separation: bool = setting("separation")
    t_end: str | None = setting("t_end")
    start: str | None = setting("start")
    thorough: bool = flag(
        "--thorough", "More settings: about two minutes instead of seven seconds."
    )
    # The option --error QUANTITY=R: here it sets nothing in the scene, whose error targets
    # (`accuracy`) it sets in other commands; it only adds a line to the report.
    targets: tuple[str, ...] = setting(
        "accuracy",
        "Error target: name the cheapest setting whose error of QUANTITY is below R. QUANTITY: "
        "final (state), peak, half_range (half peak-to-peak over the second half of the run) or "
        "events (times of separation and reattachment, s).",
        for_scene=False,
    )
