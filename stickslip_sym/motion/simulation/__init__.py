"""Slip and stick, event by event: steps, phases, engines, trajectories.

One more engine is one class, an `engines.Engine`, and an entry in `engines.ENGINES`.
"""
