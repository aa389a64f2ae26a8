"""Many transients at once."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .result import Batch as Batch, BatchAmplitude as BatchAmplitude, BatchPeak as BatchPeak
    from .run import Requirement as Requirement, simulate_batch as simulate_batch
else:
    from fivtui.lazy import lazily

    __getattr__, __dir__ = lazily(__name__)
