"""The paper's figures and claims, computed from the model.

`families` lists the scenes of every figure, `results` computes them once, `export` writes the
figures, and `claims` compares the paper's statements with the model.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .amplitudes import Amplitude as Amplitude
    from .claims.check import CLAIMS as CLAIMS, check_claims as check_claims
    from .claims.claim import CheckedClaim as CheckedClaim, Claim as Claim
    from .claims.report import claims_markdown as claims_markdown
    from .data import (
        DATA_COLUMNS as DATA_COLUMNS,
        FigureData as FigureData,
        FloatArray as FloatArray,
    )
    from .export import (
        DEFAULT_FORMATS as DEFAULT_FORMATS,
        figure_numbers as figure_numbers,
        figures as figures,
        save_figures as save_figures,
    )
    from .families import PANELS as PANELS, SEPARATION as SEPARATION, Panel as Panel
    from .kinds import PanelOf as PanelOf
    from .results import PaperResults as PaperResults
    from .tables import critical_mu as critical_mu, modes as modes
else:
    from fivtui.lazy import lazily

    __getattr__, __dir__ = lazily(__name__)
