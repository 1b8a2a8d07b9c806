"""Motions over a plane of two quantities, or of initial conditions.

`motions` and `basins` are the two maps, `sweep` follows the basins over a quantity, and `cells` decides many cells
at once.
"""
