"""Formulas as functions that stay accurate at the extremes: `making` fits branches to `values` in ball arithmetic.

`branches` evaluates them, and `evaluator` adds up the terms of a law.
"""
