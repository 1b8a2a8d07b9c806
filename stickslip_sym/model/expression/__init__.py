"""A formula in v as the user writes it: read by a whitelist, its pieces, its parameters and their units.

Imports `core` and `output`. One more spelling of a function is an entry in `spelling`.
"""
