"""Motions from initial conditions: `simulate`, its reference by SciPy, and the stick-slip cycle."""
