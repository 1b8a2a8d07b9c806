"""What was measured: one reader of friction measurements, and the laws through measured points.

Imports `core`, `output` and `model.samples`. One more unit or word of a header is an entry in `columns`.
"""
