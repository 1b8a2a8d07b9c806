"""Motions over a plane of two quantities, or of initial conditions."""
