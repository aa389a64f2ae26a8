"""The compiled kernels: everything here needs numba and is imported by `compiled` alone.

`jit` compiles and caches; `vectors` adds SIMD vectors to numba; `expansion` turns the recurrences
into machine code, one set or eight sets at a time; `polynomials` isolates roots; `single` runs one
transient, `lanes` eight.
"""
