"""The slider-belt model as an FMU for co-simulation (FMI 2.0), and its builder."""
