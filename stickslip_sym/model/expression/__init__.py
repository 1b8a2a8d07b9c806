"""A formula in v as the user writes it: read by a whitelist, its pieces, its parameters and their units.

Imports `core` and `output`. What people type for a function or a sign is an entry in `parsing`.
"""
