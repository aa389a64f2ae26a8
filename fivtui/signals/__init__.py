"""Signals of a run: the motion at any time, spectra and sound."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .audio import check_sound_path, sound
    from .charts import frequency_range, spectrum_chart
    from .motion import check_window, last_cycles, motion_at, period_of
    from .spectra import Spectrum, spectrum
else:
    from fivtui.lazy import lazy_exports

    __getattr__, __dir__ = lazy_exports(__name__)
