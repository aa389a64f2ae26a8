"""The FMU's side: what the host calls. Standard library and pythonfmu only."""
