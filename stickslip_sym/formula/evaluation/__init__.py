"""Formulas as functions that stay accurate at the extremes.

`branch_builder` fits branches to the values of `reference_average` in ball arithmetic, `branches` evaluates them,
`term_function` puts a law's parameters into them, and `term_sum` holds the terms of a law.

What a law and its averages do at rest and far out is answered by series of the whole formula, in one algebra,
`model.formula_algebra`, over three kinds of numbers:

- `model.leading_terms`: a few terms with letters for the parameters: limits of mu, of its slope and of a
  criterion, what is finite together, what is integrable.
- `model.taylor_model`: many terms with balls and a bound on what they leave out: balls and floats near rest.
- `generalised_series`: many terms with balls, and what an average makes of them: its branches at both ends, which
  balls confirm.

`criteria.decay` bounds what has no series there, as exp(-g/v).
"""
