"""The paper's figures and claims, computed from the model.

`panels` lists the scenes of every figure, `results` computes them once, `export` writes the
figures, and `claims` compares the paper's statements with the model.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .amplitudes import Amplitude
    from .charts import figure_charts
    from .claims.check import CLAIMS, check_claims
    from .claims.claim import CheckedClaim, Claim
    from .claims.report import claims_markdown, verdict_counts
    from .data import FloatArray
    from .export import DEFAULT_FORMATS, figure_numbers, figures, save_figures
    from .kinds import ComputedPanel
    from .panels import PANELS, SEPARATION, Panel
    from .results import PaperResults
    from .tables import critical_mu, modes
else:
    from fivtui.lazy import lazy_exports

    __getattr__, __dir__ = lazy_exports(__name__)
