"""The compiled kernels: everything here needs numba and is imported by `compiled` alone.

`jit` compiles and caches; `vectors` adds SIMD vectors to numba; `expansion` turns the recurrences
into machine code, one set or eight sets at a time; `linear_tables` does without them where the
motion is linear; `polynomials` isolates roots, of which `bounds` spares most; `single` runs one
transient, `lanes` many, with its parts in the modules `lane_…` and its memory in `rows`.
"""

import os

# Where colorama is installed numba would colour its messages, and for that exchange sys.stdout in
# the middle of compiling, which other threads are writing to.
os.environ.setdefault("NUMBA_DISABLE_ERROR_MESSAGE_HIGHLIGHTING", "1")
