"""Slip and stick, event by event: steps, phases, engines, trajectories.

One more engine is one function with the signature of `slip.follow`, and an entry in `engines`.
"""
