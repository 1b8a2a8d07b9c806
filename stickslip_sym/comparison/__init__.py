"""Every method for a number beside the others: its cost and its error.

Imports all folders but `cli`. One more method is one `Candidate` of `tradeoff`.
"""
