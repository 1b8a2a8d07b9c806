"""Many starts of one law in one scene, all at once, event by event as `simulation` follows one.

It imports from `motion/simulation`. One more number of a motion, beside its extremes and its events, is a field of
`result.Ensemble`, noted in `log` where `slips` and `course` note those.
"""
