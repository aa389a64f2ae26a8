"""Files and tables: locked, atomic, with units and provenance."""
