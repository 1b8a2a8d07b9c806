"""Everything about one operating point, as a page to take to a meeting.

Imports all folders but `cli`. One more part is computed in `parts`, kept by `Findings`, and written in `sections`.
"""
