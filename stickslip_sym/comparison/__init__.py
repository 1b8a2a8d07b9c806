"""Every way to a number beside the others: its cost and its error.

Imports all folders but `cli`. One more way is one entry of `tradeoff` or `threshold_tradeoff`.
"""
