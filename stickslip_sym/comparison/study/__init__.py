"""Everything about one operating point, as a page to take to a meeting.

Imports all folders but `cli`. One more part is computed in `study`, kept by `Study`, and shown by `page` in
its template.
"""
