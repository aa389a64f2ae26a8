"""Building FMUs: export, model description, documentation, SSP archive."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .builder import IMPORT_LOCK, build_fmu
    from .native import native_failure
    from .ssp import build_ssp
else:
    from fivtui.lazy import lazy_exports

    __getattr__, __dir__ = lazy_exports(__name__)
