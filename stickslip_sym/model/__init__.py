"""What the user describes: a friction law, measured points, an oscillator, the catalogue of laws.

Imports `core`, `output` and its own room `expression`. One more law of the catalogue is one entry in `laws`.
"""
