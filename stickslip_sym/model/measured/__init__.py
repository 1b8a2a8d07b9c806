"""What was measured: one reader of friction measurements, and the laws through measured points.

Imports `core` and `output`. One more unit or word of a header is an entry in `columns`.
"""
