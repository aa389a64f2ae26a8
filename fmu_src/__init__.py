"""The slider-belt model and a brake actuator as FMUs for co-simulation, and their builder."""
