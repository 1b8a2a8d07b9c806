"""The damping that separates stick-slip from slip, what it depends on, and its standard error.

One more way to a threshold is one entry in `rungs`; one outside the package is `rungs.add(Rung(...))`.
"""
