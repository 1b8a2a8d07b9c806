"""How formulas are written, and what results are handed over as: text, LaTeX, tables, data, files; no physics.

Imports `core`. One more function that formulas may hold is a row of `core.functions`.
"""
