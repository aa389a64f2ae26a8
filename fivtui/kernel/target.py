"""The processor that kernels are compiled for."""

from typing import Final

from numba.core import config
from numba.core.codegen import get_host_cpu_features

# LLVM's names of what fuses a product and a sum of float64: x86 has an extension, ARM the basis.
_FUSING: Final = {"+fma", "+fma4", "+fp-armv8"}


def fuses() -> bool:
    """Whether the products and sums of kernels become fused operations, rounded once."""
    given: str | None = config.CPU_FEATURES  # type: ignore[attr-defined]
    features = get_host_cpu_features() if given is None else given
    return not _FUSING.isdisjoint(features.split(","))
