"""The damping that parts stick-slip from slip, and the belt speed at which it is the given one.

One more way to a threshold is one entry in `rungs`; one outside the package is `rungs.add(Rung(...))`.
"""
