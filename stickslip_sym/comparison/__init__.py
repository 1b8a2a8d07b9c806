"""Every method for a number beside the others: its cost and its error.

Imports all folders but `cli`. One more method is one row of `tradeoff`; one more part of the page is computed
in `study`, kept by `Study`, and shown by its template.
"""
