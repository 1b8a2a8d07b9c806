"""Motions over a plane of two quantities, or of starts: cells, axes, workers, checkpoints, pictures.

One more reason by which a cell is decided is a member of `Reason` in `cells`.
"""
