"""How formulas and results look: text, LaTeX, HTML, tables, files, pictures; no physics.

Imports `core`. One more function that formulas may hold is a row of `core.functions`.
"""
