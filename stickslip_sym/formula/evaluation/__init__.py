"""Formulas as functions that stay accurate at the extremes: branches, series, tables, exact values.

One more kind of branch is one class with the protocol `branches.Branch`.
"""
