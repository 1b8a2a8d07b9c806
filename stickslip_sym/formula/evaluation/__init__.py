"""Formulas as functions that stay accurate at the extremes.

`branch_builder` fits branches to the values of `reference_average` in ball arithmetic, `branches` evaluates them,
`term_function` puts a law's parameters into them, and `term_sum` holds the terms of a law.

What a law and its averages do at rest and far out is asked in five places, each of its own question:

- `model.taylor_model`: how a formula with numbers is expanded, by the one algebra `ExpansionAlgebra`; and there
  its smooth series with a bound on what that leaves out, for mu(0+), slopes, balls and floats near rest, and which
  terms cancel.
- `generalised_series`: by the same algebra, with logarithms and fractional powers, also far out, without a bound:
  branches of an average at both ends, which balls confirm.
- `criteria.decay`: how fast a term falls that has no series, as exp(-g/v), and bounds of it.
- `model.limit_at_rest`: a limit by rules of SymPy, where no parameter has a value, or no series exists.
- `formula.limits`: what a criterion tends to, with letters for the parameters.
"""
