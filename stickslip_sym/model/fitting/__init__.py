"""Friction laws fitted to measurements by least squares, with what the measurements do not determine.

Imports `core`, `output`, and of `model` the law and the measurements.
"""
