"""From a law and a criterion to a proved formula, its fast function, and both as text of other languages.

`proof` and `finding` come first, then `average`, which knows all of one profile under one criterion,
`evaluation`, `code`, `slope_average` and `closed_form`, the sum of averages; each imports from those before it and
from the folders below: `core`, `output`, `numerics`, `model` and `criteria`.
"""
