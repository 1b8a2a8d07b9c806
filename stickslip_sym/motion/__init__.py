"""What the oscillator does, by computations that share nothing with closed forms.

Its packages are `kernel`, `simulation`, `orbits`, `thresholds`, `margins`, `regimes` and `maps`, each importing
from those before it and from `core`, `output`, `numerics`, `model` and `criteria`. From `formula` comes one thing:
`thresholds.averages` takes the value of a criterion by its fast function, `formula.slope_average`.
"""
