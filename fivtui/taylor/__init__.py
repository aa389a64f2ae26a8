"""The Taylor integrator in plain floats. Standard library only."""
