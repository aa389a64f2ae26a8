"""Building FMUs: export, description, documentation, SSP archive."""
