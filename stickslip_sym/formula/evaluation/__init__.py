"""Formulas as functions that stay accurate at the extremes: `making` fits branches to `values` in ball arithmetic.

`branches` evaluates them, `term_function` puts a law's parameters into them, and `term_sum` holds the terms of a
law.
"""
