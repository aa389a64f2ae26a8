"""How far to trust a run: error estimates, Lyapunov exponents, stress tests."""
