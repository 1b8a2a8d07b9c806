"""What was measured: one reader of friction measurements, and the fit of a friction law to them.

Imports `core`, `output` and `model/expression`; a law comes in as a `FittedLaw`, which `FrictionLaw` is. One more
unit is an entry in `units`, one more word of a header an entry in `headers`.
"""
