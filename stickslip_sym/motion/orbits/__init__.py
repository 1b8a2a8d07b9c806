"""Periodic slip without integration in time: expansion for weak friction, and collocation."""
