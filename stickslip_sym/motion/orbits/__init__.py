"""Periodic slip: what damping an orbit needs, and the limit cycles at a damping.

`needed` follows both halves of an orbit in time, `damping` resolves that over the amplitude, and `cycles` reads
the limit cycles from it. Without integration in time there are `expansion`, for weak friction, and `orbit`, by
collocation.
"""
