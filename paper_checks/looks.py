"""Looks of lines: what the paper shows is black; what it leaves out is coloured, and thicker or dash-dotted."""

from stickslip_sym.output.drawing import BLUE

__all__ = ["LEFT_OUT", "PAPER"]

PAPER = {"color": "black", "linewidth": 1.1}
LEFT_OUT = {"color": BLUE, "linewidth": 1.3, "linestyle": (0, (6, 1.5, 1, 1.5))}
