"""Scenes that several test files use."""

import stickslip_sym as ss

TWO = ss.FrictionLaw("0.4 - 0.3*(v - 0.5) - 2*(v - 0.5)^3 + 8*(v - 0.5)^5")  # mu' about V = 0.5 in even powers


def paper_oscillator(c=0.0, **changes):
    """Return the oscillator of the paper's section 3."""
    return ss.Oscillator(**({"m": 1.0, "k": 100.0, "c": c, "V": 0.5, "N": 9.81} | changes))
