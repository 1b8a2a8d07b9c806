"""The damping that separates stick-slip from slip, what it depends on, and its standard error.

One more method is one entry in `methods`; one outside the package is `methods.add_method(Method(...))`.
"""
