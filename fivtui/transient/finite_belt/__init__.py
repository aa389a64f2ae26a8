"""RK4 and SciPy's solvers on a belt of finite speed."""
