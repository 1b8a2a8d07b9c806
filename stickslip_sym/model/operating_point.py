"""The operating point of the paper's section 3: what is taken where none is given."""

PAPER = {"V": "0.5", "N": "9.81", "m": "1", "k": "100"}
"""Belt speed, normal force, mass and stiffness in SI units, as exact decimals."""

LOW_SPEED = "0.05"
"""A belt speed in m/s at which the ways to a criterion differ."""
