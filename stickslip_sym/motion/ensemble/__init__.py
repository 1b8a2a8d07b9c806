"""Many starts of one law in one scene, all at once, event by event as `simulation` follows one.

Imported from it is `ensemble` alone, which imports from `motion/simulation`. One more number of a motion, beside its
extremes and its events, is a field of `result.Ensemble`, noted where `slips` or `course` notes those.
"""
