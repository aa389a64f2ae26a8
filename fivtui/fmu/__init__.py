"""The FMU's host: instances, the co-simulation master, runs and checks."""
