"""The slider-belt model: parameters, contact law, motion, equilibrium. Standard library only."""
